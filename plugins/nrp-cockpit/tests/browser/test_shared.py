"""A recording in one HTML file plays from the disk, without a server."""

from __future__ import annotations

import re
from pathlib import Path

import nrp_cockpit
import pytest
from browsing import UNKNOWN, Watched, seen, time_s, wait_until
from nrp_cockpit import show
from nrp_cockpit.sharing.sharing import shared_file
from playwright.sync_api import Browser, Page, expect

from nrp_core.cli.app import run_app
from nrp_core.experiment.reading.find import shipped

CUT_AT_THE_RIGHT = """root => [...root.querySelectorAll("button, a, h1, h2, canvas, input")]
    .filter(one => one.getBoundingClientRect().right > root.clientWidth)
    .map(one => one.ariaLabel ?? one.textContent)"""
"""Gives what reaches out of the page."""

OVERLAPPING = """svg => {
    const words = [...svg.querySelectorAll("tspan, text:not(:has(tspan))")];
    const boxes = words.filter(one => one.textContent.trim())
        .map(one => [one.textContent, one.getBoundingClientRect()]);
    return boxes.flatMap(([word, a], at) => boxes.slice(at + 1)
        .filter(([, b]) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2
            && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 5)  // lines are higher than letters
        .map(([other]) => `${word} | ${other}`));
}"""
"""Gives the words of a drawing that lie on each other."""
ONLY_LIVE = ("Place", "Push", "Edit the room", "Record", "Take a snapshot")
"""Buttons that a recording cannot honour."""
QUICK = {"reflex_arm": 1.5, "chase": 5.72}
"""Experiments that run in seconds, and where they open: late in a short run, a second after a success."""


