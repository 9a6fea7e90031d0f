"""Muscles in recordings: their commands and states come back from files, replays, snapshots and resets."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.export import Format, export
from nrp_core.recording.figures.story import Story
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.reading.recording import Recording

MUSCLES = "shoulder_flexor", "shoulder_extensor", "elbow_flexor", "elbow_extensor"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The folder of 100 ms of the reflex arm, and the last message of the states of its muscles."""
    folder = tmp_path_factory.mktemp("muscles") / "recording"
    with Run(load_experiment("reflex_arm", ["duration=100 ms"])) as run:
        recording_folder = RecordingFolder(run, folder)
        states = run.world.subscribe("/arm/muscles/state")
        run.run()
        recording_folder.close("finished")
        assert states.latest is not None
        return folder, {name: getattr(states.latest.message, name) for name in ("force", "activation")}


def test_a_table_and_a_figure_have_a_column_and_a_curve_for_each_muscle(
    recorded: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    recording, last = Recording(recorded[0]), recorded[1]
    export(recording, Format.CSV, tmp_path / "out")
    commands = _rows(tmp_path / "out" / "arm.muscles.cmd.csv")
    assert list(commands[0]) == ["time_s", *(f"data.{name}" for name in MUSCLES)]
    states = _rows(tmp_path / "out" / "arm.muscles.state.csv")
    for field, unit in (("force", " [N]"), ("activation", "")):
        values = [float(states[-1][f"{field}.{name}{unit}"]) for name in MUSCLES]
        np.testing.assert_array_equal(values, last[field])
    curves = Story.of(recording).commands
    for name in MUSCLES:
        assert curves[f"/arm/muscles/cmd.data.{name}"].label == f"/arm/muscles/cmd.{name}"
        drawn = curves[f"/arm/muscles/cmd.data.{name}"].values
        assert drawn == [float(row[f"data.{name}"]) for row in commands]
        assert any(drawn)


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))
