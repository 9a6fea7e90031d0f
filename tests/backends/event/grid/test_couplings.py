"""Gap junctions and graded release, against the integration of all membranes together by SciPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event.backend import EventBackend
from scipy.integrate import solve_ivp

from nrp_core._support.arrays import FloatArray
from nrp_core.brain import SpikeRecorder, builder
from nrp_core.brain.interface import Brain
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Network

JUNCTIONS = [(0, 1, 0.02), (1, 2, 0.005)]
CONDUCTANCES = np.array([[0.0, 0.02, 0.0], [0.02, 0.0, 0.005], [0.0, 0.005, 0.0]])
CURRENTS = np.array([0.3, 0.0, 0.1])
START = np.array([-60.0, -70.0, -65.0])
LEAKY = {"v_rest": -65.0, "tau_m": 20.0, "cm": 1.0, "v_reset": -65.0, "v_thresh": 0.0, "tau_refrac": 3.0}
CHANNELS = {
    "v_offset": -63.0, "gbar_Na": 20.0, "gbar_K": 6.0, "g_leak": 0.01, "cm": 0.2, "e_rev_leak": -65.0,
    "e_rev_Na": 50.0, "e_rev_K": -90.0,
}  # fmt: skip


def leaky_equations(sim: Any) -> Any:
    cell = sim.EquationCell(
        "dv/dt = (v_rest - v)/tau_m + i_offset/cm : mV",
        threshold="v > 0*mV",
        reset="v = v_rest",
        receptors={"excitatory": "v += weight"},
        parameters={"v_rest": "-65 mV", "tau_m": "20 ms", "cm": "1 nF", "i_offset": "0 nA"},
    )
    return cell(i_offset=CURRENTS.tolist())


def chain(make: Callable[[Any], Any], weights: list[Any] = JUNCTIONS, **initial: Any) -> Network:
    """Return three cells in a chain of gap junctions."""
    sim = builder()
    sim.setup(timestep=0.1)
    cells = sim.Population(len(START), make(sim), label="cells")
    cells.initialize(v=START.tolist(), **initial)
    listed = sim.FromListConnector(weights, column_names=["weight"])
    sim.Projection(cells, cells, listed, sim.ElectricalSynapse(), label="gap")
    return sim.network()


def opened(network: Network, step_ms: float, **options: Any) -> Brain:
    backend = EventBackend()
    chosen = backend.options.model_validate({"resolution": f"{step_ms} ms", **options})
    return backend.open(network, seed=0, options=chosen)


def voltages(brain: Brain, until_ms: int) -> FloatArray:
    """Return the voltages of all cells in each ms."""
    found = []
    for t_ms in range(1, until_ms + 1):
        brain.run_until(t_ms * 1_000_000)
        found.append(brain.read_state("v", range(brain.network.size)))
    return np.array(found)


def through_junctions(v: FloatArray, conductances: FloatArray = CONDUCTANCES) -> FloatArray:
    return conductances @ v - conductances.sum(axis=1) * v


def integrated(slopes: Callable[[float, FloatArray], FloatArray], start: FloatArray, until_ms: int) -> Any:
    found = solve_ivp(
        slopes, (0.0, until_ms), start, method="LSODA", rtol=1e-10, atol=1e-11,
        t_eval=np.arange(1.0, until_ms + 1),
    )  # fmt: skip
    return found.y[: len(START)].T


def leak(_: float, v: FloatArray) -> FloatArray:
    return (-65.0 - v) / 20.0 + CURRENTS + through_junctions(v)


@pytest.mark.parametrize("kind", ["IF_curr_exp", "IF_cond_exp", "IF_curr_delta", "EquationCell"])
def test_leaky_cells_follow_their_common_equations_to_second_order(kind: str) -> None:
    def make(sim: Any) -> Any:
        if kind == "EquationCell":
            return leaky_equations(sim)
        return getattr(sim, kind)(**LEAKY, i_offset=CURRENTS.tolist())

    expected, errors = integrated(leak, START, 60), []
    for step_ms in (0.2, 0.1):
        with opened(chain(make), step_ms) as brain:
            errors.append(abs(voltages(brain, 60) - expected).max())
    assert errors[1] < 3e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.3)


def gates(v: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Return the opening and closing rates of the gates m, h and n (Traub & Miles 1991)."""
    u = v - CHANNELS["v_offset"]

    def bent(x: FloatArray, scale: float) -> FloatArray:
        return x / np.expm1(x / scale)

    return [
        (0.32 * bent(13.0 - u, 4.0), 0.28 * bent(u - 40.0, 5.0)),
        (0.128 * np.exp((17.0 - u) / 18.0), 4.0 / (np.exp((40.0 - u) / 5.0) + 1.0)),
        (0.032 * bent(15.0 - u, 5.0), 0.5 * np.exp((10.0 - u) / 40.0)),
    ]


