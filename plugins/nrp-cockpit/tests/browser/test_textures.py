"""An image on a body is seen in the scene, upright and not mirrored."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import cv2
import numpy as np
from browsing import Watched, seen
from playwright.sync_api import Locator

from nrp_core.experiment.reading.find import find_file

COLORS = {"red": (0, 0, 255), "green": (0, 255, 0), "blue": (255, 0, 0), "yellow": (0, 255, 255)}
"""As OpenCV has them."""
POSTER = """<model name="poster"><static>1</static><pose>0 0 0.6 0 0 0</pose><link name="a"><visual name="v">
  <geometry><box><size>3 3 0.05</size></box></geometry>
  <material><diffuse>1 1 1</diffuse><pbr><metal><albedo_map>poster.png</albedo_map></metal></pbr></material>
</visual></link></model></world>"""


def places(canvas: Locator) -> dict[str, tuple[float, float]]:
    """Return where the colours of the poster that are seen are, in pixels to the right and down."""
    image = cv2.imdecode(np.frombuffer(canvas.screenshot(), np.uint8), cv2.IMREAD_COLOR).astype(int)
    found = {}
    for name, color in COLORS.items():
        rows, columns = np.nonzero((np.abs(image - color) < 40).all(axis=2))
        if len(rows) > 200:
            found[name] = (float(columns.mean()), float(rows.mean()))
    return found


def is_upright(found: Mapping[str, tuple[float, float]]) -> bool:
    """Return whether the colours are where the image has them."""
    if set(found) != set(COLORS):
        return False
    columns = (("blue", "red"), ("green", "yellow"))
    rows = (("blue", "green"), ("red", "yellow"))
    return all(found[above][1] < found[below][1] - 20 for above, below in columns) and all(
        found[left][0] < found[right][0] - 20 for left, right in rows
    )


def test_a_body_shows_its_image_until_it_has_another_colour(
    tmp_path: Path, in_process: Callable[..., str], watched: Watched
):
    folder = tmp_path / "room"
    shutil.copytree(find_file("braitenberg_husky").parent, folder)
    image = np.array([[COLORS["blue"], COLORS["green"]], [COLORS["red"], COLORS["yellow"]]], np.uint8)
    cv2.imwrite(str(folder / "poster.png"), cv2.resize(image, (64, 64), interpolation=cv2.INTER_NEAREST))
    room = folder / "room.sdf"
    room.write_text(room.read_text().replace("</world>", POSTER))
    page = watched.open(in_process(experiment=str(folder / "experiment.yaml")), 1280, 720)
    canvas = page.get_by_role("application", name="The scene in three dimensions", exact=False)
    page.get_by_role("region", name="Scene").get_by_text("From above", exact=True).click()
    seen(page, lambda: places(canvas), is_upright)  # y is up and x to the right
    selected = page.get_by_role("region", name="Selected")
    selected.get_by_role("button", name="poster", exact=True).click()
    selected.get_by_text("Red", exact=True).click()
    page.get_by_role("button", name="Step", exact=True).click()
    # screens of the room are blue, too
    seen(page, lambda: places(canvas), lambda found: set(found) - {"blue"} == {"red"})
