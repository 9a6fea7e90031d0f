"""The plots, the graph of the brain and the camera show what the run sends, and forget what a reset undid."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browsing import HUSKY, UNKNOWN, Kept, Watched, box_of, seen
from nrp_cockpit.session.layout import SUFFIX, own_layout
from playwright.sync_api import Locator, Page, expect
from visitors import visit

GREEN = [0, 158, 115]
"""The colour of actors and of their spikes."""


def pixels(canvas: Locator, colour: list[int]) -> int:
    """Return how many pixels of a canvas have a colour."""
    count = canvas.evaluate(
        """(canvas, [red, green, blue]) => {
            const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            let count = 0;
            for (let at = 0; at < data.length; at += 4)
                if (data[at] === red && data[at + 1] === green && data[at + 2] === blue) count++;
            return count;
        }""",
        colour,
    )
    assert isinstance(count, int)
    return count


@pytest.fixture(scope="module")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An experiment in a folder of its own, where the layout is kept."""
    file = tmp_path_factory.mktemp("plotted") / "plotted.yaml"
    file.write_text("extends: braitenberg_husky\nname: plotted\n")
    return file


@pytest.fixture
def opened(experiment: Path, kept: Kept, watched: Watched) -> Page:
    """A page of a run that has gone to one second and stands, with the usual layout."""
    experiment.with_suffix(SUFFIX).unlink(missing_ok=True)
    own_layout(experiment.with_suffix(SUFFIX)).unlink(missing_ok=True)
    page = watched.open(kept.open(str(experiment), *HUSKY))
    for plot in (
        "Spikes of circuit",
        "Curves of linear.x, angular.z",
    ):  # a panel hears what is sent from now on
        expect(page.get_by_role("img", name=plot)).to_be_visible()
    expect(page.get_by_role("region", name="Camera")).to_contain_text("/husky/camera")
    page.get_by_role("slider", name="Simulated time").press("PageUp")  # as fast as it can
    expect(page.get_by_role("timer")).to_contain_text("1.00 s")
    page.get_by_role("button", name="Play").wait_for()
    return page


def test_spikes_are_drawn_and_a_reset_forgets_them(opened: Page):
    raster = opened.get_by_role("img", name="Spikes of circuit")
    seen(opened, lambda: pixels(raster, GREEN), lambda count: count > 500)
    opened.get_by_role("button", name="Reset", exact=True).click()
    opened.get_by_role("menuitem", name="Reset everything").click()
    expect(opened.get_by_role("timer")).to_contain_text("0.00 s")
    expect(opened.get_by_text(f"{UNKNOWN} in 1 s", exact=True)).to_be_visible()
    seen(opened, lambda: pixels(raster, GREEN), lambda count: count == 0)


def test_plots_are_read_as_tables_neurons_say_rates_and_curves_are_added(opened: Page):
    spikes = opened.get_by_role("table", name="Spikes of circuit").get_by_role("row").last
    expect(spikes).to_have_text(re.compile(r"circuit8\d+[\d.]+ Hz"))
    curves = opened.get_by_role("table", name="Curves of linear.x, angular.z").get_by_role("row")
    expect(curves).to_have_count(3)
    expect(curves.last).to_have_text(re.compile(r"\d"))
    now, lowest, highest = (float(text) for text in curves.last.get_by_role("cell").all_inner_texts())
    assert lowest <= now <= highest
    assert highest > 0
    wheel = opened.get_by_role("button", name="Neuron 7 of circuit: right wheel neuron")
    rate = wheel.locator(".brain-rate")
    expect(rate).to_have_text(re.compile(r"^[\d.]+ Hz$"))
    seen(opened, lambda: float((rate.text_content() or "").removesuffix(" Hz")), lambda hz: hz > 20)
    wheel.press("Enter")
    expect(wheel).to_have_attribute("aria-pressed", "true")
    line = opened.get_by_role("button", name="Projection [0, 1] to [4, 5]: inhibits, 4 synapses")
    line.press(" ")
    expect(line).to_have_attribute("aria-pressed", "true")
    expect(wheel).to_have_attribute("aria-pressed", "false")
    opened.get_by_role("button", name="Add", exact=True).click()
    opened.get_by_role("searchbox", name="Search the topics").fill("odom position x")
    opened.keyboard.press("Enter")
    curves = opened.get_by_role("img", name="Curves of pose.pose.position.x")
    expect(curves).to_be_visible()
    opened.get_by_role("button", name="Step", exact=True).click()
    expect(opened.get_by_role("region", name="/husky/odom")).to_contain_text(re.compile(r"-?\d\.\d"))
    opened.get_by_role("button", name="Remove pose.pose.position.x").click()
    expect(curves).to_have_count(0)