@pytest.fixture(scope="module")
def shared(recording: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of the file."""
    file = tmp_path_factory.mktemp("mail") / "attachment.html"
    file.write_text(shared_file(recording).html)
    return file.as_uri()


def test_it_is_scrubbed_and_played_from_the_disk(shared: str, watched: Watched):
    page = watched.open(shared)
    timer, slider = page.get_by_role("timer"), page.get_by_role("slider", name="Simulated time")
    expect(timer).to_contain_text("1.50 s")  # nothing happened in it, so it opens when most is over
    slider.press("Home")
    expect(timer).to_contain_text("0.00 s")
    expect(page.get_by_role("region", name="Scene")).to_contain_text("11 models")
    slider.press("PageUp")
    expect(timer).to_contain_text("1.00 s")
    expect(page.get_by_role("img", name="The image of /husky/camera")).to_be_visible()
    spikes = page.get_by_role("region", name="Spikes")
    expect(spikes).to_contain_text(" in 1 s")
    seen(page, lambda: red_pixels(page) > 50)
    slider.press("Home")
    expect(timer).to_contain_text("0.00 s")
    expect(spikes).to_contain_text(f"{UNKNOWN} in 1 s")
    seen(page, lambda: red_pixels(page) == 0)  # the screen is blue again
    page.get_by_role("button", name="Play").click()
    wait_until(page, 0.1)
    page.get_by_role("button", name="Pause").click()
    slider.press("End")
    expect(timer).to_contain_text("2.00 s")
    expect(page.get_by_role("button", name="Play")).to_be_disabled()
    expect(page.get_by_role("navigation", name="Views").get_by_role("link")).to_have_text(
        ["Cockpit", "Functions"]
    )
    expect(page.get_by_text("to push it")).to_have_count(0)  # a recording cannot be pushed
    page.get_by_role("link", name="Functions").click()
    expect(page.get_by_role("main")).to_contain_text("listing1.py")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.heavy) for name in shipped()],
)
def test_a_run_of_each_experiment_opens_with_filled_plots_and_offers_nothing_that_needs_a_run(
    name: str, watched: Watched, tmp_path: Path
):
    assert run_app(["run", name, "--record", str(tmp_path / "run"), "--images", "jpeg"]) in (0, 1)
    file = tmp_path / "run.html"
    file.write_text(shared_file(tmp_path / "run").html)
    page = watched.open(file.as_uri())
    assert time_s(page) == pytest.approx(QUICK.get(name, time_s(page))) != 0
    curves = page.get_by_role("region", name="Devices and topics").locator(".trace-key b")
    seen(page, curves.all_inner_texts, lambda values: values and UNKNOWN not in values and "" not in values)
    for count in page.locator(".spikes-count").all():  # where cells fire
        seen(page, count.inner_text, lambda text: re.match("[1-9]", text))
    drawn_brain = page.get_by_role("region", name="Brain").locator(".panel-body svg").first
    assert drawn_brain.evaluate(OVERLAPPING) == []
    bodies = page.get_by_role("region", name="Selected").get_by_role("button")
    bodies.first.click()
    for button in ONLY_LIVE:
        expect(page.get_by_role("button", name=button, exact=True)).to_have_count(0)
    page.keyboard.press("Escape")
    page.keyboard.press("?")
    keys = page.get_by_role("dialog", name="Keyboard map")
    expect(keys).to_contain_text("Step back")
    expect(keys).not_to_contain_text("snapshot")
    expect(keys).not_to_contain_text("Designer")


def red_pixels(page: Page) -> int:
    """Count the pixels of the map that are red, as only the screen is."""
    return int(
        page.evaluate("""() => {
            const map = document.querySelector("[data-panel=map] canvas");
            const { data } = map.getContext("2d").getImageData(0, 0, map.width, map.height);
            let count = 0;
            for (let at = 0; at < data.length; at += 4)
                count += data[at] > 150 && data[at + 1] < 60 && data[at + 2] < 60;
            return count;
        }""")
    )


def test_it_is_saved_in_the_page_that_shows_the_recording(played: str, watched: Watched, tmp_path: Path):
    page = watched.open(played)
    with page.expect_download() as download:
        page.get_by_role("button", name="Save as one HTML file").click()
    assert download.value.suggested_filename == "husky.html"
    file = tmp_path / "husky.html"
    download.value.save_as(file)
    saved = watched.open(file.as_uri())
    expect(saved.get_by_role("timer")).to_contain_text("1.50 s of 2 s")
    expect(saved.get_by_role("button", name="Save as one HTML file")).to_have_count(0)


@pytest.mark.heavy
def test_a_notebook_shows_it_in_a_frame(recording: Path, browser: Browser, tmp_path: Path):
    widget = nrp_cockpit.show(recording, height_px=600)
    assert widget.losses == ()
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<!doctype html><meta charset='utf-8'><h1>Notebook</h1>{widget._repr_html_()}")
    page = browser.new_page()
    page.goto(notebook.as_uri())
    inside = page.frame_locator("iframe")
    expect(inside.get_by_role("region", name="Scene")).to_contain_text("11 models")
    expect(inside.get_by_role("timer")).to_contain_text("1.50 s")
    expect(page.get_by_role("heading", name="Notebook")).to_be_visible()
    assert page.locator("iframe").bounding_box()["height"] == 600  # type: ignore[index]
    page.close()


def test_the_frame_of_a_notebook_cuts_nothing_and_saves(recording: Path, tmp_path: Path, watched: Watched):
    file = tmp_path / "notebook.html"
    frame = show(recording)._repr_html_()
    file.write_text(f'<meta charset="utf-8"><h1>Cell</h1><div style="width: 830px">{frame}</div>')
    page = watched.open(file.as_uri(), width=1000, ready=("heading", "Cell"))
    inside = page.frame_locator("iframe")
    inside.get_by_role("button", name="Play").wait_for()
    assert inside.locator("html").evaluate(CUT_AT_THE_RIGHT) == []
    with page.expect_download() as download:
        inside.get_by_role("button", name="Place of Scene", exact=True).click()
        inside.get_by_role("menuitem", name="Save as PNG, 85 mm wide").click()
    assert download.value.suggested_filename.endswith(".png")
