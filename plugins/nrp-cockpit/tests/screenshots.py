"""Make the pictures of the cockpit in the documentation.

Run it with the Python of the plugin's environment, ``.venv/plugins/cockpit/bin/python``, which
``scripts/test-plugins cockpit`` makes.
"""

from __future__ import annotations

import tempfile
from contextlib import chdir
from pathlib import Path

from brains import Artist, draw_the_brain_of_the_paper
from browsing import PATIENCE_MS, Cockpits, Pages, Watched, chromium, running, time_s, wait_until
from nrp_bibi import Bibi, read_bibi, write_bibi
from nrp_lab.sweep import sweep
from playwright.sync_api import Page, expect

from nrp_core.experiment.reading.find import find_file

IMAGES = Path(__file__).parents[3] / "docs" / "images"
SIZE = {"width": 1440, "height": 900}
SWEEP = {
    "experiment": "braitenberg_husky",
    "settings": {"world.options.image_scale": 0.25},
    "vary": {
        "timestep": ["10 ms", "20 ms", "40 ms"],
        "brain.backend": ["event", "spinnaker"],
        "seed": {"from": 1, "to": 3},
    },
    "measure": ["distance"],
    "until": "1600 ms",
}
DRIVES_S = 6
"""The first screen is red, and the robot drives to it."""
SEEN_S = 9
"""The first screen was reached, and the second is red."""
BRANCH_S = 12
"""Both screens are blue again."""


def main() -> None:
    """Take the pictures."""
    expect.set_options(timeout=PATIENCE_MS)
    with running() as cockpits, chromium() as browser, tempfile.TemporaryDirectory() as folder:
        watched = Watched(Pages(browser))
        _run(watched.open(cockpits.open("braitenberg_husky"), **SIZE))
        _two_futures(watched.open(cockpits.open("braitenberg_husky"), **SIZE))
        _drawing(watched, cockpits, Path(folder) / "drive.bibi")
        _brain(watched, cockpits, Path(folder) / "drawn_brain.py")
        with chdir(folder):  # the page names the folder
            _sweep(watched, cockpits, Path("timestep.sweep"))
        _fly(watched, cockpits)


def _go_to(page: Page, t_s: int) -> None:
    """Run until a time to the step, however busy the machine is."""
    expect(page.get_by_role("button", name="Play")).to_be_enabled()  # keys are heard from now on
    slider = page.get_by_role("slider", name="Simulated time")
    for second in range(1, t_s + 1):
        slider.press("PageUp")
        page.get_by_role("timer").get_by_text(f"{second:.2f} s").wait_for()
        page.get_by_role("button", name="Play").wait_for()
    slider.blur()


def _play_until(page: Page, t_s: float) -> None:
    page.get_by_role("button", name="Play").click()
    wait_until(page, t_s)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()


def _run(page: Page) -> None:
    _go_to(page, SEEN_S)
    page.mouse.move(0, 0)
    page.wait_for_timeout(1000)
    page.screenshot(path=IMAGES / "cockpit.png")
    page.get_by_role("link", name="Functions", exact=True).click()
    page.locator(".cm-content").wait_for()
    page.wait_for_timeout(1000)
    page.screenshot(path=IMAGES / "cockpit-functions.png")


def _two_futures(page: Page) -> None:
    """A run that has seen red and blue, and a branch in which one screen becomes red again."""
    _go_to(page, BRANCH_S)
    page.keyboard.press("b")
    selected = page.frame_locator("iframe[title^='Branch']").get_by_role("region", name="Selected")
    selected.get_by_role("button", name="right_vr_screen", exact=True).click(timeout=60_000)
    selected.get_by_text("Red", exact=True).click()
    _play_until(page, time_s(page) + 2)
    page.mouse.move(0, 0)
    page.wait_for_timeout(2000)
    page.screenshot(path=IMAGES / "cockpit-compare.png")


def _drawing(watched: Watched, cockpits: Cockpits, file: Path) -> None:
    """The two listings of the paper in one drawing."""
    listings = (read_bibi(find_file("braitenberg_husky").parent / f"listing{i}.bibi") for i in (1, 2))
    write_bibi(
        Bibi(transfer_function=tuple(one for each in listings for one in each.transfer_function)), file
    )
    page = watched.open(cockpits.design(str(file), "-e", "braitenberg_husky"), **SIZE)
    _play_until(page, DRIVES_S)
    page.get_by_role("button", name="device red_left_eye Poisson").click()
    page.wait_for_timeout(2000)
    page.screenshot(path=IMAGES / "designer.png")


def _brain(watched: Watched, cockpits: Cockpits, file: Path) -> None:
    """The brain of the paper, drawn in populations by what they do."""
    artist = Artist(file)
    draw_the_brain_of_the_paper(artist)
    artist.document.save()
    page = watched.open(cockpits.design(str(file), "-e", "braitenberg_husky"), **SIZE)
    page.get_by_role("button", name="actors IF_cond_alpha").click()
    page.wait_for_timeout(2000)
    page.screenshot(path=IMAGES / "designer-brain.png")


def _sweep(watched: Watched, cockpits: Cockpits, folder: Path) -> None:
    """A sweep of two settings and some seeds."""
    sweep(SWEEP, folder, workers=2)
    page = watched.open(cockpits.open(str(folder)), **SIZE, ready=("region", "Progress"))
    page.get_by_role("img", name="distance.husky", exact=False).wait_for()
    page.wait_for_timeout(2000)
    page.screenshot(path=IMAGES / "cockpit-sweep.png")


def _fly(watched: Watched, cockpits: Cockpits) -> None:
    """An insect of true size at the sugar, with a smaller brain."""
    page = watched.open(cockpits.open("fly", "-s", "brain.parameters.cells=6000"), **SIZE)
    _play_until(page, 1.2)
    page.mouse.move(0, 0)
    page.wait_for_timeout(2000)
    page.screenshot(path=IMAGES / "cockpit-fly.png")


if __name__ == "__main__":
    main()
