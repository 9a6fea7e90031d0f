"""Each panel looks as in its picture, which a person has looked at."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_cockpit.sharing.sharing import shared_file
from playwright.sync_api import Browser, Locator, Page
from stories import STYLED, Stories, settled, shown

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder

SETTINGS = (
    "duration=2 s",
    "world.options.image_scale=0.25",
    "events.left_red.at=0.5 s",
    "criteria.reaches_left.within_of.time=1 s",  # not met, so that the page opens there
)
PANELS = ("scene", "camera", "map", "brain", "spikes", "traces", "inspector", "timeline")
WIDE, NARROW = (1440, 900), (820, 2300)
WEBGL = 0.1
"""The tolerance of a scene: another library of graphics draws other edges."""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shared recording of two seconds in which a criterion is not met."""
    folder = tmp_path_factory.mktemp("stories") / "stories"
    with Run(load_experiment("braitenberg_husky", list(SETTINGS))) as run:
        recorded = RecordingFolder(run, folder)
        run.run_until(2.0)
        recorded.close("finished")
    file = folder.with_suffix(".html")
    file.write_text(shared_file(folder).html)
    return file


def panels(page: Page) -> dict[str, Locator]:
    return {name: page.locator(f"[data-panel={name}]") for name in PANELS}


def test_the_panels_look_as_in_their_pictures(file: Path, browser: Browser, stories: Stories):
    with shown(browser, file.as_uri(), WIDE, "light") as page:
        stories.compare("light", settled(page, panels(page)), scene=WEBGL)
        page.get_by_role("link", name="Functions").click()
        page.locator(".cm-content").wait_for()
        page.mouse.move(0, 0)
        stories.compare("light", settled(page, {"functions": page.get_by_role("main")}))


def test_narrow_dark_panels_look_as_in_their_pictures(file: Path, browser: Browser, stories: Stories):
    with shown(browser, file.as_uri(), NARROW, "dark") as page:
        all_panels = panels(page)
        all_panels["spikes"].get_by_role("radio", name="Rates").click()
        all_panels["inspector"].get_by_role("button", name="circuit", exact=True).click()
        page.mouse.move(0, 0)
        stories.compare("dark", settled(page, all_panels), scene=WEBGL)
        all_panels["spikes"].get_by_role("radio", name="Heat").click()
        page.get_by_role("button", name="Clear the selection").click()
        all_panels["inspector"].get_by_role("button", name="husky", exact=True).click()
        page.mouse.move(0, 0)
        some = {"heat": all_panels["spikes"], "body": all_panels["inspector"]}
        stories.compare("dark", settled(page, some))


@pytest.mark.parametrize(
    ("fault", "changed"),
    [
        (
            "CanvasRenderingContext2D.prototype.fillText = () => {};"
            + STYLED
            + "('.timeline-ruler { visibility: hidden }')",
            {"spikes", "traces", "map", "timeline"},
        ),
        (STYLED + "(':root { --d-vermillion: #0072b2 }')", {"brain", "spikes", "traces"}),
    ],
    ids=["no numbers", "another colour"],
)
def test_a_fault_is_seen_in_the_pictures_of_its_panels_alone(
    fault: str, changed: set[str], file: Path, browser: Browser, tmp_path: Path
):
    stories = Stories(tmp_path)
    with shown(browser, file.as_uri(), WIDE, "light", fault) as page:
        stories.compare("light", settled(page, panels(page)), scene=WEBGL)
    names = {f"light-{panel}" for panel in changed}
    assert stories.wrong.keys() == names
    files = {f"{name}{kind}.png" for name in names for kind in ("", ".difference")}
    assert {path.name for path in tmp_path.iterdir()} == files
    with pytest.raises(pytest.fail.Exception, match=str(tmp_path)):
        stories.close()