def channels(_: float, state: FloatArray) -> FloatArray:
    v, m, h, n = state.reshape(4, -1)
    current = CURRENTS + through_junctions(v) + 0.01 * (-65.0 - v)
    current += 20.0 * m**3 * h * (50.0 - v) + 6.0 * n**4 * (-90.0 - v)
    slopes = [a * (1.0 - x) - b * x for (a, b), x in zip(gates(v), (m, h, n), strict=True)]
    return np.concatenate([current / 0.2, *slopes])


def test_spikes_of_hodgkin_and_huxley_pass_a_junction_to_second_order() -> None:
    open_gates = [a / (a + b) for a, b in gates(START)]
    names = dict(zip("mhn", (each.tolist() for each in open_gates), strict=True))
    network = chain(lambda sim: sim.HH_cond_exp(**CHANNELS, i_offset=CURRENTS.tolist()), **names)
    expected, errors = integrated(channels, np.concatenate([START, *open_gates]), 30), []
    for step_ms in (0.04, 0.02):
        with opened(network, step_ms) as brain:
            recorded = brain.add_sink(SpikeRecorder(), [0, 1, 2], name="spikes")
            errors.append(abs(voltages(brain, 30) - expected).max())
            assert recorded.spikes().neurons.tolist() == [0, 2, 0]  # type: ignore[attr-defined]
    assert errors[1] < 0.1
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.6)


def test_a_reset_and_a_refractory_period_act_through_a_junction() -> None:
    strong = LEAKY | {"v_thresh": -50.0, "v_reset": -75.0}
    network = chain(lambda sim: sim.IF_curr_exp(**strong, i_offset=[1.2, 0.0, 0.0]))
    with opened(network, 0.01) as brain:
        recorded = brain.add_sink(SpikeRecorder(), [0, 1, 2], name="spikes")
        found = voltages(brain, 60)
    expected, times = _reset_at(-50.0, -75.0, 3.0, np.array([1.2, 0.0, 0.0]), 60)
    spikes = recorded.spikes()  # type: ignore[attr-defined]
    assert spikes.neurons.tolist() == [0] * len(times)
    assert spikes.times_ms == pytest.approx(times, abs=0.01 * len(times))
    assert abs(found - expected)[:, 1:].max() < 0.01


def _reset_at(
    threshold: float, reset: float, refractory_ms: float, currents: FloatArray, until_ms: int
) -> tuple[FloatArray, list[float]]:
    """Return the voltages in each ms, and the spikes of the first cell, the only one that fires."""
    grid, found, times = np.arange(1.0, until_ms + 1), [], []
    t, v, held_until = 0.0, START.copy(), -1.0

    def slopes(now: float, v: FloatArray) -> FloatArray:
        slope = (-65.0 - v) / 20.0 + currents + through_junctions(v)
        slope[0] *= now >= held_until
        return slope

    def crossing(_: float, v: FloatArray) -> float:
        return float(v[0] - threshold)

    crossing.terminal = True  # type: ignore[attr-defined]
    while t < until_ms:
        end = held_until if t < held_until else until_ms
        end = min(end, until_ms)
        points = np.append(grid[(grid > t) & (grid < end)], end)
        now = solve_ivp(slopes, (t, end), v, t_eval=points, events=crossing, rtol=1e-10, atol=1e-10)
        found += [column for time, column in zip(now.t, now.y.T, strict=True) if time in grid]
        t, v = float(now.t[-1]), now.y[:, -1].copy()
        if now.status == 1:
            t, v = float(now.t_events[0][0]), now.y_events[0][0].copy()
            v[0], held_until = reset, t + refractory_ms
            times.append(t)
        elif t == held_until:
            held_until = -1.0
    return np.array(found), times


