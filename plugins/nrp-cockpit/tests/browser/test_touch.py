"""What people touch in the scene acts on the run."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import cycle, product
from pathlib import Path

import cv2
import numpy as np
import pytest
from browsing import Watched, box_of, seen, time_s, wait_until
from playwright.sync_api import Locator, Page, expect

VERMILLION, PURPLE = (0, 94, 213), (138, 85, 176)
"""Of contacts and of trails in the light theme, as OpenCV has them."""
ARRIVES = """
extends: braitenberg_husky/no_red
name: touched
criteria:
  turns_on_the_spot: null
  arrives:
    near: {model: husky, visual: right_vr_screen/body/screen_glass, within: 1.2 m}
"""


def select_in_scene(page: Page, model: str) -> None:
    """Click here and there in the scene until a model is selected; at first nothing may be there yet."""
    box = box_of(page.get_by_role("application", name="The scene in three dimensions", exact=False))
    heading = page.get_by_role("region", name="Selected").get_by_role("heading", name=model, exact=True)
    places = cycle(product((0.36, 0.39, 0.42, 0.45, 0.48), (0.28, 0.32, 0.36, 0.40, 0.44)))

    def is_hit() -> bool:
        x, y = next(places)
        page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
        return heading.is_visible()

    seen(page, is_hit)


def test_a_click_turns_a_screen_red_and_the_robot_drives_to_it(
    tmp_path: Path, in_process: Callable[..., str], watched: Watched
):
    file = tmp_path / "touched.yaml"
    file.write_text(ARRIVES)
    page = watched.open(in_process(experiment=str(file)), width=1600, height=1000)
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.3)
    select_in_scene(page, "right_vr_screen")
    page.get_by_role("region", name="Selected").get_by_text("Red", exact=True).click()
    page.get_by_role("slider", name="Pace").press("End")
    arrives = page.locator("[data-panel=timeline]").get_by_text("arrives")
    expect(arrives).to_be_visible()
    expect(page.get_by_text("passed", exact=False).first).to_be_visible()


def marked(page: Page, color: tuple[int, int, int], within: int = 12) -> int:
    """Return how many pixels of the scene have a colour, each channel within a difference."""
    canvas = page.get_by_role("application", name="The scene in three dimensions", exact=False)
    image = cv2.imdecode(np.frombuffer(canvas.screenshot(), np.uint8), cv2.IMREAD_COLOR).astype(int)
    return int((np.abs(image - color) < within).all(axis=2).sum())


def y_of(pose: Locator) -> float:
    return float(re.search(r"y\s*(-?[\d.]+) m", pose.inner_text()).group(1))  # type: ignore[union-attr]


@pytest.mark.heavy
def test_a_robot_is_put_elsewhere_and_pushed_stands_on_its_contacts_and_leaves_a_trail(
    husky: str, watched: Watched
):
    page = watched.open(husky, width=1600, height=1000)
    page.get_by_role("button", name="Step", exact=True).click()
    expect(page.get_by_role("timer")).to_contain_text("0.02 s")
    others = marked(page, VERMILLION)
    page.get_by_role("button", name="Contacts", exact=True).click()
    page.get_by_role("slider", name="Simulated time").press("PageUp")
    expect(page.get_by_role("timer")).to_contain_text("1.02 s")  # it has come down on its wheels
    page.get_by_role("button", name="Play").wait_for()
    # a point of 7 pixels at each wheel, some behind the label
    seen(page, lambda: marked(page, VERMILLION), lambda count: count > others + 4 * 10)
    select_in_scene(page, "husky")
    short = marked(page, PURPLE, within=40)  # a little of what is below shines through
    inspector = page.get_by_role("region", name="Selected")
    inspector.get_by_role("textbox", name="x (m)").fill("1.5")
    inspector.get_by_role("button", name="Place", exact=True).click()
    page.get_by_role("button", name="Step", exact=True).click()
    pose = inspector.get_by_role("region", name="Pose")
    expect(pose).to_contain_text("1.50")
    # a band from where it stood to x = 1.5 m
    long = seen(page, lambda: marked(page, PURPLE, within=40), lambda count: count > short + 40)
    page.get_by_role("button", name="Trail", exact=True).click()
    seen(page, lambda: marked(page, PURPLE, within=40), lambda count: count < long - 40)
    inspector.get_by_role("textbox", name="y (N)").fill("9000")
    inspector.get_by_role("button", name="Push", exact=True).click()
    before_m = y_of(pose)
    page.get_by_role("button", name="Play").click()
    wait_until(page, time_s(page) + 0.4)
    seen(page, lambda: y_of(pose), lambda y_m: y_m > before_m + 0.3)
