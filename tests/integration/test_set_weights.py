"""Weights are changed from outside a run, as a function of it would change them, and a replay repeats it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from golden import Golden

from nrp_core._support.arrays import FloatArray
from nrp_core._support.used_files import FilesRead
from nrp_core.errors import NetworkError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.observers import StepObserver
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.calls import CallNoter
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest

BRAIN = """\
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
cells = sim.Population(2, sim.IF_curr_exp(tau_m=10.0, tau_refrac=2.0), label="cells")

def drive(cell, times_ms, weight, label):
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=times_ms))
    synapse = sim.StaticSynapse(weight=weight, delay=1.0)
    sim.Projection(source, cells[cell:cell + 1], sim.AllToAllConnector(), synapse, label=label)

drive(0, [1.0, 101.0], 0.5, "weak")
drive(1, [20.0 * beat + 1.0 for beat in range(15)], 6.0, "strong")
"""
FUNCTION = """\
import hbp_nrp_client.tf_framework as nrp

@nrp.MapWeights("w", nrp.brain.projection("strong"))
@nrp.Robot2Neuron()
def change(t, w):
    if abs(t - 0.1) < 1e-9:
        w.values = w.values * 2
"""


@pytest.fixture(params=["event", "spinnaker"])
def opened(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[..., Run]:
    """Open a run of two cells, each with one synapse, whose transfer functions are given."""
    (tmp_path / "brain.py").write_text(BRAIN)
    brain = f"brain={{backend: {request.param}, model: {tmp_path}/brain.py, populations: null}}"

    def start(*functions: Path) -> Run:
        named = f"transfer_functions={list(map(str, functions))}"
        small = ["world.options.image_scale=0.1", "duration=0.3 s", "events=null", "criteria=null"]
        return Run(load_experiment("braitenberg_husky", [brain, named, *small]))

    return start


def voltages(run: Run, call: Callable[[], object] = lambda: None) -> FloatArray:
    """Return the voltages at the end of each step of a run, which is called at 0.1 s."""
    seen: list[FloatArray] = []
    with run:
        cells = run.brain.network.neurons("cells")
        run.observers.append(StepObserver(lambda run: seen.append(run.brain.read_state("v", cells))))
        run.run_until(0.1)
        call()
        run.run_until(0.3)
    return np.array(seen)


def test_it_equals_a_function_that_sets_the_weights_at_the_same_time(
    opened: Callable[..., Run], tmp_path: Path
) -> None:
    (tmp_path / "change.py").write_text(FUNCTION)
    usual, by_function, run = voltages(opened()), voltages(opened(tmp_path / "change.py")), opened()
    by_hand = voltages(run, lambda: run.set_weights("strong", 2.0, relative=True))
    np.testing.assert_array_equal(by_hand, by_function)
    assert not np.array_equal(by_hand, usual)


def test_twice_the_weight_is_twice_the_potential_and_going_back_undoes_it(opened: Callable[..., Run]) -> None:
    with opened() as run:
        cell = run.brain.network.neurons("cells")[:1]
        rest_mv = run.brain.read_state("v", cell)[0]
        response_mv = []
        for change in (None, 1.0):
            if change:
                before = run.snapshot()
                run.set_weights("weak", change)
                assert run.brain.read_weights("weak").tolist() == pytest.approx([1.0], rel=1e-3)
            run.run_until(run.now_s + 0.02)
            response_mv.append(run.brain.read_state("v", cell)[0] - rest_mv)
            run.run_until(run.now_s + 0.08)
        assert response_mv[1] / response_mv[0] == pytest.approx(2.0, rel=2e-3)  # e^-10 of the first is left
        run.restore(before)
        assert run.brain.read_weights("weak").tolist() == pytest.approx([0.5], rel=1e-3)


def test_what_is_no_weight_is_refused(opened: Callable[..., Run], golden: Golden) -> None:
    with opened() as run:
        with golden.raises(NetworkError, match="'wek'.*'weak'"):
            run.set_weights("wek", 1.0)
        with golden.raises(NetworkError, match="2"):
            run.set_weights("weak", [1.0, 2.0], relative=True)
        with golden.raises(NetworkError, match="nan"):
            run.set_weights("weak", float("nan"), relative=True)


@pytest.mark.parametrize("noted", [True, False])
def test_a_replay_repeats_it(
    opened: Callable[..., Run], noted: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not noted:
        monkeypatch.setattr(CallNoter, "weights_changed", lambda *_: None)
    with FilesRead() as files, opened() as run:
        recording = RecordingFolder(run, tmp_path / "recording", files=files)
        run.run_until(0.1)
        run.set_weights("strong", 2.5, relative=True)
        run.set_weights("weak", np.array([7.0]))
        run.run_until(0.2)
        recording.close("finished")
    recorded = Recording(tmp_path / "recording")
    with FilesRead() as files, Replay(recorded, ReplayRequest(), files=files) as again:
        assert (again.verify().difference is None) is noted