def test_a_very_strong_junction_makes_two_voltages_one() -> None:
    network = chain(lambda sim: sim.IF_curr_exp(**LEAKY), [(0, 1, 500.0), (1, 2, 500.0)])
    with opened(network, 0.1) as brain:
        found = voltages(brain, 20)
    assert found.mean(axis=1) == pytest.approx(-65.0 + 0.0 * found[:, 0], abs=1e-6)
    assert np.ptp(found[-1]) < np.ptp(START) * 1e-2


def test_changes_a_reset_and_a_snapshot_reach_the_junctions() -> None:
    network = chain(lambda sim: sim.IF_curr_exp(**LEAKY, i_offset=CURRENTS.tolist()))
    with opened(network, 0.1) as brain:
        usual = voltages(brain, 10)
        saved = brain.snapshot()
        brain.set_weights("gap", [0.0, 0.0])
        brain.set_parameters([1], {"cm": 2.0})
        assert brain.read_weights("gap").tolist() == [0.0, 0.0]
        brain.run_until(40_000_000)
        alone = -65.0 + (usual[-1, 2] + 65.0 - 2.0) * np.exp(-1.5) + 2.0
        assert brain.read_state("v", [2])[0] == pytest.approx(alone, abs=1e-9)
        brain.restore(saved)
        brain.run_until(20_000_000)
        restored = brain.read_state("v", [0, 1, 2])
        brain.reset()
        again = voltages(brain, 20)
    assert (again[:10] == usual).all()
    assert (again[-1] == restored).all()


def test_the_exact_mode_refuses_junctions_and_one_thread_runs_them(golden: Golden) -> None:
    network = chain(lambda sim: sim.IF_curr_exp(**LEAKY))
    backend = EventBackend()
    with golden.raises(CapabilityError, match="'gap'"):
        backend.open(network, seed=0, options=backend.options())
    with opened(network, 0.1, threads=2) as brain:
        assert [warning.code.name for warning in brain.warnings] == ["NRP279"]
    chosen = backend.options.model_validate({"resolution": "0.1 ms", "lazy": "always"})
    assert "'gap' act in each step" in backend.warnings(network, chosen)[0]


@pytest.mark.parametrize(
    ("variable", "message"),
    [
        ("w", "'v'"),
        ("v", "'i_offset'"),
    ],
)
def test_junctions_need_a_voltage_and_a_current(variable: str, message: str, golden: Golden) -> None:
    def make(sim: Any) -> Any:
        return sim.EquationCell(
            f"dv/dt = -{variable}/(10*ms) : mV".replace("dv", f"d{variable}"),
            threshold="t > 1*second",
            receptors={"excitatory": f"{variable} += weight"},
        )()

    with golden.raises(NetworkError, match=message):
        junction_of(make)


def test_the_voltage_of_a_spike_source_does_not_exist(golden: Golden) -> None:
    with golden.raises(NetworkError):
        junction_of(lambda sim: sim.SpikeSourceArray())


def junction_of(make: Callable[[Any], Any]) -> Network:
    """Return a cell with a junction to a leaky one."""
    sim = builder()
    sim.setup(timestep=0.1)
    cells = sim.Population(1, make(sim)), sim.Population(1, sim.IF_curr_exp())
    sim.Projection(*cells, sim.OneToOneConnector(), sim.ElectricalSynapse(weight=1.0))
    return sim.network()


PULSE = np.array([0.5, 0.0, -0.2])


def released(law: str, v: FloatArray) -> FloatArray:
    """Return the share that two cells release at once: that of 0 to 1, and of 1 to 2."""
    above = (v[:2] + 62.0) / 3.0
    return 1.0 / (1.0 + np.exp(-above)) if law == "GradedSynapse" else np.maximum(above, 0.0)


