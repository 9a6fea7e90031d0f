"""PyNN's ``GIF_cond_exp``, and random thresholds of cells in equations: against NEST and closed formulas."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend, EventOptions
from scipy.stats import kstest

from nrp_core.errors import NetworkError
from nrp_core.pynn import new_simulator

NEST_SPIKES_MS = [[55.9, 116.7, 195.0, 279.5], [55.9, 153.5, 278.7]]
NEST_AT_100_MS = {"v": [-56.0589, -54.6159], "i_eta": [0.06563, 0.0], "v_t": [-55.0, -51.7184]}
"""Of the two cells of `sharp`; NEST holds the current of past spikes for a step."""
NEST_COUNT, NEST_COUNT_ERROR = 6.756, 0.025
NEST_FIRST_MS, NEST_FIRST_ERROR_MS = 48.57, 0.49
"""Means and standard errors over 1000 cells like those of `noisy`. All are of PyNN 0.13 with NEST 3.10."""


def simulator(seed: int = 3) -> Any:
    sim = new_simulator()
    sim.setup(timestep=0.1, seed=seed)
    return sim


def trains(cells: Any) -> list[np.ndarray]:
    return [train.magnitude for train in cells.get_data("spikes").segments[-1].spiketrains]


def noisy(sim: Any, n: int = 1000) -> Any:
    kind = sim.GIF_cond_exp(
        i_offset=0.9, v_t_star=-52.0, delta_v=2.0, lambda0=10.0, a_eta=(0.2, 0.1, 0.05),
        a_gamma=(3.0, 2.0, 1.0), tau_refrac=4.0,
    )  # fmt: skip
    cells = sim.Population(n, kind, label="noisy")
    cells.record("spikes")
    return cells


@pytest.mark.heavy
def test_currents_and_thresholds_after_spikes_are_those_of_nest() -> None:
    sim = simulator()
    jumps = {"a_eta": [(0.1, 0.1, 0.1), (0.0, 0.0, 0.0)], "a_gamma": [(0.0, 0.0, 0.0), (5.0, 5.0, 5.0)]}
    kind = sim.GIF_cond_exp(v_t_star=-55.0, delta_v=1e-6, **jumps)  # so sharp that nothing is random
    cells = sim.Population(2, kind, initial_values={"v": -65.0, "v_t": -55.0})
    sim.DCSource(start=20.0, stop=280.0, amplitude=0.6).inject_into(cells)
    cells.record(["spikes", "v", "i_eta", "v_t"])
    sim.run(300.0)
    spikes, data = trains(cells), cells.get_data().segments[0]
    found = {name: np.asarray(data.filter(name=name)[0]) for name in NEST_AT_100_MS}
    for own, theirs in zip(spikes, NEST_SPIKES_MS, strict=True):
        np.testing.assert_allclose(own, theirs, atol=0.25)
    for name, values in NEST_AT_100_MS.items():
        np.testing.assert_allclose(found[name][1000], values, atol=5e-3)
    ages = 250.0 - np.array([time for time in spikes[0] if time < 250.0])
    traces = [0.1 * np.exp(-ages / tau).sum() for tau in (1.0, 10.0, 100.0)]
    assert found["i_eta"][2500, 0] == pytest.approx(sum(traces), rel=1e-5)
    assert found["v_t"][0].tolist() == [-55.0, -55.0]


def test_a_threshold_that_follows_from_the_equations_cannot_begin_elsewhere(golden: Golden) -> None:
    sim = simulator()
    sim.Population(2, sim.GIF_cond_exp(v_t_star=-55.0), initial_values={"v_t": -40.0}, label="own")
    with golden.raises(ValueError, match="'own': v_t.*-55.*-40"):
        sim.run(1.0)


@pytest.mark.heavy
def test_adapting_cells_fire_at_random_as_in_nest() -> None:
    sim = simulator()
    cells = noisy(sim)
    sim.run(500.0)
    counts = np.array([len(train) for train in trains(cells)])
    firsts = np.array([train[0] for train in trains(cells)])
    assert abs(counts.mean() - NEST_COUNT) < 4.0 * np.hypot(counts.std() / 1000**0.5, NEST_COUNT_ERROR)
    assert abs(firsts.mean() - NEST_FIRST_MS) < 4.0 * np.hypot(firsts.std() / 1000**0.5, NEST_FIRST_ERROR_MS)


@pytest.mark.heavy
def test_a_cell_at_rest_fires_with_the_intensity_of_the_formula() -> None:
    sim = simulator()
    kind = sim.GIF_cond_exp(v_t_star=-64.0, delta_v=0.5, lambda0=200.0, a_eta=[0.0] * 3, a_gamma=[0.0] * 3)
    cells = sim.Population(400, kind)
    cells.record("spikes")
    sim.run(1000.0)
    intervals = np.concatenate([np.diff(train) for train in trains(cells)]) - 4.0  # the refractory period
    mean_ms = 1000.0 / (200.0 * np.exp(-1.0 / 0.5))
    spread = np.random.default_rng(1).uniform(0.0, 0.1, len(intervals))  # a spike is at the end of its step
    shortened = intervals[intervals < 200.0] - spread[intervals < 200.0]
    below = 1.0 - np.exp(-200.0 / mean_ms)
    assert len(shortened) > 5000
    assert kstest(shortened, lambda t: (1.0 - np.exp(-t / mean_ms)) / below).pvalue > 1e-3


def test_random_spikes_depend_on_the_seed_and_not_on_how_the_run_is_divided() -> None:
    def spikes(seed: int, parts: list[float]) -> list[list[float]]:
        sim = simulator(seed)
        cells = noisy(sim, 20)
        for part in parts:
            sim.run(part)
        return [train.tolist() for train in trains(cells)]

    whole = spikes(3, [200.0])
    assert spikes(3, [33.3, 66.7, 100.0]) == whole
    assert spikes(4, [200.0]) != whole
    assert whole[0] != whole[1]


def test_a_snapshot_continues_with_the_same_random_numbers() -> None:
    sim = simulator()
    noisy(sim, 20)
    options = EventOptions.model_validate({"resolution": "0.1 ms"})
    with EventBackend().open(sim.network(), seed=1, options=options) as brain:
        brain.run_until(40_000_000)
        saved, ends = brain.snapshot(), []
        for _ in range(2):
            brain.restore(saved)
            brain.run_until(150_000_000)
            ends.append((brain.read_state("v", np.arange(20)), brain.read_state("v_t", np.arange(20))))
        np.testing.assert_array_equal(*ends)
        assert len(set(ends[0][1].tolist())) > 10  # they have fired, at different times
        brain.reset(seed=2)
        brain.run_until(150_000_000)
        assert (brain.read_state("v", np.arange(20)) != ends[0][0]).any()


def test_values_of_filters_are_read_as_they_were_given(golden: Golden) -> None:
    sim = simulator()
    cells = sim.Population(2, sim.GIF_cond_exp(a_gamma=[(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)]))
    assert [one.value.tolist() for one in cells.get("a_gamma")] == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    cells.set(tau_eta=[2.0, 20.0, 200.0])
    assert cells.get("tau_eta").value.tolist() == [2.0, 20.0, 200.0]
    with golden.raises(NetworkError, match="tau_eta"):
        sim.Population(1, sim.GIF_cond_exp(tau_eta=[1.0, 2.0]))


@pytest.mark.one_of(3)
@pytest.mark.parametrize("method", ["exact", "runge_kutta"])
def test_a_random_threshold_is_met_with_its_probability_in_each_step(method: str) -> None:
    sim = simulator()
    kind = sim.EquationCell(
        "dv/dt = -v/tau : mV\nwaiting = 2*v : mV (recorded)", threshold="rand() < rate*dt", reset="v = 0*mV",
        refractory="3 ms", parameters={"rate": "50 Hz", "tau": "10 ms"}, initial={"v": "1 mV"}, method=method,
    )  # fmt: skip
    cells = sim.Population(300, kind)
    cells.record(["spikes", "waiting"])
    sim.run(1000.0)
    expected = 300 * 1000.0 / (3.0 + 20.0)
    assert sum(map(len, trains(cells))) == pytest.approx(expected, abs=4.0 * expected**0.5)
    waiting = np.asarray(cells.get_data().segments[0].filter(name="waiting")[0])
    assert waiting[0, 0] == pytest.approx(2.0)
    unfired = next(k for k, train in enumerate(trains(cells)) if train[0] > 5.0)
    assert waiting[50, unfired] == pytest.approx(2.0 * np.exp(-0.5), rel=1e-6)


@pytest.mark.parametrize(("changed", "message"), [
    ({"threshold": "rand() < rand()"}, r"'rand\(\)'"),
    ({"threshold": "v > 1*mV and 1*ms > dt"}, "'dt'"),
    ({"equations": "dv/dt = -v/tau*rand() : mV"}, "'rand'"),
    ({"reset": "v = rand()*mV"}, "'rand' is random"),
    ({"equations": "dv/dt = -v/tau : mV (recorded)"}, "'recorded'"),
])  # fmt: skip
def test_a_random_number_elsewhere_is_refused(changed: dict[str, str], message: str, golden: Golden) -> None:
    texts = {"equations": "dv/dt = -v/tau : mV", "threshold": "rand() < 0.1", "reset": "v = 0*mV", **changed}
    with golden.raises(NetworkError, match=message):
        simulator().EquationCell(**texts, parameters={"tau": "20 ms"})
