"""What panels show is saved as pictures, tables and videos, from a run and from a shared file."""

from __future__ import annotations

import csv
from io import BytesIO, StringIO
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from browsing import Watched
from PIL import Image
from playwright.sync_api import Page, expect

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def opened(husky: str, watched: Watched) -> Page:
    """A run after a second."""
    page = watched.open(husky)
    for plot in ("Spikes of circuit", "Curves of linear.x, angular.z"):
        expect(
            page.get_by_role("img", name=plot)
        ).to_be_visible()  # what a panel shows is remembered from now on
    page.get_by_role("slider", name="Simulated time").press("PageUp")
    page.get_by_role("timer").get_by_text("1.00 s").wait_for()
    return page


def saved(page: Page, panel: str, item: str) -> bytes:
    """Choose an item of the menu of a panel and return the file that it saves."""
    with page.expect_download() as download:
        choose(page, panel, item)
    return Path(download.value.path()).read_bytes()


def choose(page: Page, panel: str, item: str) -> None:
    page.get_by_role("button", name=f"Place of {panel}", exact=True).click()
    page.get_by_role("menuitem", name=item).click()


@pytest.mark.one_of(8)
@pytest.mark.parametrize("panel", ["Scene", "Brain", "Spikes", "Devices and topics"])
def test_each_panel_is_saved_as_wide_as_a_column_of_a_journal(panel: str, opened: Page) -> None:
    picture = Image.open(BytesIO(saved(opened, panel, "Save as PNG, 85 mm wide")))
    assert picture.width == round(85 / 25.4 * 300)
    assert picture.info["dpi"] == pytest.approx((300, 300), abs=0.01)
    pixels = np.asarray(picture.convert("RGB")).reshape(-1, 3)
    assert len(np.unique(pixels, axis=0)) > 50  # more than an empty panel has, also where WebGL draws


def test_panels_are_saved_as_drawings_and_tables(opened: Page) -> None:
    brain = ET.fromstring(saved(opened, "Brain", "Save as SVG, 180 mm wide"))
    assert brain.get("width") == "180mm"
    circles = brain.findall(f".//{SVG}circle[@class='brain-shape']")
    assert len(circles) == 8
    assert all("stroke: rgb(" in circle.get("style", "") for circle in circles)
    assert_has_lines_and_axes(opened, "Spikes", {"Neuron", "circuit"})
    assert_has_lines_and_axes(opened, "Devices and topics", {"voltage (mV)", "linear.x"})
    table = rows(saved(opened, "Devices and topics", "Save as CSV"))
    speed = [row for row in table if row["angular.z: /husky/cmd_vel"]]
    assert [float(row["t_s"]) for row in speed] == pytest.approx(np.arange(1, 51) * 0.02)
    assert {row["cell"] for row in rows(saved(opened, "Spikes", "Save as CSV"))} >= {"4", "5", "7"}


def assert_has_lines_and_axes(page: Page, panel: str, names: set[str]) -> None:
    """Save a plot, which has lines, words and named axes and no image."""
    root = ET.fromstring(saved(page, panel, "Save as SVG, 85 mm wide"))
    assert root.get("width") == "85mm"
    assert {text.text for text in root.iter(f"{SVG}text")} >= {"Time (s)", *names}
    assert not [*root.iter(f"{SVG}image")]
    curves = [path for path in root.iter(f"{SVG}path") if path.get("stroke") == "#0072b2"]
    assert sum(path.get("d", "").count("M") for path in curves) > 0


def rows(content: bytes) -> list[dict[str, str]]:
    return [*csv.DictReader(StringIO(content.decode(), newline=""))]


@pytest.mark.heavy
def test_the_scene_is_filmed(opened: Page) -> None:
    choose(opened, "Scene", "Record a video")
    opened.get_by_role("button", name="Play").click()
    opened.wait_for_timeout(1500)
    film = saved(opened, "Scene", "End the video and save it")
    assert film[:4] == b"\x1a\x45\xdf\xa3"  # WebM
    assert len(film) > 10_000