def test_a_number_of_a_device_and_a_field_of_a_topic_are_dragged_to_the_plots(opened: Page):
    opened.get_by_role("button", name="Remove right_wheel_neuron").click()
    opened.get_by_role("button", name="Neuron 7 of circuit: right wheel neuron").press("Enter")
    inspector = opened.get_by_role("region", name="Selected")
    inspector.get_by_text("Add to plot").first.click()
    plots = opened.get_by_role("region", name="Devices and topics")
    inspector.get_by_role("button", name="Add data to the plot").first.drag_to(plots)
    expect(plots.get_by_role("button", name="Remove right_wheel_neuron")).to_be_visible()
    opened.keyboard.press("Escape")
    inspector.get_by_role("button", name="husky", exact=True).click()
    topic = inspector.locator(".inspector-topic").filter(has_text="/husky/odom")
    topic.get_by_text("Add to plot").click()
    topic.get_by_role("button", name="Add pose.pose.position.x to the plot").drag_to(plots)
    expect(plots.get_by_role("button", name="Remove pose.pose.position.x")).to_be_visible()
    opened.get_by_role("button", name="Step", exact=True).click()
    expect(plots.get_by_role("region", name="/husky/odom")).to_contain_text(re.compile(r"-?\d\.\d"))


def test_the_wheel_zooms_both_plots_and_a_double_click_resets_them(opened: Page):
    lengths = [opened.get_by_role("button", name=f"Time window of {plot}") for plot in ("spikes", "curves")]
    opened.get_by_role("img", name="Spikes of circuit").hover()
    opened.mouse.wheel(0, 600)
    for length in lengths:
        expect(length).not_to_have_text("4 s")
    opened.get_by_role("button", name="Freeze the spikes; the run continues").click()
    expect(opened.get_by_role("button", name="Resume the curves")).to_be_visible()
    opened.get_by_role("img", name="Spikes of circuit").dblclick()
    for length in lengths:
        expect(length).to_have_text("4 s")
    expect(opened.get_by_role("button", name="Resume the spikes")).to_have_count(0)


def test_a_viewer_sees_the_room_and_no_file_is_written_beside_the_experiment(opened: Page, experiment: Path):
    image = opened.get_by_role("img", name="The image of /husky/camera")
    expect(image).to_be_visible()
    colours = """(canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(new Uint32Array(data.buffer)).size;
    }"""
    seen(opened, lambda: image.evaluate(colours), lambda count: count > 5)
    expect(opened.get_by_role("img", name="Curves of linear.x, angular.z")).to_be_visible()
    opened.wait_for_timeout(1500)  # a change is saved after half a second
    assert [*experiment.parent.iterdir()] == [experiment]
    assert not own_layout(experiment.with_suffix(SUFFIX)).exists()


def without_right(experiment: Path) -> bool:
    """Return whether the user's layout of an experiment plots the left wheel neuron alone."""
    file = own_layout(experiment.with_suffix(SUFFIX))
    text = file.read_text() if file.exists() else ""
    return "left_wheel_neuron" in text and "right_wheel_neuron" not in text