@pytest.mark.one_of(8)
@pytest.mark.parametrize("law", ["GradedSynapse", "RectifiedSynapse"])
@pytest.mark.parametrize("tau_s", [0.0, 7.0])
@pytest.mark.parametrize("kind", ["IF_cond_exp", "IF_curr_exp", "EquationCell"])
def test_graded_release_follows_the_voltage_to_second_order(law: str, tau_s: float, kind: str) -> None:
    """The first cell excites the second, and that inhibits the third, which has a junction to the first."""
    is_conductance = kind == "IF_cond_exp"
    weights = (0.04, 0.03) if is_conductance else (0.4, -0.3)
    sim = builder()
    sim.setup(timestep=0.1)
    if kind == "EquationCell":
        own = sim.EquationCell(
            "dv/dt = (-65*mV - v)/(20*ms) + (ge + i_offset)/nF : mV\ndge/dt = -ge/(5*ms) : nA",
            threshold="v > 0*mV",
            receptors={"excitatory": "ge += weight", "inhibitory": "ge += weight"},
            parameters={"i_offset": "0 nA"},
        )(i_offset=PULSE.tolist())
    else:
        own = getattr(sim, kind)(**LEAKY, i_offset=PULSE.tolist())
    cells = sim.Population(3, own, label="cells")
    cells.initialize(v=START.tolist())
    for (pre, post), weight, receptor in zip(
        [(0, 1), (1, 2)], weights, ["excitatory", "inhibitory"], strict=True
    ):
        synapse = getattr(sim, law)(weight=weight, v_th=-62.0, slope=3.0, tau_s=tau_s)
        listed = sim.FromListConnector([(pre, post)], column_names=[])
        sim.Projection(cells, cells, listed, synapse, receptor_type=receptor, label=receptor)
    junction = sim.FromListConnector([(0, 2)], column_names=[])
    sim.Projection(cells, cells, junction, sim.ElectricalSynapse(weight=0.01), label="gap")
    network, reversals = sim.network(), np.array([0.0, -70.0])
    conductances = np.zeros((3, 3))
    conductances[0, 2] = conductances[2, 0] = 0.01

    def slopes(_: float, state: FloatArray) -> FloatArray:
        v, s = state[:3], state[3:] if tau_s else released(law, state[:3])
        current = PULSE + through_junctions(v, conductances)
        current[1:] += np.array(weights) * s * (reversals - v[1:] if is_conductance else 1.0)
        change = (-65.0 - v) / 20.0 + current
        return np.append(change, (released(law, v) - s) / tau_s) if tau_s else change

    start = np.append(START, released(law, START)) if tau_s else START
    expected, errors = integrated(slopes, start, 40), []
    for step_ms in (0.2, 0.1):
        with opened(network, step_ms) as brain:
            errors.append(abs(voltages(brain, 40) - expected).max())
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=1.0)


def test_weights_and_reversal_potentials_of_graded_release_change() -> None:
    sim = builder()
    sim.setup(timestep=0.1)
    one, other = (sim.Population(1, sim.IF_cond_exp(**LEAKY), label=name) for name in ("one", "other"))
    synapse = sim.GradedSynapse(weight=0.0, v_th=-65.0, slope=1.0)
    sim.Projection(one, other, sim.OneToOneConnector(), synapse, receptor_type="inhibitory", label="s")
    with opened(sim.network(), 0.1) as brain:
        brain.set_weights("s", 0.1)
        brain.set_parameters([1], {"e_rev_I": -90.0})
        brain.run_until(400_000_000)
        assert brain.read_state("v", [1])[0] == pytest.approx((0.05 * -65.0 + 0.05 * -90.0) / 0.1, abs=1e-6)


@pytest.mark.parametrize("kind", ["IF_curr_delta", "Izhikevich"])
def test_graded_release_onto_weights_in_mv_is_refused(kind: str, golden: Golden) -> None:
    sim = builder()
    sim.setup(timestep=0.1)
    cells = sim.Population(2, getattr(sim, kind)())
    sim.Projection(cells, cells, sim.AllToAllConnector(), sim.GradedSynapse(weight=1.0))
    with golden.raises(NetworkError, match="mV"):
        sim.network()
