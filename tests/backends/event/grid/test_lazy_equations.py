"""Linear equations on the lazy grid: against the matrix exponential, and the bound of their course."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from nrp_brain_event import EventBackend, EventOptions
from nrp_brain_event.grid.equations.lazy_source import factors_of_kind
from nrp_brain_event.grid.equations.settling import bound, obstacle, powers
from nrp_brain_event.grid.lazy_brain import LazyBrain
from nrp_brain_event.options import lazy_grid_obstacle
from scipy.linalg import expm

from nrp_core.brain import builder
from nrp_core.brain.devices.sinks import SpikeRecorder, StateRecorder

STEP_MS, END_MS, HOLD_STEPS = 0.1, 400.0, 22
TAU_M, TAU_SYN, TAU_W, CM, A, B, CURRENT, THRESHOLD = 20.0, 5.0, 80.0, 0.25, 0.008, 0.06, 0.15, 14.0
EQUATIONS = """
dv/dt = -v/tau_m + (g - w + i_offset)/cm : mV (unless refractory)
dg/dt = -g/tau_syn : nA (unless refractory)
dw/dt = (a*v - w)/tau_w : nA
"""
PARAMETERS = {
    "tau_m": f"{TAU_M} ms", "tau_syn": f"{TAU_SYN} ms", "tau_w": f"{TAU_W} ms",
    "cm": f"{CM} nF", "a": f"{A} uS",
    "b": f"{B} nA", "i_offset": f"{CURRENT} nA",
}  # fmt: skip
WEIGHT = 0.5


def adapting(sim: Any, **changed: Any) -> Any:
    texts = {
        "equations": EQUATIONS, "threshold": "v > 14*mV", "reset": "v = 0*mV; g = 0*nA; w += b",
        "refractory": "2.2 ms", "receptors": {"excitatory": "g"}, "parameters": PARAMETERS,
    }  # fmt: skip
    return sim.EquationCell(**{**texts, **changed})


def numbers(parameters: dict[str, str]) -> dict[str, np.ndarray]:
    return {name: np.array([float(text.split()[0])]) for name, text in parameters.items()}


def opened(network: Any, lazy: str) -> Any:
    options = EventOptions.model_validate({"resolution": f"{STEP_MS} ms", "lazy": lazy})
    return EventBackend().open(network, seed=1, options=options)


def by_matrix_exponential(arrivals: set[int]) -> tuple[list[int], np.ndarray]:
    """Return the steps of spikes, and v, g and w at all steps, by one exponential from each event."""
    free = np.array(
        [
            [-1 / TAU_M, 1 / CM, -1 / CM, CURRENT / CM],
            [0, -1 / TAU_SYN, 0, 0],
            [A / TAU_W, 0, -1 / TAU_W, 0],
            [0] * 4,
        ]
    )
    held = np.where(np.arange(4)[:, None] == 2, free, 0.0)
    since, start, until, matrix = 0, np.array([0.0, 0.0, 0.0, 1.0]), 0, free
    spikes, rows = [], [start[:3]]
    for step in range(1, round(END_MS / STEP_MS) + 1):
        now = expm(matrix * (step - since) * STEP_MS) @ start
        free_again = step >= until
        if step in arrivals and free_again:
            now[1] += WEIGHT
        if free_again and now[0] > THRESHOLD:
            spikes.append(step)
            now[:3] = 0.0, 0.0, now[2] + B
            until = step + HOLD_STEPS
        if step in (until, *spikes[-1:]) or (step in arrivals and free_again):
            since, start, matrix = step, now, held if step < until else free
        rows.append(now[:3])
    return spikes, np.array(rows)


@pytest.mark.heavy
def test_spikes_and_states_are_those_of_the_matrix_exponential() -> None:
    times = np.sort(np.random.default_rng(4).choice(np.arange(20, 3900), 150, replace=False))
    sim = builder()
    sim.setup(timestep=STEP_MS)
    cells = sim.Population(1, adapting(sim), label="cells")
    source = sim.Population(1, sim.SpikeSourceArray(spike_times=(times - 10) * STEP_MS))
    sim.Projection(source, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=WEIGHT, delay=1.0))
    network = sim.network()
    spikes, rows = by_matrix_exponential(set(times.tolist()))
    assert len(spikes) > 10
    with opened(network, "always") as brain:
        assert isinstance(brain, LazyBrain)
        recorder = brain.add_sink(SpikeRecorder(), network.ids_of("cells"), name="spikes")
        traces = [
            brain.add_sink(StateRecorder(name, 7.0), network.ids_of("cells"), name=name) for name in "vgw"
        ]
        brain.run_until(round(END_MS * 1e6))
        assert np.rint(recorder.spikes().times_ms / STEP_MS).astype(int).tolist() == spikes
        for trace, expected in zip(traces, rows.T, strict=True):
            found = trace.samples()[1][:, 0]
            np.testing.assert_allclose(found, expected[::70][: len(found)], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("a", ["0.008 uS", "0.9 uS", "-0.005 uS"])
def test_no_later_excess_is_above_the_bound(a: str) -> None:
    """With real and complex eigenvalues; the bound is of use too: states exist that come near it."""
    sim = builder()
    cell = adapting(sim, parameters={**PARAMETERS, "a": a})().equations
    model, step_s = cell.model, STEP_MS * 1e-3
    known = cell.in_si(numbers({**PARAMETERS, "a": a}))
    free = powers(model, known, step_s, held=False)
    limits, nearest = bound(model, known, free), np.inf
    current = known["i_offset"][0]
    for state in np.random.default_rng(1).normal(size=(20, 3)) * [10e-3, 0.5e-9, 0.3e-9]:
        away = state - limits.rest[0] - limits.rest[1] * current
        highest = (
            limits.excess @ [1.0, current] + np.maximum(limits.highest * away, limits.lowest * away).sum()
        )
        now, found = np.array([*state, current, 1.0]), -np.inf
        for _ in range(6000):
            now = free[1] @ now
            found = max(found, now[0] - THRESHOLD * 1e-3)
        assert found <= highest + 1e-12
        nearest = min(nearest, highest - found)
    assert nearest < 1e-3


def test_a_cell_of_which_nothing_moves_while_it_is_refractory_stands_still() -> None:
    without_adaptation = EQUATIONS.replace(" - w", "").partition("dw/dt")[0]
    sim = builder()
    cell = adapting(sim, equations=without_adaptation, reset="v = 0*mV; g = 0*nA")().equations
    known = cell.in_si(numbers(PARAMETERS))
    held = powers(cell.model, known, STEP_MS * 1e-3, held=True)
    assert (held == np.eye(4)).all()
    assert len(held) == len(powers(cell.model, known, STEP_MS * 1e-3, held=False))
    assert np.isfinite(factors_of_kind(cell.model, known, STEP_MS * 1e-3)).all()


@pytest.mark.parametrize(("changed", "reason"), [
    ({"equations": EQUATIONS.replace("-v/tau_m", "-v*v/tau_m/mV")}, "not linear"),
    ({"threshold": "v > 14*mV and rand() < 0.5"}, "random threshold"),
    ({"refractory": "v > 10*mV"}, "condition"),
    ({"threshold": "v*v > 196*mV**2"}, "threshold that is not linear"),
    ({"threshold": "v > 14*mV*cos(t/ms)"}, "threshold that is not linear"),
])  # fmt: skip
def test_cells_whose_course_is_not_known_in_advance_are_named(changed: dict[str, Any], reason: str) -> None:
    sim = builder()
    assert reason in obstacle(adapting(sim, **changed)().equations.model)
    assert obstacle(adapting(sim)().equations.model) == ""


def test_cells_that_fire_by_themselves_or_never_rest_count_as_busy() -> None:
    options = EventOptions.model_validate({"resolution": f"{STEP_MS} ms"})
    without_leak = {
        "equations": EQUATIONS.replace("-v/tau_m + ", ""),
        "parameters": {**PARAMETERS, "a": "0 uS"},
    }
    for current, changed, is_lazy in ((CURRENT, {}, True), (0.9, {}, False), (0.0, without_leak, False)):
        sim = builder()
        sim.Population(3000, adapting(sim, **changed)(i_offset=current))
        assert (lazy_grid_obstacle(sim.network(), options) == "") == is_lazy
    cell = adapting(sim, **without_leak)().equations
    known = cell.in_si(numbers(without_leak["parameters"]))
    assert bound(cell.model, known, powers(cell.model, known, STEP_MS * 1e-3, held=False)).excess[0] == np.inf
