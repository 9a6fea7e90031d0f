"""Parameters of cells are changed from outside a run, read again, and repeated by a replay."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from golden import Golden

from nrp_core._support.used_files import FilesRead
from nrp_core.errors import NetworkError, NeuronSelectionError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.calls import CallNoter
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest

ALONE = ["seed=4", "world.options.image_scale=0.1", "transfer_functions=[]"]
"""Without input only one cell fires, by itself."""


@pytest.fixture(params=["event", "spinnaker"])
def run(request: pytest.FixtureRequest) -> Iterator[Run]:
    with Run(load_experiment("braitenberg_husky", [*ALONE, f"brain.backend={request.param}"])) as opened:
        yield opened


def threshold(run: Run, cell: int = 5) -> float:
    """Return the threshold of a cell in mV, by default of the one that fires."""
    return float(run.brain.read_parameters("circuit")["v_thresh"][cell])


def spikes(run: Run, until_s: float) -> int:
    """Return the number of spikes on the way to a time."""
    before = run.result().spikes["circuit"]
    run.run_until(until_s)
    return run.result().spikes["circuit"] - before


def test_a_change_acts_and_is_undone_by_going_back_and_by_a_reset(run: Run) -> None:
    usual = threshold(run)
    assert spikes(run, 0.5) > 10
    before = run.snapshot()
    run.set_parameters("circuit", {"v_thresh": 1000.0})
    assert threshold(run) == 1000.0
    after = run.snapshot()
    assert spikes(run, 1.0) == 0
    run.restore(before)
    assert threshold(run) == usual
    assert spikes(run, 1.0) > 10
    run.restore(after)
    assert (threshold(run), spikes(run, 1.0)) == (1000.0, 0)
    run.reset("brain")
    assert threshold(run) == usual
    run.set_parameters("circuit", {"v_thresh": 1000.0})
    run.reset()
    assert threshold(run) == usual
    assert spikes(run, 0.5) > 10


def test_only_chosen_cells_change(run: Run, golden: Golden) -> None:
    usual = threshold(run)
    run.set_parameters("circuit", {"v_thresh": 1000.0}, [0])
    assert (threshold(run, 0), threshold(run)) == (1000.0, usual)
    assert spikes(run, 0.5) > 10
    run.set_parameters("circuit", {"v_thresh": 1000.0}, [5])
    assert spikes(run, 1.0) == 0
    with golden.raises(NetworkError, match=r"'circuit'.*\[8\]"):
        run.set_parameters("circuit", {"v_thresh": 1.0}, [8])


def test_an_unknown_population_or_parameter_is_refused(run: Run, golden: Golden) -> None:
    with golden.raises(NeuronSelectionError, match="'circuits'.*'circuit'"):
        run.set_parameters("circuits", {"v_thresh": 1.0})
    with golden.raises(NetworkError, match="'v_tresh'.*'v_thresh'"):
        run.set_parameters("circuit", {"v_tresh": 1.0})


@pytest.mark.parametrize("noted", [True, False])
def test_a_change_is_repeated_by_a_replay(
    noted: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not noted:
        monkeypatch.setattr(CallNoter, "parameters_changed", lambda *_: None)
    folder = tmp_path / "recording"
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", ALONE)) as run:
        recording = RecordingFolder(run, folder, files=files)
        run.run_until(0.3)
        run.set_parameters("circuit", {"v_thresh": 1000.0})
        run.run_until(0.6)
        recording.close("finished")
    with FilesRead() as files, Replay(Recording(folder), ReplayRequest(), files=files) as again:
        assert (again.verify().difference is None) is noted
