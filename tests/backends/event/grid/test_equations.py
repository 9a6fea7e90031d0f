"""Cells given as equations, on the grid: closed formulas, our own cells, Brian2, changes, snapshots."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import exp, log
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend, EventOptions, equation_functions
from nrp_brain_event.grid.equations import blocks, runge_kutta_source

from nrp_core.brain import builder
from nrp_core.brain.devices.sinks import SpikeRecorder, StateRecorder
from nrp_core.brain.devices.sources import DCSource
from nrp_core.brain.interface import Brain
from nrp_core.errors import CapabilityError, DivergedError
from nrp_core.network.data import Network
from nrp_core.pynn import new_simulator

REFERENCES = json.loads((Path(__file__).parent / "equations_brian2.json").read_text())
CURRENT = """
dv/dt = (v_rest - v)/tau_m + (isyn_exc + isyn_inh + i_offset)/cm : mV (unless refractory)
disyn_exc/dt = -isyn_exc/tau_syn_E : nA
disyn_inh/dt = -isyn_inh/tau_syn_I : nA
"""
IZHIKEVICH = """
dv/dt = 0.04*v**2/(mV*ms) + 5*v/ms + 140*mV/ms - u + i_offset*(1000*mV/ms/nA) : mV (unless refractory)
du/dt = a*(b*v - u) : mV/ms
"""
ADAPTIVE = """
upstroke = delta_T*exp(min((v - v_thresh)/delta_T, 200)) : mV
isyn = gsyn_exc*(e_rev_E - v) + gsyn_inh*(e_rev_I - v) : nA
dv/dt = (v_rest - v + upstroke)/tau_m + (isyn + i_offset - w)/cm : mV (unless refractory)
dw/dt = (a*(v - v_rest) - w)/tau_w : nA
dgsyn_exc/dt = -gsyn_exc/tau_syn_E : uS
dgsyn_inh/dt = -gsyn_inh/tau_syn_I : uS
"""
SPIKE = {"threshold": "v >= v_thresh", "reset": "v = v_reset", "refractory": "tau_refrac"}
TWINS: dict[str, dict[str, Any]] = {
    "IF_curr_exp": {
        "equations": CURRENT, **SPIKE, "receptors": {"excitatory": "isyn_exc", "inhibitory": "isyn_inh"},
    },
    "Izhikevich": {
        "equations": IZHIKEVICH, "threshold": "v >= 30*mV", "reset": "v = c; u += d",
        "receptors": {"excitatory": "v += weight", "inhibitory": "v"},
    },
    "EIF_cond_exp_isfa_ista": {
        "equations": ADAPTIVE, "threshold": "v > v_spike", "reset": "v = v_reset; w += b",
        "refractory": "tau_refrac", "receptors": {"excitatory": "gsyn_exc", "inhibitory": "gsyn_inh"},
    },
}  # fmt: skip
"""Our own cells as equations."""
DRIVES = {
    "IF_curr_exp": (1.2, 0.4, -0.8),
    "Izhikevich": (0.012, 1.0, -2.0),
    "EIF_cond_exp_isfa_ista": (0.8, 0.004, 0.01),
}
"""Constant current (nA), and excitatory and inhibitory weight."""


def twin(sim: Any, name: str) -> Any:
    kind = getattr(sim, name)
    parameters = {key: f"{value!r} {kind.units[key]}" for key, value in kind.default_parameters.items()}
    initial = {
        key: f"{kind.default_initial_values[key]!r} {kind.units[key]}"
        for key in ("v", "u", "w")
        if key in kind.units
    }
    known = {key: value for key, value in initial.items() if f"d{key}/dt" in TWINS[name]["equations"]}
    return sim.EquationCell(**TWINS[name], parameters=parameters, initial=known)


def random_network(name: str, *, own: bool, timestep: float = 0.1) -> Network:
    """Return 30 different cells that excite and inhibit each other."""
    sim = builder(seed=5)
    sim.setup(timestep=timestep)
    kind = twin(sim, name) if own else getattr(sim, name)
    drive, excitation, inhibition = DRIVES[name]
    currents = np.linspace(0.8, 1.2, 30) * drive
    cells = sim.Population(30, kind(i_offset=currents), label="cells")
    for receptor, weight in (("excitatory", excitation), ("inhibitory", inhibition)):
        synapse = sim.StaticSynapse(weight=weight, delay=sim.RandomDistribution("uniform", (1.0, 3.0)))
        sim.Projection(cells, cells, sim.FixedNumberPostConnector(4), synapse, receptor_type=receptor)
    return sim.network()


@contextmanager
def opened(network: Network, **options: Any) -> Iterator[Brain]:
    chosen = EventOptions.model_validate({"resolution": "0.1 ms", "lazy": "never", **options})
    with EventBackend().open(network, seed=1, options=chosen) as brain:
        yield brain


def activity(network: Network, until_ms: float, **options: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return spikes (time, neuron), and the voltages in each ms."""
    with opened(network, **options) as brain:
        spikes = brain.add_sink(SpikeRecorder(), np.arange(network.size), name="spikes")
        voltages = brain.add_sink(StateRecorder("v", 1.0), np.arange(network.size), name="v")
        brain.run_until(round(until_ms * 1e6))
        heard = spikes.spikes()
        order = np.lexsort((heard.neurons, heard.times_ms))
        return np.stack([heard.times_ms, heard.neurons])[:, order], voltages.samples()[1]


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "until_ms", "tolerance_mv"), [
    ("IF_curr_exp", 300.0, 1e-9),
    pytest.param("Izhikevich", 150.0, 0.02, marks=pytest.mark.heavy),  # compiles for 9 s
    pytest.param("EIF_cond_exp_isfa_ista", 150.0, 0.02, marks=pytest.mark.heavy),  # Brian2 has its like
])  # fmt: skip
def test_our_own_cells_as_equations_spike_alike(name: str, until_ms: float, tolerance_mv: float) -> None:
    ours, theirs = (activity(random_network(name, own=own), until_ms) for own in (True, False))
    assert theirs[0].shape[1] > 60
    np.testing.assert_allclose(ours[0], theirs[0], atol=1e-9)
    assert np.median(np.abs(ours[1] - theirs[1])) < 1e-6
    np.testing.assert_allclose(ours[1], theirs[1], atol=tolerance_mv)


