"""A cockpit in its own process, and a page of it in Debian's Chromium."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import Cockpits, Watched, chromium
from playwright.sync_api import Browser

from nrp_core.experiment.reading.find import find_file

BROKEN = """\
@nrp.MapRobotSubscriber("states", Topic("/gazebo/model_states", gazebo_msgs.msg.ModelStates))
@nrp.Robot2Neuron()
def divides(t, states):
    if t >= 0.0:
        1 / len(states.value.name[99:])
"""


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.fixture
def cockpits() -> Iterator[Cockpits]:
    cockpits = Cockpits()
    yield cockpits
    cockpits.close()


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """The experiment of the Husky in a folder of its own, with one more function, which fails at once."""
    folder = tmp_path / "husky"
    shutil.copytree(find_file("braitenberg_husky").parent, folder)
    file = folder / "experiment.yaml"
    file.write_text(file.read_text().replace("listing2.py]", "listing2.py, broken.py]"))
    (folder / "broken.py").write_text(BROKEN)
    return file


@pytest.fixture
def watched(browser: Browser) -> Iterator[Watched]:
    """Pages that must neither complain nor ask anybody outside."""
    watched = Watched(browser)
    yield watched
    assert watched.complaints == []
    assert watched.outside == []
    for context in browser.contexts:
        context.close()