@pytest.mark.heavy
def test_theme_panels_and_curves_are_there_again_after_a_reload_until_they_are_reset(
    opened: Page, experiment: Path
):
    opened.get_by_role("button", name="Switch between light and dark").click()
    border = opened.get_by_role("separator").first
    before = str(border.get_attribute("aria-valuenow"))
    border.press("ArrowDown")
    expect(border).not_to_have_attribute("aria-valuenow", before)
    moved = str(border.get_attribute("aria-valuenow"))
    opened.get_by_role("button", name="Remove right_wheel_neuron").click()
    seen(opened, lambda: without_right(experiment))
    opened.reload()
    expect(opened.get_by_role("button", name="Remove left_wheel_neuron")).to_be_visible()
    expect(opened.get_by_role("button", name="Remove right_wheel_neuron")).to_have_count(0)
    expect(opened.get_by_role("separator").first).to_have_attribute("aria-valuenow", moved)
    expect(opened.locator("html")).to_have_class("theme-dark")
    assert [*experiment.parent.iterdir()] == [experiment]
    opened.get_by_role("button", name="Layout", exact=True).click()
    opened.get_by_role("menuitem", name="Reset the layout").click()
    expect(opened.get_by_role("button", name="Remove right_wheel_neuron")).to_be_visible()
    expect(opened.get_by_role("separator").first).to_have_attribute("aria-valuenow", before)
    assert not own_layout(experiment.with_suffix(SUFFIX)).exists()


def test_the_page_reports_a_broken_layout(experiment: Path, kept: Kept, watched: Watched):
    experiment.with_suffix(SUFFIX).write_text('{\n"version": 1,\n')
    page = watched.open(kept.open(str(experiment), *HUSKY))
    expect(page.get_by_role("alert")).to_contain_text("not YAML")
    expect(page.get_by_role("alert")).to_contain_text(f"{experiment.with_suffix(SUFFIX)}:3")
    expect(page.get_by_role("img", name="Spikes of circuit")).to_be_visible()


def test_a_device_is_plotted_as_soon_as_it_is_there_and_no_longer(opened: Page):
    step = opened.get_by_role("button", name="Step", exact=True)
    plots = opened.get_by_role("region", name="Devices and topics")
    old = plots.get_by_role("listitem").filter(has_text="red_left_eye").locator("b")
    expect(old).to_have_text(re.compile(r"\d"))
    with visit(opened.url) as visitor:
        visitor.subscribe("/cockpit/functions")
        files = visitor.until(lambda: visitor.last("functions"))["files"]
        (file,) = (each for each in files if each["path"].endswith("listing2.py"))
        text = file["source"].replace("red_left_eye", "seen_on_the_left")
        assert visitor.call("functions/apply", files={file["path"]: text})["applied"]
    step.click()
    gone = plots.get_by_role("region", name="/brain/devices/eye_sensor_transmit/red_left_eye/rate")
    expect(gone.locator("b")).to_have_text("\N{EN DASH}")
    opened.get_by_role("button", name="Add", exact=True).click()
    opened.get_by_role("searchbox", name="Search the topics").fill("seen_on_the_left")
    opened.keyboard.press("Enter")
    new = plots.get_by_role("listitem").filter(has_text="seen_on_the_left")
    expect(new.locator("b")).to_have_text(re.compile(r"\d"))


def test_a_legend_of_many_curves_leaves_room_for_them(opened: Page):
    plots = opened.get_by_role("region", name="Devices and topics")
    for axis in "xyz":
        for field in (f"odom pose.position.{axis}", f"odom linear.{axis}", f"odom angular.{axis}"):
            opened.get_by_role("button", name="Add", exact=True).click()
            opened.get_by_role("searchbox", name="Search the topics").fill(field)
            opened.keyboard.press("Enter")
    group = plots.get_by_role("region", name="/husky/odom")
    expect(group.get_by_role("listitem")).to_have_count(9)
    legend, curves = group.get_by_role("list"), group.get_by_role("img")
    assert box_of(legend)["height"] <= 72  # three lines
    assert box_of(curves)["height"] >= 52
    group.get_by_role("button").last.focus()
    expect(group.get_by_role("button").last).to_be_in_viewport()


def test_legends_stay_in_narrow_panels(opened: Page):
    group = opened.get_by_role("region", name="voltage (mV)")
    expect(group).to_contain_text("left_wheel_neuron")
    for width in (390, 1000):
        opened.set_viewport_size({"width": width, "height": 900})
        inside, key = box_of(group), box_of(group.get_by_role("listitem").first)
        assert key["width"] > 100
        assert inside["x"] <= key["x"]
        assert key["x"] + key["width"] <= inside["x"] + inside["width"]