def leaky(sim: Any, **changed: str) -> Any:
    parameters = {"v_rest": "-65 mV", "tau": "20 ms", "R": "20 Mohm", "i_offset": "1 nA", "hold": "2 ms"}
    return sim.EquationCell(
        "dv/dt = (v_rest - v + R*i_offset)/tau : mV (unless refractory)",
        "v > -50*mV", "v = v_rest", "hold",
        parameters={**parameters, **changed}, initial={"v": "-65 mV"}, receptors={"excitatory": "v"},
    )  # fmt: skip


def test_constant_current_gives_the_closed_formula_for_each_cell() -> None:
    sim = builder()
    taus = np.array([10.0, 20.0, 35.0])
    cells = sim.Population(3, leaky(sim)(tau=taus, hold=[0.0, 2.0, 2.05]), label="cells")
    assert cells.celltype.equations.model.method == "exact"
    spikes, voltages = activity(sim.network(), 100.0)
    for k, (tau, hold_steps) in enumerate(zip(taus, (0, 20, 21), strict=True)):
        steps = int(-tau * log(1.0 - 15.0 / 20.0) / 0.1) + 1  # until 20 mV * (1 - exp(-t / tau)) > 15 mV
        expected = 0.1 * (steps + (steps + hold_steps) * np.arange(20))
        found = spikes[0, spikes[1] == k]
        np.testing.assert_allclose(found, expected[: len(found)])
        assert len(found) == (expected < 100.05).sum()
        times = np.arange(1.0, 0.1 * steps - 0.05)
        np.testing.assert_allclose(
            voltages[1 : 1 + len(times), k], [-65.0 + 20.0 * (1.0 - exp(-t / tau)) for t in times], rtol=1e-13
        )


def test_a_spike_in_the_refractory_period_is_lost_or_kept() -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    kind = sim.EquationCell(
        "dv/dt = -v/tau : mV (unless refractory)", "v > 10*mV", "v = 0*mV", "5 ms",
        parameters={"tau": "20 ms"}, receptors={"excitatory": "v", "inhibitory": "v (also refractory)"},
    )  # fmt: skip
    cells = sim.Population(2, kind())
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=[1.0, 3.0]))
    for k, receptor in enumerate(("excitatory", "inhibitory")):
        synapse = sim.StaticSynapse(weight=12.0, delay=1.0)
        sim.Projection(source, cells[k : k + 1], sim.AllToAllConnector(), synapse, receptor_type=receptor)
    cells.record(["spikes", "v"])
    sim.run(7.0)
    data = cells.get_data().segments[0]
    assert [np.asarray(train).tolist() for train in data.spiketrains] == [[2.0], [2.0, 7.0]]
    assert np.asarray(data.filter(name="v")[0])[50].tolist() == [0.0, 12.0]


