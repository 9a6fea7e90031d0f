"""Cells as sums of exponentials, against the matrix exponential of their equations."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.clock import NS_PER_MS, from_milliseconds
from nrp_core.network.changes import ParameterChange
from nrp_core.network.data import Population, Projection

Cells = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]

_READ_MS = (0.3, 4.0, 61.0, 700.0, 2000.0)
_CHANGED_MS, _END_MS = 900.0, 2000.0


def expected(
    parameters: Mapping[float, Mapping[str, float]], inputs: list[tuple[float, int, float]]
) -> list[float]:
    """Return the voltage at the times of reading, mV.

    Args:
        parameters: of the cell, by the time from which on they hold.
        inputs: time, receptor and weight of each spike.
    """
    moments = sorted({*_READ_MS, *parameters, *(t for t, _, _ in inputs)})
    state, now, found, matrix = np.array([0.0, 0.0, 0.0]), 0.0, [], np.zeros((3, 3))
    for t in moments:
        state, now = expm(matrix * (t - now)) @ state, t
        if t in parameters:
            own = parameters[t]
            matrix = np.diag([-1.0 / own["tau_m"], -1.0 / own["tau_syn_E"], -1.0 / own["tau_syn_I"]])
            matrix[0, 1:] = 1.0 / own["cm"]
        for _, receptor, weight in (one for one in inputs if one[0] == t):
            state[1 + receptor] += weight
        if t in _READ_MS:
            found.append(state[0] - 65.0)
    return found


@pytest.mark.one_of(8)
@pytest.mark.parametrize("tau_syn", [(2.0, 7.0), (40.0, 0.05), (20.0, 5.0), (20.5, 19.0)])
def test_the_voltage_follows_the_equations_through_changes_of_parameters(
    tau_syn: tuple[float, float], cells: Cells, open_brain: Open
) -> None:
    """The change makes time constants equal that differed, and the other way round."""
    rng = np.random.default_rng(3)
    own = {"tau_m": 20.0, "cm": 0.4, "tau_syn_E": tau_syn[0], "tau_syn_I": tau_syn[1]}
    later = {**own, "tau_m": tau_syn[1], "tau_syn_E": 3.0}
    times_ms = np.concatenate([[0.0, 0.1, 3.9], rng.uniform(0.0, _END_MS, 150)])
    inputs = [(float(t), k % 2, float(rng.uniform(-0.2, 0.4))) for k, t in enumerate(times_ms)]
    brain = open_brain(cells("a", "IF_curr_exp", 3, v_thresh=np.inf, **own))
    for t_ms, receptor, weight in inputs:
        kind = ("excitatory", "inhibitory")[receptor]
        brain._do_inject(SynapticEvents(np.array([1]), np.array([t_ms]), np.array([weight]), kind))
    found = []
    for t_ms in sorted({*_READ_MS, _CHANGED_MS}):
        brain.run_until(from_milliseconds(t_ms))
        if t_ms == _CHANGED_MS:
            values = {name: np.array([value]) for name, value in later.items()}
            brain._do_set_parameters(ParameterChange("a", np.array([1]), values))
        else:
            found.append(brain.read_state("v", [1])[0])
    np.testing.assert_allclose(found, expected({0.0: own, _CHANGED_MS: later}, inputs), rtol=0, atol=2e-11)
    assert brain.read_state("v", [0, 2]).tolist() == [-65.0, -65.0]


@given(cuts=st.lists(st.integers(0, 60 * NS_PER_MS), min_size=20, max_size=60))
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_many_spikes_within_a_window_do_not_depend_on_the_division_of_the_run(
    cuts: list[int], cells: Cells, connect: Connect, open_brain: Open
) -> None:
    """A window of the calendar is a millisecond here: a cell fires, recovers and is searched in it."""
    n = 12
    drive = np.linspace(6.0, 14.0, n)
    cell = cells("a", "IF_curr_exp", n, i_offset=drive, tau_refrac=0.11, tau_syn_E=1.7, tau_syn_I=3.1)
    pairs = [(i, (i * 5 + k) % n) for i in range(n) for k in (1, 2)]
    inhibition = connect("a", "a", -0.3, 1.0, pairs=pairs, receptor="inhibitory")
    excitation = connect("a", "a", 0.2, 1.3, pairs=pairs, label="more")
    found = []
    for ends in ([], sorted(cuts)):
        brain = open_brain(cell, inhibition, excitation)
        recorder = brain.add_sink(SpikeRecorder(), np.arange(n), name="all")
        for end in (*ends, 60 * NS_PER_MS):
            brain.run_until(end)
        spikes = recorder.spikes()  # type: ignore[attr-defined]
        found.append((spikes.neurons.tolist(), spikes.times_ms.tolist()))
    assert len(found[0][0]) > 300
    assert found[0] == found[1]


def test_jumps_decay_with_the_membrane_through_changes_of_its_time_constant(
    cells: Cells, open_brain: Open
) -> None:
    rng = np.random.default_rng(5)
    times_ms, weights = rng.uniform(0.0, 400.0, 300), rng.uniform(-2.0, 3.0, 300)
    brain = open_brain(cells("a", "IF_curr_delta", 3, v_thresh=np.inf, tau_m=20.0))
    brain._do_inject(SynapticEvents(np.full(300, 1), times_ms, weights))

    def voltage(until_ms: float, tau_ms: float, since_ms: float, begin_mv: float) -> float:
        due = (times_ms > since_ms) & (times_ms <= until_ms)
        decayed = weights[due] * np.exp((times_ms[due] - until_ms) / tau_ms)
        return float(begin_mv * np.exp((since_ms - until_ms) / tau_ms) + decayed.sum())

    brain.run_until(from_milliseconds(200.0))
    half_mv = voltage(200.0, 20.0, 0.0, 0.0)
    assert brain.read_state("v", [1])[0] + 65.0 == pytest.approx(half_mv, abs=1e-11)
    brain.set_parameters([0, 1, 2], {"tau_m": 7.0})
    brain.run_until(from_milliseconds(400.0))
    end_mv = voltage(400.0, 7.0, 200.0, half_mv)
    assert brain.read_state("v", [1])[0] + 65.0 == pytest.approx(end_mv, abs=1e-11)
    assert brain.read_state("v", [0, 2]).tolist() == [-65.0, -65.0]


@pytest.mark.parametrize("again_ms", [2.0, 2.0 - 0.9e-9, 2.1, 31.7])
def test_a_jump_to_the_threshold_itself_fires(again_ms: float, cells: Cells, open_brain: Open) -> None:
    """Also at the end of the refractory period, and at times where the coefficients have rounding errors."""
    begin_ms = 143.3
    brain = open_brain(
        cells("a", "IF_curr_delta", 1, {"v": 0.0}, v_rest=0.0, v_reset=0.0, v_thresh=20.0, tau_refrac=2.0)
    )
    recorder = brain.add_sink(SpikeRecorder(), np.arange(1), name="all")
    times_ms = np.array([begin_ms, begin_ms + again_ms])
    brain._do_inject(SynapticEvents(np.array([0, 0]), times_ms, np.array([20.0, 20.0])))
    brain.run_until(from_milliseconds(200.0))
    fired_ms = recorder.spikes().times_ms  # type: ignore[attr-defined]
    np.testing.assert_allclose(fired_ms, [begin_ms, begin_ms + max(again_ms, 2.0)], rtol=0, atol=1e-12)


def test_a_jump_in_the_refractory_period_is_lost(cells: Cells, open_brain: Open) -> None:
    brain = open_brain(cells("a", "IF_curr_delta", 1, v_thresh=-50.0, v_reset=-65.0, tau_refrac=2.0))
    brain._do_inject(SynapticEvents(np.array([0, 0]), np.array([1.0, 2.9]), np.array([16.0, 5.0])))
    brain.run_until(from_milliseconds(3.5))
    assert brain.read_state("v", [0])[0] == -65.0
