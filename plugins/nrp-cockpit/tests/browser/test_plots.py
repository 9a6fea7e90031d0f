"""The plots, the graph of the brain and the camera show what the run sends, and forget what a reset undid."""

from __future__ import annotations

import re

from browsing import HUSKY, Cockpits, Watched, wait_until
from playwright.sync_api import Locator, Page, expect

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


def opened(cockpits: Cockpits, watched: Watched) -> Page:
    """A page of a run that has gone on for a second and stands."""
    page = watched.open(cockpits.open("braitenberg_husky", *HUSKY))
    page.get_by_role("button", name="Play").click()
    wait_until(page, 1.0)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    return page


def test_spikes_are_drawn_and_a_reset_forgets_them(cockpits: Cockpits, watched: Watched):
    page = opened(cockpits, watched)
    raster = page.get_by_role("img", name="Spikes of circuit")
    assert pixels(raster, GREEN) > 500
    page.get_by_role("button", name="Reset", exact=True).click()
    page.get_by_role("menuitem", name="Reset everything").click()
    expect(page.get_by_role("timer")).to_contain_text("0.00 s", timeout=30_000)
    expect(page.get_by_text("0 in the last second", exact=True)).to_be_visible()
    assert pixels(raster, GREEN) == 0


def test_a_neuron_says_its_rate_and_is_selected_by_the_keyboard(cockpits: Cockpits, watched: Watched):
    page = opened(cockpits, watched)
    wheel = page.get_by_role("button", name="Neuron 7 of circuit: right wheel neuron")
    rate, unit = (wheel.locator(".brain-rate").text_content() or "").split()
    assert float(rate) > 20
    assert unit == "Hz"
    wheel.press("Enter")
    expect(wheel).to_have_attribute("aria-pressed", "true")
    line = page.get_by_role("button", name="Projection [0, 1] to [4, 5]: inhibits, 4 synapses")
    line.press(" ")
    expect(line).to_have_attribute("aria-pressed", "true")
    expect(wheel).to_have_attribute("aria-pressed", "false")


def test_a_curve_is_found_by_words_added_and_removed(cockpits: Cockpits, watched: Watched):
    page = opened(cockpits, watched)
    page.get_by_role("button", name="Add", exact=True).click()
    page.get_by_role("searchbox", name="Search the topics").fill("odom position x")
    page.keyboard.press("Enter")
    curves = page.get_by_role("img", name="Curves of pose.pose.position.x")
    expect(curves).to_be_visible()
    page.get_by_role("button", name="Step", exact=True).click()
    expect(page.get_by_role("region", name="/husky/odom")).to_contain_text(re.compile(r"-?\d\.\d"))
    page.get_by_role("button", name="Remove pose.pose.position.x").click()
    expect(curves).to_have_count(0)


def test_a_number_of_a_device_is_dragged_to_the_plots(cockpits: Cockpits, watched: Watched):
    page = opened(cockpits, watched)
    page.get_by_role("button", name="Remove right_wheel_neuron").click()
    page.get_by_role("button", name="Neuron 7 of circuit: right wheel neuron").press("Enter")
    inspector = page.get_by_role("region", name="Selected")
    inspector.get_by_text("Add to plot").first.click()
    plots = page.get_by_role("region", name="Devices and topics")
    inspector.get_by_role("button", name="Add data to the plot").first.drag_to(plots)
    expect(plots.get_by_role("button", name="Remove right_wheel_neuron")).to_be_visible()


def test_the_wheel_zooms_both_plots_and_a_double_click_resets_them(cockpits: Cockpits, watched: Watched):
    page = opened(cockpits, watched)
    lengths = [
        page.get_by_role("button", name=f"Length of the window of {plot}") for plot in ("spikes", "curves")
    ]
    page.get_by_role("img", name="Spikes of circuit").hover()
    page.mouse.wheel(0, 600)
    for length in lengths:
        expect(length).not_to_have_text("4 s")
    page.get_by_role("button", name="Hold the spikes; the run goes on").click()
    expect(page.get_by_role("button", name="Let the curves follow the run")).to_be_visible()
    page.get_by_role("img", name="Spikes of circuit").dblclick()
    for length in lengths:
        expect(length).to_have_text("4 s")
    expect(page.get_by_role("button", name="Let the spikes follow the run")).to_have_count(0)


def test_the_camera_shows_the_room(cockpits: Cockpits, watched: Watched):
    page = opened(cockpits, watched)
    image = page.get_by_role("img", name="The image of /husky/camera")
    expect(image).to_be_visible()
    colours = image.evaluate(
        """(canvas) => {
            const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            return new Set(new Uint32Array(data.buffer)).size;
        }"""
    )
    assert colours > 5