@pytest.mark.one_of(3)
@pytest.mark.parametrize("method", ["exact", "runge_kutta"])
def test_a_refractory_period_is_over_at_the_grid_point_at_which_it_ends(method: str) -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    kind = sim.EquationCell(
        "dv/dt = -v/tau : mV (unless refractory)", "v > 10*mV", "v = 0*mV", "5 ms", method=method,
        parameters={"tau": "20 ms"}, receptors={"excitatory": "v", "inhibitory": "v (also refractory)"},
    )  # fmt: skip
    cells = sim.Population(4, kind())
    for k, (time, receptor) in enumerate(
        [(5.9, "excitatory"), (6.0, "excitatory"), (5.9, "inhibitory"), (6.1, "excitatory")]
    ):
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[1.0, time]))
        synapse = sim.StaticSynapse(weight=12.0, delay=1.0)
        sim.Projection(source, cells[k : k + 1], sim.AllToAllConnector(), synapse, receptor_type=receptor)
    cells.record("spikes")
    sim.run(9.0)
    trains = cells.get_data().segments[0].spiketrains
    expected = [[2.0], [2.0, 7.0], [2.0, 7.0], [2.0, 7.1]]
    assert [np.asarray(train).round(9).tolist() for train in trains] == expected


@pytest.mark.parametrize("tau", [20.0, np.linspace(10.0, 35.0, 1500)], ids=["equal", "different"])
def test_all_cells_of_a_large_population_fire_when_the_closed_formula_says(tau: Any) -> None:
    sim = builder()
    current = np.linspace(0.8, 1.2, 1500)
    sim.Population(1500, leaky(sim)(tau=tau, i_offset=current, hold=0.0), label="cells")
    spikes, _ = activity(sim.network(), 60.0)
    steps = (-tau * np.log(1.0 - 15.0 / (20.0 * current)) / 0.1).astype(int) + 1
    assert np.bincount(spikes[1].astype(int), minlength=1500).tolist() == (600 // steps).tolist()
    cells, first = np.unique(spikes[1].astype(int), return_index=True)
    np.testing.assert_allclose(spikes[0, first], 0.1 * steps[cells])


def test_cells_that_become_different_and_equal_again_go_on_as_they_are() -> None:
    sim = builder()
    sim.Population(2, leaky(sim)(hold=0.0), label="cells")
    with opened(sim.network()) as brain:
        equal = brain.snapshot()
        brain.set_parameters([1], {"tau": 10.0})
        brain.run_until(4_000_000)
        ends = brain.read_state("v", [0, 1])
        brain.restore(equal)
        brain.run_until(4_000_000)
        again = brain.read_state("v", [0, 1])
    np.testing.assert_allclose(ends, -65.0 + 20.0 * (1.0 - np.exp(-4.0 / np.array([20.0, 10.0]))))
    np.testing.assert_allclose(again, -65.0 + 20.0 * (1.0 - np.exp(-4.0 / np.array([20.0, 20.0]))))


def test_the_exponential_function_is_that_of_the_c_library() -> None:
    for x in [*np.linspace(-707.0, 709.7, 5001).tolist(), 0.0, -0.0, 1e-20, -1e-9]:
        assert equation_functions.exp(x) == pytest.approx(exp(x), rel=1e-15, abs=0.0)
    assert equation_functions.exp(-709.0) == equation_functions.exp(-np.inf) == 0.0
    assert equation_functions.exp(710.0) == equation_functions.exp(np.inf) == np.inf
    assert np.isnan(equation_functions.exp(np.nan))


def test_a_wrong_propagator_does_not_give_the_closed_formula(monkeypatch: pytest.MonkeyPatch) -> None:
    def euler(model: Any, known: Mapping[str, Any], n: int, step_s: float, *, held: bool) -> np.ndarray:
        exact = right(model, known, n, step_s * 1e-6, held=held)
        unit = np.eye(*exact.shape[1:])
        return np.asarray(unit + 1e6 * (exact - unit))

    right = blocks.propagators
    monkeypatch.setattr(blocks, "propagators", euler)
    with pytest.raises(AssertionError):
        test_constant_current_gives_the_closed_formula_for_each_cell()


@pytest.mark.heavy
@pytest.mark.parametrize("name", REFERENCES)
def test_cells_follow_brian2(name: str) -> None:
    reference = REFERENCES[name]
    sim = builder()
    kind = sim.EquationCell(**reference["cell"])
    sim.Population(1, kind(), label="cell")
    with opened(sim.network()) as brain:
        recorder = brain.add_sink(SpikeRecorder(), [0], name="spikes")
        traces = {v: brain.add_sink(StateRecorder(v, 0.5), [0], name=v) for v in reference["states"]}
        brain.run_until(round(reference["until_ms"] * 1e6))
        found = recorder.spikes().times_ms
    expected = np.array(reference["spikes_ms"])
    assert len(found) == len(expected) > 2
    late = found - expected
    assert late.min() > -0.01, "a spike comes before that of the reference"
    assert late.max() < 0.1 + 0.01
    times = 0.5 * np.arange(len(reference["states"]["v"]))
    calm = np.abs(times[:, None] - expected).min(axis=1) > 2.0
    for variable, values in reference["states"].items():
        scale = np.ptp(values)
        samples = traces[variable].samples()[1][:, 0][: len(values)]
        np.testing.assert_allclose(samples[calm] / scale, np.array(values)[calm] / scale, atol=2e-3)


@pytest.mark.heavy
def test_a_loose_tolerance_does_not_follow_our_own_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runge_kutta_source, "TOLERANCE", 1e5)
    monkeypatch.setattr(
        runge_kutta_source, "WEIGHTS", np.tril(np.ones((7, 6)), -1) / np.arange(1, 8)[:, None]
    )
    with pytest.raises((AssertionError, DivergedError)):
        test_our_own_cells_as_equations_spike_alike("Izhikevich", 150.0, 0.02)


