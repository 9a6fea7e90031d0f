"""Bodies are dragged, turned, moved by keys and added in the scene, while the run is paused or goes on."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, hypot, pi, sin

import pytest
from browsing import Watched, box_of, drawn, seen
from playwright.sync_api import Page, expect
from visitors import Cockpit, cockpit

AZIMUTH = -2.2
"""From where the scene is seen at first, rad."""


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit() as opened:
        yield opened


@pytest.fixture
def page(opened: Cockpit, watched: Watched) -> Page:
    """A page on which bodies are edited, with the robot in the middle of the scene."""
    page = watched.open(opened.address)
    page.get_by_role("button", name="Edit the room").click()
    drawn(page)
    page.get_by_role("region", name="Selected").get_by_role("button", name="husky", exact=True).click()
    page.keyboard.press("f")
    drawn(page)
    return page


def place(opened: Cockpit, body: str) -> tuple[float, float]:
    return opened.run.world.model_motion(body).pose.position[:2]


def yaw(opened: Cockpit, body: str) -> float:
    return opened.run.world.model_motion(body).pose.rpy[2]


def names(opened: Cockpit) -> set[str]:
    return {model.name for model in opened.run.world.scene.models}


def drag(page: Page, dx: float, *keys: str) -> None:
    """Drag the middle of the scene to the right."""
    box = box_of(page.get_by_role("application", name="The scene in three dimensions"))
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for key in keys:
        page.keyboard.down(key)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx / 2, y, steps=3)
    page.mouse.move(x + dx, y, steps=3)
    expect(page.locator(".scene-drag")).to_contain_text("m, y")
    page.mouse.up()
    for key in keys:
        page.keyboard.up(key)


def test_a_body_is_dragged_turned_and_put_back(opened: Cockpit, page: Page) -> None:
    begin = place(opened, "husky")
    drag(page, 120.0)
    now = seen(page, lambda: place(opened, "husky"), lambda now: now != begin)
    moved = now[0] - begin[0], now[1] - begin[1]
    right = moved[0] * -sin(AZIMUTH) + moved[1] * cos(AZIMUTH)
    assert 0.1 < right == pytest.approx(hypot(*moved), rel=0.02)
    expect(page.get_by_role("toolbar").get_by_role("status")).to_contain_text(
        f"x {now[0]:.2f} m, y {now[1]:.2f}"
    )
    page.keyboard.press("f")
    drawn(page)
    before = yaw(opened, "husky")
    drag(page, 50 * pi, "Shift")  # a hundredth of a radian a pixel
    seen(page, lambda: yaw(opened, "husky"), lambda now: cos(now - before - pi / 2) > 0.999)
    for _ in range(2):
        page.get_by_role("button", name="Put husky back").click()
    seen(page, lambda: place(opened, "husky"), lambda now: now == pytest.approx(begin, abs=1e-3))
    expect(page.get_by_role("button", name="Undo", exact=True)).to_be_disabled()


def test_arrows_move_and_turn_the_selected_body_also_one_that_is_fixed(opened: Cockpit, page: Page) -> None:
    page.keyboard.press("Escape")
    selected = page.get_by_role("region", name="Selected")
    selected.get_by_role("button", name="north_plant", exact=True).click()
    begin, turned = place(opened, "north_plant"), yaw(opened, "north_plant")
    scene = page.get_by_role("application", name="The scene in three dimensions")
    scene.focus()
    for key in ("ArrowRight", "ArrowRight", "ArrowUp", "Shift+ArrowLeft"):
        page.keyboard.press(key)
    # seen from the south west, nearest to the south: right is east and up is north
    wanted = pytest.approx((begin[0] + 0.2, begin[1] + 0.1), abs=1e-3)
    seen(page, lambda: place(opened, "north_plant"), lambda now: now == wanted)
    seen(
        page, lambda: yaw(opened, "north_plant"), lambda now: now == pytest.approx(turned + pi / 36, abs=1e-3)
    )


def test_a_body_is_added_by_a_click_while_the_run_goes_on(opened: Cockpit, page: Page) -> None:
    page.get_by_role("button", name="Play").click()
    page.get_by_role("button", name="Add a body").click()
    page.get_by_role("menuitem", name="sphere").click()
    status = page.get_by_role("toolbar").get_by_role("status")
    expect(status).to_contain_text("Click where the sphere stands")
    scene = page.get_by_role("application", name="The scene in three dimensions")
    box = box_of(scene)
    scene.click(position={"x": box["width"] * 0.2, "y": box["height"] * 0.8})
    expect(page.get_by_role("region", name="Selected").get_by_role("heading", name="sphere")).to_be_visible()
    assert opened.run.world.model_motion("sphere").pose.position[2] == pytest.approx(0.2, abs=0.05)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Remove sphere").click()
    seen(page, lambda: names(opened), lambda there: "sphere" not in there)
    page.get_by_role("button", name="Add a body").click()
    page.get_by_role("menuitem", name="cylinder").click()
    page.keyboard.press("Escape")  # the scene has the focus
    page.get_by_role("button", name="Add a body").click()
    page.get_by_role("menuitem", name="box").click()
    page.keyboard.press("Enter")
    seen(page, lambda: names(opened), lambda there: {"box", "cylinder"} & there == {"box"})


def test_a_watcher_cannot_edit_the_room(opened: Cockpit, watched: Watched) -> None:
    address = opened.address.replace(opened.guard.token, opened.guard.watch_token)
    page = watched.open(address, ready=("timer", ""))
    expect(page.get_by_role("button", name="Edit the room")).to_be_disabled()
