"""A run is watched and steered as people do it: by the names of controls, and by keys."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest
from browsing import HUSKY, Kept, Watched, box_of, drawn, seen, time_s, wait_until
from playwright.sync_api import expect
from visitors import cockpit

from nrp_core import brains

PAIRS: dict[tuple[str, str], tuple[str, ...]] = {
    ("event", "mujoco"): (),  # those of the experiment
    ("spinnaker", "pybullet"): ("--brain", "spinnaker", "--world", "pybullet"),
}


@pytest.mark.one_of(3)
@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_a_run_is_played_paused_stepped_and_reset(pair: tuple[str, str], kept: Kept, watched: Watched):
    page = watched.open(kept.open("braitenberg_husky", *HUSKY, *PAIRS[pair]))
    expect(page.get_by_text(pair[0], exact=True)).to_be_visible()
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.5)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    paused = time_s(page)
    page.wait_for_timeout(500)
    assert time_s(page) == paused
    page.get_by_role("button", name="Step", exact=True).click()
    expect(page.get_by_role("timer")).to_contain_text(f"{paused + 0.02:.2f} s")
    page.get_by_role("button", name="Step back").click()
    expect(page.get_by_role("timer")).to_contain_text(f"{paused:.2f} s")
    page.get_by_role("button", name="Reset").click()
    page.get_by_role("menuitem", name="Reset everything").click()
    expect(page.get_by_role("timer")).to_contain_text("0.00 s")


def test_the_keys_steer_a_run(husky: str, watched: Watched):
    page = watched.open(husky)
    page.keyboard.press(".")
    page.keyboard.press(".")
    expect(page.get_by_role("timer")).to_contain_text("0.04 s")
    page.keyboard.press(",")
    expect(page.get_by_role("timer")).to_contain_text("0.02 s")
    page.keyboard.press("Space")
    wait_until(page, 0.2)
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play").wait_for()
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_contain_text("Step back")
    page.keyboard.press("Escape")
    page.keyboard.press("2")
    expect(page.get_by_role("heading", name="Transfer functions").first).to_be_visible()


def test_space_plays_after_a_click_and_presses_a_button_that_keys_have_reached(husky: str, watched: Watched):
    page = watched.open(husky)
    step, play = (page.get_by_role("button", name=name, exact=True) for name in ("Step", "Play"))
    step.click()
    page.keyboard.press("Space")
    wait_until(page, 0.1)
    page.keyboard.press("Space")
    play.wait_for()
    page.get_by_role("button", name="Reset", exact=True).click()
    page.get_by_role("menuitem", name="Reset everything").click()
    expect(page.get_by_role("timer")).to_contain_text("0.00 s")
    page.keyboard.press("Space")
    wait_until(page, 0.1)
    expect(page.get_by_role("menu")).to_have_count(0)
    page.keyboard.press("Space")
    play.wait_for()
    paused = time_s(page)
    play.focus()
    page.keyboard.press("Tab")
    page.keyboard.press("Space")
    expect(page.get_by_role("timer")).to_contain_text(f"{paused + 0.02:.2f} s")


def test_a_fit_shows_the_selected_body_and_the_wheel_zooms_to_the_pointer(husky: str, watched: Watched):
    page = watched.open(husky)
    scene = page.get_by_role("application", name="The scene in three dimensions")
    selected = page.get_by_role("region", name="Selected")
    drawn(page)
    selected.get_by_role("button", name="north_plant", exact=True).click()
    page.keyboard.press("f")
    drawn(page)
    where = box_of(scene)
    middle = {"x": where["width"] / 2, "y": where["height"] / 2}
    page.keyboard.press("Escape")
    scene.click(position=middle)
    expect(selected.get_by_role("heading", name="north_plant")).to_be_visible()
    scene.hover(position={"x": middle["x"] * 1.5, "y": middle["y"] * 0.3})
    for _ in range(8):
        page.mouse.wheel(0, -240)  # towards what is beside the plant
    page.keyboard.press("Escape")

    def is_beside() -> bool:  # the last turns of the wheel may still be on their way
        scene.click(position=middle)
        return selected.get_by_role("heading", name="north_plant").count() == 0

    seen(page, is_beside)


def test_two_pages_show_one_run_and_a_watcher_cannot_steer(husky: str, watched: Watched):
    address = husky
    first, second = watched.open(address), watched.open(address)
    first.get_by_role("button", name="Play").click()
    wait_until(second, 0.3)
    second.get_by_role("button", name="Pause").click()
    first.get_by_role("button", name="Play").wait_for()
    expect(first.get_by_text("2 viewers", exact=False)).to_be_attached()


USUAL = {
    ("slalom_pioneer", "event", "mujoco"),
    ("walking_hexapod", "event", "pybullet"),
    ("following_head", "spinnaker", "mujoco"),
}
OPENINGS = [
    pytest.param(*names, marks=() if names in USUAL else pytest.mark.heavy)
    for names in product(
        ("slalom_pioneer", "walking_hexapod", "following_head"),
        ("event", "spinnaker"),
        ("mujoco", "pybullet"),
    )
]


@pytest.mark.parametrize(("experiment", "brain", "world"), OPENINGS)
def test_every_experiment_opens_and_runs_on_every_pair_without_a_complaint(
    experiment: str, brain: str, world: str, watched: Watched
):
    with cockpit(f"brain.backend={brain}", f"world.backend={world}", experiment=experiment) as opened:
        page = watched.open(opened.address, width=1280, height=720)
        page.get_by_role("button", name="Play").click()
        wait_until(page, 0.1)
        shown = page.get_by_role("banner")
        expect(shown).to_contain_text(brain)
        expect(shown).to_contain_text(world)
        for panel in ("Scene", "From above", "Brain", "Spikes", "Devices and topics"):
            expect(page.get_by_role("region", name=panel, exact=False).first).to_be_visible()


def test_a_run_that_cannot_be_saved_says_why_it_cannot_go_back(
    watched: Watched, monkeypatch: pytest.MonkeyPatch
):
    backend = type(brains().load("event"))
    able = backend.capabilities
    monkeypatch.setattr(
        backend, "capabilities", lambda self, options: replace(able(self, options), snapshot=False)
    )
    reason = "the brain 'event' cannot save and restore its state"
    with cockpit() as opened:
        page = watched.open(opened.address, width=1280, height=720)
        page.get_by_role("slider", name="Simulated time").press("PageUp")
        expect(page.get_by_role("timer")).to_contain_text("1.00 s")
        back = page.get_by_role("button", name="Step back")
        expect(back).to_be_disabled()
        page.get_by_role("button", name="Play").focus()
        page.keyboard.press("Shift+Tab")  # a button that cannot be used is reached, to read the reason
        expect(page.get_by_role("tooltip")).to_contain_text(reason)
        back.click(force=True)
        page.get_by_role("slider", name="Simulated time").press("Home")
        page.get_by_role("link", name="Compare", exact=True).click()
        expect(page.get_by_role("button", name="Branch at 1.00 s")).to_be_disabled()
        expect(page.get_by_role("timer")).to_contain_text("1.00 s")


def test_an_error_in_one_panel_leaves_the_others_and_can_be_tried_again(watched: Watched):
    with cockpit() as opened:
        page = watched.open(opened.address)
        brain = page.get_by_role("region", name="Brain", exact=True)
        expect(brain).to_contain_text("8 cells")
        described = opened.session.ask(opened.session.reports._experiment_data)
        opened.session.hub.send_json("/cockpit/experiment", {**described, "devices": [{"neurons": None}]})
        expect(brain.get_by_role("alert")).to_contain_text("error of the page")
        for panel in ("Scene", "Camera", "From above"):
            expect(page.get_by_role("region", name=panel, exact=True)).to_be_visible()
        page.get_by_role("button", name="Step", exact=True).click()
        expect(page.get_by_role("timer")).to_contain_text("0.02 s")
        opened.session.hub.send_json("/cockpit/experiment", described)
        brain.get_by_role("button", name="Try again").click()
        expect(brain).to_contain_text("8 cells")
        assert watched.complaints  # of the error
        watched.complaints.clear()
