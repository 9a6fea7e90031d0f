"""Membrane voltages of single cells are recorded, replayed, drawn and exported."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from nrp_core._support.used_files import FilesRead
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import InvalidExperimentError
from nrp_core.recording.export.numbers import write_csv
from nrp_core.recording.figures.page import _rows
from nrp_core.recording.figures.story import Story
from nrp_core.recording.figures.style import Panel
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import Images
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest

TAU_MS, REST_MV, DRIVE_NA, MV_PER_NA = 20.0, -65.0, (0.0, 0.25, 0.5), 20.0
BRAIN = f"""
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
circuit = sim.Population(
    3, sim.IF_curr_exp(tau_m={TAU_MS}, cm=1.0, v_rest={REST_MV}, i_offset={list(DRIVE_NA)}), label="circuit"
)
sim.Population(1, sim.SpikeSourcePoisson(rate=1.0), label="noise")
"""
SETTINGS = (
    "brain.populations={sensors: null, actors: null, pair: '1:3'}",
    "transfer_functions=[]", "aliases=null", "events=null",
    "criteria=null", "comparison.vary=null", "world.options.image_scale=0.1", "duration=0.1 s",
)  # fmt: skip
CHOSEN = "recording.voltages={circuit: {cells: [2, 0], interval: 0.5 ms}, pair: {}}"


@pytest.fixture
def settings(tmp_path: Path) -> list[str]:
    (tmp_path / "brain.py").write_text(BRAIN)
    return [f"brain.model={tmp_path / 'brain.py'}", *SETTINGS]


def recorded(folder: Path, settings: list[str]) -> Recording:
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", settings)) as run:
        snapshots = 40_000_000
        recording = RecordingFolder(run, folder, images=Images.OFF, files=files, snapshots_ns=snapshots)
        run.run()
        recording.close("finished")
    return Recording(folder)


def voltage_mv(times_ms: np.ndarray, cell: int) -> np.ndarray:
    """Return the voltage of a charged membrane."""
    return REST_MV + DRIVE_NA[cell] * MV_PER_NA * (1 - np.exp(-times_ms / TAU_MS))


@pytest.mark.parametrize(("backend", "step_s"), [("event", 0.0005), ("spinnaker", 0.001)])
def test_voltages_of_chosen_cells_are_samples_of_the_membrane(
    tmp_path: Path, settings: list[str], backend: str, step_s: float
) -> None:
    recording = recorded(tmp_path / "out", [*settings, CHOSEN, f"brain.backend={backend}"])
    table = recording.frame("/brain/circuit/voltages")
    assert list(table.columns) == ["data.2", "data.0"]
    assert set(table.attrs["units"].values()) == {"mV"}
    np.testing.assert_allclose(table.index, np.arange(0, 0.1001, step_s), atol=1e-9)
    for cell in (2, 0):
        error = table[f"data.{cell}"] - voltage_mv(table.index.to_numpy() * 1e3, cell)
        assert np.abs(error).max() < (1e-9 if backend == "event" else 0.1)
    pair = recording.frame("/brain/pair/voltages")
    assert (len(pair), list(pair.columns)) == (101, ["data.0", "data.1"])
    with Replay(recording, ReplayRequest()) as replay:
        assert replay.verify().identical
    later = ReplayRequest(from_ns=60_000_000, record=tmp_path / "later")
    with FilesRead() as files, Replay(recording, later, files=files) as replay:
        replay.go()
    with Replay(Recording(tmp_path / "later"), ReplayRequest()) as replay:
        assert replay.verify().difference is None
    with Replay(recording, ReplayRequest(recorded=frozenset({"brain"}))) as replay:
        assert replay.verify().difference is None


def test_voltages_are_drawn_and_exported(tmp_path: Path, settings: list[str]) -> None:
    recording = recorded(tmp_path / "out", [*settings, CHOSEN])
    files = {path.name: path for path in write_csv(recording, tmp_path / "csv")}
    headers, *rows = csv.reader(files["brain.circuit.voltages.csv"].read_text().splitlines())
    assert headers == ["time_s", "data.2 [mV]", "data.0 [mV]"]
    np.testing.assert_allclose(float(rows[-1][1]), voltage_mv(np.array(100.0), 2))
    story = Story.of(recording)
    labels = [one.label for one in story.voltages.values()]
    assert sorted(labels) == ["circuit[0]", "circuit[2]", "pair[0]", "pair[1]"]
    assert [title for _, title, _ in _rows(story, [], [Panel.VOLTAGES])] == ["Voltages (mV)"]
    figure = recording.plot(panels=[Panel.VOLTAGES])
    assert "Voltages (mV)" in [axes.get_title(loc="left") for axes in figure.axes]


@pytest.mark.parametrize(
    ("chosen", "code"),
    [("{circit: {}}", "NRP211"), ("{circuit: {cells: [3]}}", "NRP211"), ("{noise: {}}", "NRP216"),
     ("{circuit: {cells: []}}", "NRP202"), ("{circuit: {interval: 0 ms}}", "NRP202")],
)  # fmt: skip
def test_cells_without_a_voltage_are_an_error(settings: list[str], chosen: str, code: str) -> None:
    with pytest.raises(InvalidExperimentError) as refused:
        Run(load_experiment("braitenberg_husky", [*settings, f"recording.voltages={chosen}"]))
    assert code in [finding.code.name for finding in refused.value.findings if finding.level == "error"]
