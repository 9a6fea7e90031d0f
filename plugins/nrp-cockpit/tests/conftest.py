"""Settings of all tests of the cockpit."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from visitors import Cockpit, Visitor

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder

pytest_plugins = ["cases", "golden", "stories"]  # the first two in tests/shared


@pytest.fixture(scope="session", autouse=True)
def settings_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the user's settings, in which layouts are saved."""
    folder = tmp_path_factory.mktemp("settings")
    os.environ["XDG_CONFIG_HOME"] = str(folder)
    return folder


@pytest.fixture(autouse=True)
def usual_layouts(settings_folder: Path) -> None:
    """Begin each test with the presets, whatever another has moved."""
    shutil.rmtree(settings_folder / "nrp-core" / "cockpit", ignore_errors=True)


@pytest.fixture
def visitor(opened: Cockpit) -> Iterator[Visitor]:
    """Somebody who steers a run that is at its beginning."""
    with opened.visit() as visitor:
        visitor.subscribe("/cockpit/status", "/cockpit/timeline", "/cockpit/functions", "/cockpit/log")
        visitor.call("pause")
        visitor.call("functions/revert")
        visitor.call("reset", what="all")
        visitor.call("pace", factor=None)
        visitor.status(state="paused", t_s=0.0, pace=None)
        yield visitor
        visitor.call("pause")
        visitor.call("record", folder=None)


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of recordings."""
    return tmp_path_factory.mktemp("recordings")


@pytest.fixture(scope="session")
def recording(recordings: Path) -> Path:
    """The recording of two seconds, in which a screen turns red."""
    return record(recordings / "husky", red_at="0.5 s")


@pytest.fixture(scope="session")
def other_recording(recordings: Path) -> Path:
    """A recording beside it, in which the screen turns red later."""
    return record(recordings / "later", red_at="1 s")


def record(folder: Path, red_at: str) -> Path:
    """Record two seconds of the Husky and return the folder."""
    settings = ["duration=2 s", "world.options.image_scale=0.25", f"events.left_red.at={red_at}"]
    with Run(load_experiment("braitenberg_husky", settings)) as run:
        recorded = RecordingFolder(run, folder)
        run.run_until(2.0)
        recorded.close("finished")
    return folder
