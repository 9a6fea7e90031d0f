"""Sources whose intervals are independent: gamma processes, and Poisson trains with a dead time."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.brain.devices.source_cells import RenewalTrains
from nrp_core.dsl.testing import MockBrain
from nrp_core.errors import NetworkError
from nrp_core.network.data import Network, Population
from nrp_core.pynn import new_simulator
from nrp_core.seeds import Seeds

N, UNTIL_MS = 50, 20_000.0
WINDOW = {"start": np.zeros(N), "duration": np.full(N, np.inf)}
GAMMA = {"alpha": np.full(N, 4.0), "beta": np.full(N, 200.0), **WINDOW}  # intervals of 20 ms
REFRACTORY = {"rate": np.full(N, 50.0), "tau_refrac": np.full(N, 15.0), **WINDOW}
KINDS = [("SpikeSourceGamma", GAMMA), ("SpikeSourcePoissonRefractory", REFRACTORY)]


def opened(kind: str, parameters: Any) -> RenewalTrains:
    return RenewalTrains(kind, parameters, np.arange(N) + 7, Seeds(3), "trains")


def spikes(trains: RenewalTrains, *stops_ms: float) -> tuple[Any, Any]:
    parts = [trains.events(a, b) for a, b in zip((0.0, *stops_ms), stops_ms, strict=False)]
    ids, times = (np.concatenate([getattr(p, name) for p in parts]) for name in ("neurons", "times_ms"))
    order = np.lexsort((times, ids))
    return ids[order], times[order]


def intervals(trains: RenewalTrains) -> Any:
    ids, times = spikes(trains, UNTIL_MS)
    assert set(ids) == set(range(7, 7 + N))
    return np.diff(times)[np.diff(ids) == 0]


@pytest.mark.parametrize(
    ("kind", "parameters", "variation"),
    # the coefficient of variation is 1 / sqrt(alpha), and the share of the mean that is not dead time
    [(*KINDS[0], 0.5), (*KINDS[1], 0.25)],
)
def test_intervals_have_the_mean_and_the_variation_of_their_law(
    kind: str, parameters: Any, variation: float
) -> None:
    found = intervals(opened(kind, parameters))
    error = 6.0 / np.sqrt(len(found))
    assert found.mean() == pytest.approx(20.0, rel=error)
    assert found.std() / found.mean() == pytest.approx(variation, rel=2 * error)
    if kind == "SpikeSourcePoissonRefractory":
        assert found.min() >= 15.0


@pytest.mark.parametrize(("kind", "parameters"), KINDS)
def test_trains_do_not_depend_on_how_a_run_is_split(kind: str, parameters: Any) -> None:
    whole = spikes(opened(kind, parameters), 500.0)
    split = spikes(opened(kind, parameters), *np.cumsum([0.7, 11.3, 0.0, 188.0, 300.0]).tolist())
    for one, other in zip(whole, split, strict=True):
        assert one.tolist() == other.tolist()


@pytest.mark.parametrize(("kind", "parameters"), KINDS)
def test_a_saved_train_goes_on_as_it_was(kind: str, parameters: Any) -> None:
    trains = opened(kind, parameters)
    trains.events(0.0, 100.0)
    saved = trains.save()
    expected = trains.events(100.0, 300.0).times_ms.tolist()
    other = opened(kind, parameters)
    other.restore(saved)
    assert other.events(100.0, 300.0).times_ms.tolist() == expected
    trains.restore(saved)
    assert trains.events(100.0, 300.0).times_ms.tolist() == expected


def test_a_train_lies_within_its_window_and_a_rate_of_zero_is_silent() -> None:
    window = {"start": np.full(N, 40.0), "duration": np.full(N, 60.0)}
    trains = opened("SpikeSourceGamma", {**GAMMA, **window, "beta": np.where(np.arange(N) < 5, 0.0, 500.0)})
    ids, times = spikes(trains, 20.0, 200.0)
    assert set(ids) == set(range(12, 7 + N))
    assert 40.0 < times.min() < times.max() < 100.0


@pytest.fixture
def sim() -> ModuleType:
    sim = new_simulator()
    sim.setup(timestep=0.1, seed=5)
    return sim


def test_scripts_have_both_and_change_them_while_they_run(sim: ModuleType) -> None:
    gamma = sim.Population(20, sim.SpikeSourceGamma(alpha=3.0, beta=150.0))
    dead = sim.Population(20, sim.SpikeSourcePoissonRefractory(rate=80.0, tau_refrac=5.0))
    for cells in (gamma, dead):
        cells.record("spikes")
    sim.run(1000.0)
    assert gamma.mean_spike_count() == pytest.approx(50.0, rel=0.1)
    assert dead.mean_spike_count() == pytest.approx(80.0, rel=0.1)
    dead.set(rate=0.0)
    sim.run(1000.0)
    assert gamma.mean_spike_count() == pytest.approx(100.0, rel=0.1)
    trains = dead.get_data().segments[0].spiketrains
    assert max(train.magnitude.max() for train in trains) <= 1000.0


def test_a_dead_time_that_leaves_no_time_is_refused(sim: ModuleType, golden: Golden) -> None:
    with golden.raises(NetworkError, match="300.*250"):
        sim.Population(1, sim.SpikeSourcePoissonRefractory(rate=300.0, tau_refrac=4.0))


@pytest.mark.parametrize(
    "cell_type", ["SpikeSourceGamma", "SpikeSourcePoissonRefractory", "SpikeSourcePoisson"]
)
def test_a_description_without_rates_makes_a_mock_brain(cell_type: str) -> None:
    described = Network({"s": Population("s", 2, cell_type, {})})
    with MockBrain(described) as brain:
        brain.run_until(10_000_000)
        assert not brain.devices
