"""A cockpit in its own process, and a page of it in Debian's Chromium."""

from __future__ import annotations

import shutil
import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from browsing import HUSKY, PATIENCE_MS, Cockpits, Kept, Pages, Watched, chromium, running
from playwright.sync_api import Browser, expect
from visitors import cockpit

from nrp_core.experiment.reading.find import find_file

expect.set_options(timeout=PATIENCE_MS)

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
    with running() as cockpits:
        yield cockpits


@pytest.fixture
def in_process() -> Iterator[Callable[..., str]]:
    """Opens a cockpit in this process, at a quarter of the cost of another one, and returns its address."""
    with ExitStack() as opened:
        yield (
            lambda *overrides, experiment: (
                opened.enter_context(cockpit(*overrides, experiment=experiment)).address
            )
        )


@pytest.fixture(scope="session")
def kept() -> Iterator[Kept]:
    kept = Kept()
    yield kept
    kept.close()


@pytest.fixture
def husky(kept: Kept) -> str:
    """The address of a cockpit with the experiment of the Husky, at its beginning."""
    return kept.open("braitenberg_husky", *HUSKY)


@pytest.fixture(scope="session")
def port() -> int:
    """A port that nobody listens on."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return int(taken.getsockname()[1])


@pytest.fixture(scope="session")
def played(recording: Path, other_recording: Path, port: int) -> Iterator[str]:
    """The address of a cockpit that plays the recording, open to other machines on this port."""
    assert other_recording.parent == recording.parent
    with running() as cockpits:
        yield cockpits.open(str(recording), "--host", "0.0.0.0", "--port", str(port))


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """The experiment of the Husky in a folder of its own, with one more function, which fails at once."""
    folder = tmp_path / "husky"
    shutil.copytree(find_file("braitenberg_husky").parent, folder)
    file = folder / "experiment.yaml"
    file.write_text(file.read_text().replace("listing2.py]", "listing2.py, broken.py]"))
    (folder / "broken.py").write_text(BROKEN)
    return file


@pytest.fixture(scope="session")
def pages(browser: Browser) -> Pages:
    return Pages(browser)


@pytest.fixture
def watched(pages: Pages) -> Iterator[Watched]:
    """Pages that must neither complain nor ask anybody outside."""
    watched = Watched(pages)
    yield watched
    watched.close()
    assert watched.complaints == []
    assert watched.outside == []
