"""Panels are added, split, closed and moved, also several of a kind; what a run lacks is not shown."""

from __future__ import annotations

from pathlib import Path

import pytest
from browsing import HUSKY, Kept, Watched, box_of, seen
from nrp_cockpit.session.layout import SUFFIX, own_layout
from playwright.sync_api import Locator, Page, expect
from stories import FONTS, STYLED, Stories, settled
from visitors import cockpit


@pytest.fixture(scope="module")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An experiment in a folder of its own, where the preset is kept."""
    file = tmp_path_factory.mktemp("arranged") / "arranged.yaml"
    file.write_text("extends: braitenberg_husky\nname: arranged\n")
    return file


@pytest.fixture
def opened(experiment: Path, kept: Kept, watched: Watched) -> Page:
    """A page with the usual layout."""
    own_layout(experiment.with_suffix(SUFFIX)).unlink(missing_ok=True)
    page = watched.open(kept.open(str(experiment), *HUSKY))
    expect(page.get_by_role("img", name="Curves of linear.x, angular.z")).to_be_visible()
    return page


def panel(page: Page, name: str) -> Locator:
    return page.get_by_role("region", name=name, exact=True)


def choose(page: Page, button: str, item: str) -> None:
    page.get_by_role("button", name=button, exact=True).click()
    page.get_by_role("menuitem", name=item, exact=True).click()


def test_a_panel_is_split_by_keys_and_each_shows_what_is_chosen_in_it(opened: Page, experiment: Path):
    place = opened.get_by_role("button", name="Place of Spikes", exact=True)
    place.press("Enter")
    opened.keyboard.press("ArrowDown")
    opened.keyboard.press("Enter")  # the second item: to the right
    first, second = panel(opened, "Spikes"), panel(opened, "Spikes 2")
    expect(second.get_by_role("heading", name="Spikes 2")).to_be_visible()
    seen(opened, lambda: box_of(first)["width"] - box_of(second)["width"], lambda wider: abs(wider) < 2)
    assert box_of(first)["y"] == box_of(second)["y"]
    second.get_by_role("radio", name="Rates").click()
    expect(first.get_by_role("radio", name="Spikes")).to_be_checked()
    seen(opened, lambda: "spikes 2" in saved(experiment) and "rates" in saved(experiment))
    opened.reload()
    expect(second.get_by_role("radio", name="Rates")).to_be_checked()


def saved(experiment: Path) -> str:
    file = own_layout(experiment.with_suffix(SUFFIX))
    return file.read_text() if file.exists() else ""


def test_a_second_panel_of_curves_has_its_own_which_close_with_it(opened: Page):
    choose(opened, "Place of Devices and topics", "Split below")
    second = panel(opened, "Devices and topics 2")
    expect(second).to_contain_text("Drag a variable here")
    second.get_by_role("button", name="Add", exact=True).click()
    opened.get_by_role("searchbox", name="Search the topics").fill("odom position x")
    opened.keyboard.press("Enter")
    remove = opened.get_by_role("button", name="Remove pose.pose.position.x")
    expect(second.get_by_role("button", name="Remove pose.pose.position.x")).to_be_visible()
    expect(remove).to_have_count(1)
    choose(opened, "Place of Devices and topics 2", "Close")
    expect(second).to_have_count(0)
    choose(opened, "Layout", "Add Devices and topics")
    expect(second).to_contain_text("Drag a variable here")


def test_panels_close_become_others_and_come_back_with_a_reset(opened: Page):
    choose(opened, "Place of From above", "Close")
    expect(panel(opened, "From above")).to_have_count(0)
    choose(opened, "Place of Brain", "Show Camera here")
    expect(panel(opened, "Brain")).to_have_count(0)
    expect(panel(opened, "Camera 2")).to_contain_text("/husky/camera")
    choose(opened, "Layout", "Reset the layout")
    for name in ("From above", "Brain"):
        expect(panel(opened, name)).to_be_visible()
    expect(panel(opened, "Camera 2")).to_have_count(0)


def test_the_last_panel_cannot_be_closed(opened: Page):
    for name in ("From above", "Brain", "Spikes", "Devices and topics", "Camera", "Selected"):
        choose(opened, f"Place of {name}", "Close")
    opened.get_by_role("button", name="Place of Scene", exact=True).click()
    expect(opened.get_by_role("menuitem", name="Close", exact=True)).to_be_disabled()


def test_a_head_is_dragged_to_a_side_of_a_panel_or_into_its_place(opened: Page):
    brain, camera, spikes = (panel(opened, name) for name in ("Brain", "Camera", "Spikes"))
    heads = {name: panel(opened, name).get_by_role("heading").first for name in ("Camera", "Brain")}
    around = box_of(brain)
    heads["Camera"].drag_to(brain, target_position={"x": around["width"] - 12, "y": around["height"] / 2})
    seen(opened, lambda: box_of(camera)["x"] > box_of(brain)["x"])
    assert box_of(camera)["y"] == box_of(brain)["y"]
    before = box_of(spikes)
    heads["Brain"].drag_to(spikes, target_position={"x": before["width"] / 2, "y": before["height"] / 2})
    seen(opened, lambda: box_of(brain), lambda box: box == before)
    expect(opened.locator("[data-drop]")).to_have_count(0)


def test_a_run_without_a_camera_has_no_panel_for_one(watched: Watched):
    with cockpit(experiment="walking_hexapod") as opened:
        page = watched.open(opened.address)
        expect(panel(page, "From above")).to_be_visible()
        expect(panel(page, "Camera")).to_have_count(0)
        page.get_by_role("button", name="Layout", exact=True).click()
        expect(page.get_by_role("menuitem", name="Add Scene")).to_be_visible()
        expect(page.get_by_role("menuitem", name="Add Camera")).to_have_count(0)


def test_sliders_change_cells_and_functions_and_a_seed_begins_again(watched: Watched, stories: Stories):
    with cockpit(experiment="slalom_pioneer") as opened:
        page = watched.open(opened.address)
        page.evaluate(STYLED, FONTS)
        choose(page, "Place of Spikes", "Show Parameters here")
        slider = page.get_by_role("slider", name="v_thresh of wheels")
        expect(slider).to_have_attribute("aria-valuetext", "-50 mV")
        page.mouse.move(0, 0)
        stories.compare("live", settled(page, {"parameters": panel(page, "Parameters")}))
        slider.press("ArrowLeft")
        expect(slider).to_have_attribute("aria-valuetext", "-50.2 mV")
        seen(page, lambda: opened.session.ask(
            lambda: set(opened.session.run.brain.read_parameters("wheels")["v_thresh"].tolist())
        ), lambda values: values == {-50.2})  # fmt: skip
        field = page.get_by_role("textbox", name="Value of RATE of steer.py")
        field.fill("100")
        field.press("Enter")
        text = seen(
            page,
            lambda: "".join(opened.session.functions.texts.values()),
            lambda text: "RATE = 100.0" in text,
        )
        assert "RATE = 250.0" not in text
        page.get_by_role("textbox", name="Seed").fill("7")
        page.get_by_role("button", name="Begin again").click()
        expect(page.get_by_role("button", name="Begin again")).to_have_count(0)
        expect(slider).to_have_attribute("aria-valuetext", "-50 mV")
        assert opened.session.run.seed == 7
        expect(field).to_have_value("100")
