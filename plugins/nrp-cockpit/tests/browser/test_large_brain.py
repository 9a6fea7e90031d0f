"""Brains of many cells: their groups as bands and boxes, and views of some of the cells."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browsing import Kept, Watched, box_of, seen
from large_brain import large_brain
from playwright.sync_api import Locator, Page, expect

INKED = """canvas => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const pixels = new Uint32Array(data.buffer);
    let sum = 0;
    for (let at = 0; at < pixels.length; at++) sum = (sum * 31 + pixels[at]) >>> 0;
    return sum;
}"""
"""Gives a number that differs if the picture does."""


@pytest.fixture(scope="session")
def ring(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An experiment with 2000 cells in a ring, of which two eighths are groups."""
    return large_brain(tmp_path_factory.mktemp("ring"))


@pytest.fixture
def page(ring: Path, kept: Kept, watched: Watched) -> Page:
    """A cockpit after a second of the ring."""
    page = watched.open(kept.open(str(ring)))
    expect(page.get_by_role("img", name="Spikes of ring, kicks")).to_be_visible()
    page.get_by_role("slider", name="Simulated time").press("PageUp")
    expect(page.get_by_role("timer")).to_contain_text("1.00 s")
    page.get_by_role("button", name="Play").wait_for()
    return page


def plot_of(page: Page) -> Locator:
    return page.get_by_role("img", name="Spikes of ring, kicks")


def choose(page: Page, item: str) -> None:
    """Choose an item of the menu of the cells."""
    page.get_by_role("button", name="Cells in the plot").click()
    page.get_by_role("menuitem", name=item).click()


def selected(page: Page) -> Locator:
    return page.get_by_role("region", name="Selected").locator(".inspector-title")


def test_a_click_on_a_band_selects_its_group(page: Page):
    plot = plot_of(page)
    box = box_of(plot)
    for share, name, cells in ((0.1, "east", 250), (0.33, "west", 250), (0.52, "marked", 20)):
        plot.click(position={"x": 20, "y": 16 + share * (box["height"] - 34)})
        expect(selected(page)).to_contain_text(name)
        expect(selected(page)).to_contain_text(f"{cells} cells")
    expect(page.get_by_role("navigation", name="Contents of the run")).to_have_count(0)
    page.keyboard.press("Escape")
    outline = page.get_by_role("navigation", name="Contents of the run")
    for group in ("east", "west", "marked"):
        expect(outline.get_by_role("button", name=group, exact=True)).to_be_visible()
    expect(outline.get_by_role("button", name="kicks", exact=True)).to_have_count(1)  # the population alone


def test_the_wheel_beside_the_cells_zooms_to_one_and_a_double_click_shows_all(page: Page):
    plot = plot_of(page)
    before = plot.evaluate(INKED)
    plot.hover(position={"x": 20, "y": 100})
    for _ in range(12):
        page.mouse.wheel(0, -600)
    seen(page, lambda: plot.evaluate(INKED), lambda picture: picture != before)
    plot.click(position={"x": 300, "y": 100})
    expect(selected(page)).to_contain_text(re.compile(r"^ring \d+"))
    one = int(selected(page).inner_text().split()[1])
    box = box_of(plot)
    page.mouse.move(box["x"] + 300, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 301, box["y"] + 50, steps=5)
    page.mouse.up()
    plot.click(position={"x": 300, "y": 100})
    expect(selected(page)).not_to_contain_text(f"ring {one}\n")
    assert 0 < int(selected(page).inner_text().split()[1]) - one < 8
    expect(page.get_by_role("button", name="Resume the spikes")).to_have_count(0)  # time was not dragged
    plot.dblclick()
    page.keyboard.press("Escape")
    page.mouse.move(0, 0)
    seen(page, lambda: plot.evaluate(INKED), lambda picture: picture == before)


def test_silent_cells_can_be_hidden(page: Page):
    spikes = page.get_by_role("region", name="Spikes")
    choose(page, "Active cells first")
    expect(spikes).to_contain_text(re.compile(r"in the last second, of [\d,]+ cells in sight"))
    shown = int(spikes.inner_text().split(", of ")[1].split(" cells")[0].replace(",", ""))
    assert 0 < shown <= 2004
    choose(page, "By number")
    expect(spikes).not_to_contain_text("in sight")


def test_rates_are_shown_as_colours_of_groups_or_of_cells(page: Page):
    plot, spikes = plot_of(page), page.get_by_role("region", name="Spikes")
    pictures = [plot.evaluate(INKED)]

    def is_another() -> None:
        pictures.append(seen(page, lambda: plot.evaluate(INKED), lambda picture: picture not in pictures))

    spikes.get_by_role("radio", name="Heat").click()
    is_another()
    choose(page, "Heat of cells")
    is_another()
    spikes.get_by_role("radio", name="Rates").click()
    is_another()
