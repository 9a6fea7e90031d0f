"""Pictures of panels, compared with those that a person has looked at, which stand beside the tests."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from browsing import PATIENCE_MS, PATIENCE_S, drawn
from PIL import Image
from playwright.sync_api import Browser, Locator, Page

KEPT = Path(__file__).parent / "pictures"
FONTS = ':root { --ui: "DejaVu Sans"; --mono: "DejaVu Sans Mono"; }'
"""The fonts of all pictures, which ``apt.txt`` brings."""
STYLED = """(style => {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(style);
    document.adoptedStyleSheets.push(sheet);
})"""
"""Adds a style to a page, whatever its policy allows."""
ANOTHER = 32
"""A pixel differs if a channel does by more, of 255."""
SQUARE_PX = 32
"""Differences are counted in squares of this size: a number is little of a panel and much of a square."""
MOST = 0.05
"""The share of the pixels of any square that may differ, as edges of letters do on another machine."""
_STILL_S = 0.3

Picture = npt.NDArray[np.uint8]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-pictures", action="store_true", help="write the pictures of the panels shown")


@contextmanager
def shown(
    browser: Browser, address: str, size: tuple[int, int], theme: Literal["light", "dark"], fault: str = ""
) -> Iterator[Page]:
    """Give a page in the fonts of the pictures that nobody has used, with a script that spoils it, if any."""
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=theme)
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.add_init_script(f"{STYLED}({json.dumps(FONTS)}); {fault}")
    page.goto(address)
    for plot in ("Spikes of circuit", "Curves of linear.x, angular.z"):
        page.get_by_role("img", name=plot).wait_for()
    drawn(page)
    yield page
    context.close()


def settled(page: Page, panels: Mapping[str, Locator]) -> dict[str, Picture]:
    """Return pictures of parts of a page as soon as it stands still."""
    end_s, before = time.monotonic() + PATIENCE_S, b""
    while (now := page.screenshot(animations="disabled")) != before:
        assert time.monotonic() < end_s, "the page does not stand still"
        before = now
        page.wait_for_timeout(1000 * _STILL_S)
    whole = np.asarray(Image.open(BytesIO(now)).convert("RGB"))
    return {name: _part(whole, panel) for name, panel in panels.items()}


def _part(whole: Picture, panel: Locator) -> Picture:
    box = panel.bounding_box()
    assert box is not None
    left, top = round(box["x"]), round(box["y"])
    right, bottom = round(box["x"] + box["width"]), round(box["y"] + box["height"])
    assert 0 <= left < right <= whole.shape[1]
    assert 0 <= top < bottom <= whole.shape[0]
    return whole[top:bottom, left:right]


def kept(name: str) -> Path:
    """Return the file of the picture of a story."""
    return KEPT / f"{name}.png"


def read(file: Path) -> Picture:
    return np.asarray(Image.open(file).convert("RGB"))


def differing(first: Picture, second: Picture) -> npt.NDArray[np.bool_]:
    """Return which pixels of two pictures of one size differ."""
    return np.asarray(np.abs(first.astype(np.int16) - second).max(axis=2) > ANOTHER)


def share(first: Picture, second: Picture) -> float:
    """Return the share of the pixels that differ in the worst square: all, if the pictures differ in size."""
    if first.shape != second.shape:
        return 1.0
    square = (SQUARE_PX, SQUARE_PX)
    flags = differing(first, second).astype(np.float32)
    return float(cv2.boxFilter(flags, -1, square, borderType=cv2.BORDER_CONSTANT).max())


class Stories:
    """Compares panels with their pictures, or writes the pictures of those that differ.

    Args:
        folder: for the pictures of panels that differ, and for the differences.
        update: whether what differs is right.

    Attributes:
        wrong: the panels that differ: the names of their pictures, and how much.
    """

    def __init__(self, folder: Path, update: bool = False) -> None:
        self._folder, self._update = folder, update
        self.wrong: dict[str, float] = {}

    def compare(self, page: str, pictures: Mapping[str, Picture], **most: float) -> None:
        """Compare panels of a page, some with a tolerance of their own."""
        for panel, picture in pictures.items():
            name = f"{page}-{panel}"
            expected = read(kept(name)) if kept(name).exists() else np.zeros((0, 0, 3), np.uint8)
            found = share(expected, picture)
            if found <= most.get(panel, MOST):
                continue
            if self._update:
                Image.fromarray(picture).save(kept(name), optimize=True)
                continue
            self.wrong[name] = found
            Image.fromarray(picture).save(self._folder / f"{name}.png")
            if expected.shape == picture.shape:
                pale, red = 170 + picture // 3, np.array([220, 0, 0], np.uint8)
                marked = np.where(differing(expected, picture)[..., None], red, pale)
                Image.fromarray(marked).save(self._folder / f"{name}.difference.png")

    def close(self) -> None:
        """Fail if a panel differs."""
        if self.wrong:
            found = "".join(f"{name}: {share:.1%} of a square differ\n" for name, share in self.wrong.items())
            pytest.fail(f"{found}see {self._folder}; if it is right: --update-pictures", pytrace=False)


@pytest.fixture
def stories(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Stories]:
    stories = Stories(tmp_path, request.config.getoption("update_pictures"))
    yield stories
    stories.close()
