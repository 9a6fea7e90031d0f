"""The start page shows what can be opened, opens it at the same address, and comes back after it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browsing import PATIENCE_MS, Cockpits, Watched
from nrp_lab.sweep import sweep
from playwright.sync_api import Page, expect
from visitors import RefusedError, visit

from nrp_core.experiment.reading.find import shipped

SHORT = "extends: slalom_pioneer\nname: short\nduration: 1 s\ndescription: A short way.\n"
SWEEP = {"experiment": "short.yaml", "vary": {"seed": {"from": 1, "to": 2}}, "until": "40 ms"}


@pytest.fixture
def folder(tmp_path: Path, recording: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a good and a broken experiment, a recording and a sweep."""
    monkeypatch.chdir(tmp_path)
    Path("short.yaml").write_text(SHORT)
    Path("broken.yaml").write_text(SHORT.replace("slalom_pioneer", "slalom_pionier"))
    Path("results").mkdir()
    Path("results/visit").symlink_to(recording)  # links are not followed
    (tmp_path / "seen").mkdir()
    for file in recording.iterdir():
        (tmp_path / "seen" / file.name).symlink_to(file)
    sweep(SWEEP, tmp_path / "seeds.sweep", workers=1)
    return tmp_path


def leave(page: Page) -> None:
    page.get_by_role("button", name="Start page").click()
    page.get_by_role("menuitem", name="Close this and open another").click()
    page.get_by_role("region", name="Installed experiments").wait_for()


def test_experiments_recordings_and_sweeps_are_opened_one_after_another(
    folder: Path, cockpits: Cockpits, watched: Watched
) -> None:
    page = watched.open(cockpits.open(), ready=("region", "Installed experiments"))
    address = page.url.partition("#")[0]
    installed = page.get_by_role("region", name="Installed experiments")
    for variants in installed.get_by_text(re.compile(r"^\d+ variants?$")).all():
        variants.click()
    cards = installed.get_by_role("button")
    labels = [card.get_attribute("aria-label") for card in cards.all()]
    assert labels == [f"Open {name}" for name in shipped()]
    here = page.get_by_role("region", name="Experiments in this folder")
    expect(here.get_by_role("listitem")).to_have_count(2)  # not those inside of recordings
    expect(here.get_by_role("button", name="broken.yaml")).to_be_disabled()
    expect(here.get_by_role("button", name="broken.yaml")).to_contain_text("did you mean 'slalom_pioneer'")
    page.get_by_role("searchbox", name="Search").fill("short way")
    expect(page.get_by_role("main").get_by_role("listitem")).to_have_count(1)
    page.get_by_role("button", name="Open ./short.yaml").press("Enter")
    page.get_by_role("button", name="Play").click()
    expect(page.get_by_role("timer")).to_contain_text("1.00 s of 1 s")
    assert page.url.partition("#")[0] == address
    leave(page)
    page.get_by_role("button", name="Open ./seen").click()
    expect(page.get_by_role("timer")).to_contain_text("of 2 s")
    expect(page.get_by_text("Recording", exact=True)).to_be_visible()
    leave(page)
    page.get_by_role("button", name="Open ./seeds.sweep").click()
    expect(page.get_by_role("region", name="Progress")).to_contain_text("2 of 2 runs")
    leave(page)
    expect(page.get_by_role("region", name="Recordings in this folder").get_by_role("button")).to_have_count(
        1
    )


def test_a_hidden_or_broken_experiment_is_refused_and_the_page_stays(
    folder: Path, cockpits: Cockpits
) -> None:
    with visit(cockpits.open("--brain", "evnt")) as visitor:
        for name, words in {"../other.yaml": "does not show", "short.yaml": "did you mean './short.yaml'",
                            "./short.yaml": "did you mean 'event'"}.items():  # fmt: skip
            with pytest.raises(RefusedError, match=words):
                visitor.call("start/open", name=name)
        visitor.subscribe("/cockpit/start")
        assert visitor.until(lambda: visitor.last("start"))["entries"]


@pytest.mark.heavy
def test_each_experiment_shows_its_scene(folder: Path, cockpits: Cockpits, watched: Watched) -> None:
    page = watched.open(cockpits.open(), ready=("region", "Installed experiments"))
    card = page.get_by_role("button", name="Open braitenberg_husky", exact=True)
    scene = card.locator("img[alt='The scene of braitenberg_husky']")
    scene.wait_for(timeout=4 * PATIENCE_MS)  # it may be drawn now
    assert scene.evaluate("image => [image.naturalWidth, image.naturalHeight]") == [480, 270]
    assert page.get_by_role("button", name="Open ./seen").locator("img").count() == 0