@pytest.mark.heavy
def test_parts_of_the_rows_give_the_same_bits() -> None:
    network = random_network("Izhikevich", own=True)
    one, two = activity(network, 60.0), activity(network, 60.0, threads=2)
    assert one[0].tobytes() == two[0].tobytes()
    assert one[1].tobytes() == two[1].tobytes()


def test_a_snapshot_continues_alike_after_parameters_changed() -> None:
    network = random_network("IF_curr_exp", own=True)
    with opened(network) as brain:
        brain.run_until(20_000_000)
        brain.set_parameters([0, 1], {"tau_m": [5.0, 50.0], "i_offset": 2.0})
        saved = brain.snapshot()
        recorder = brain.add_sink(SpikeRecorder(), np.arange(30), name="spikes")
        brain.run_until(80_000_000)
        first, end = recorder.spikes(), brain.read_state("v", np.arange(30))
        brain.remove(recorder)
        brain.restore(saved)
        again = brain.add_sink(SpikeRecorder(), np.arange(30), name="spikes")
        brain.run_until(80_000_000)
        assert again.spikes().times_ms.tobytes() == first.times_ms.tobytes()
        assert brain.read_state("v", np.arange(30)).tobytes() == end.tobytes()
        brain.reset()
        brain.run_until(80_000_000)
        assert (brain.read_state("v", [0, 1]) != end[:2]).any()


def test_changed_parameters_act_as_in_our_own_cells() -> None:
    ends = []
    for own in (True, False):
        with opened(random_network("IF_curr_exp", own=own)) as brain:
            brain.run_until(10_000_000)
            brain.set_parameters([3], {"tau_m": 7.0, "i_offset": 0.7})
            device = brain.add_source(DCSource(amplitude=0.3), [3], name="current")
            brain.run_until(30_000_000)
            device.amplitude = 0.0
            brain.run_until(40_000_000)
            ends.append(brain.read_state("v", np.arange(30)))
    np.testing.assert_allclose(*ends, rtol=1e-12)


def test_features_that_equation_cells_lack_are_refused(golden: Golden) -> None:
    sim = builder()
    silent = sim.EquationCell(
        "dv/dt = -v/(10*ms) : mV", "v > 10*mV", "v = 0*mV", receptors={"excitatory": "v"}
    )
    sim.Population(2, silent, label="cells")
    network = sim.network()
    exact = EventOptions.model_validate({})
    with golden.raises(CapabilityError, match="'cells'.*0.1"):
        EventBackend().open(network, seed=0, options=exact)
    with opened(network) as brain:
        with pytest.raises(CapabilityError, match="'u'"):
            brain.read_state("u", [0])
        brain.add_source(DCSource(amplitude=0.3), [0], name="current")
        with golden.raises(CapabilityError, match="'cells'.*'i_offset'"):
            brain.run_until(1_000_000)


def test_cells_that_cannot_be_integrated_are_named(golden: Golden) -> None:
    sim = builder()
    kind = sim.EquationCell("dv/dt = v**2/(mV*ms) : mV", "v > inf*mV", "v = 0*mV")
    sim.Population(1500, kind, initial_values={"v": np.arange(1500) == 1301}, label="cells")
    with (
        opened(sim.network()) as brain,
        golden.raises(DivergedError, match="1301.*'cells'"),
    ):
        brain.run_until(3_000_000)


def test_a_condition_keeps_a_cell_from_firing_until_it_ends() -> None:
    sim = builder()
    wave = sim.EquationCell(
        "dx/dt = -w*y : 1\ndy/dt = w*x : 1", "y > 0.5", refractory="y > 0.5",
        parameters={"w": "0.1/ms"}, initial={"x": "1"},
    )  # fmt: skip
    sim.Population(1, wave, label="cells")
    with opened(sim.network()) as brain:
        recorder = brain.add_sink(SpikeRecorder(), [0], name="spikes")
        brain.run_until(150_000_000)
    once_a_cycle = (np.arcsin(0.5) + 2 * np.pi * np.arange(3)) / 0.1
    np.testing.assert_allclose(recorder.spikes().times_ms, np.ceil(once_a_cycle / 0.1) * 0.1)
