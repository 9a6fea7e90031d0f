"""Source cells, which the core draws, change while any brain runs; what cannot be is refused."""

import numpy as np
import pytest
from golden import Golden

from nrp_core.brain.devices.source_cells import PopulationTrains
from nrp_core.errors import NetworkError
from nrp_core.network.changes import new_weights, parameter_changes, projection_of, spike_trains
from nrp_core.network.data import Network, Population, Projection
from nrp_core.seeds import Seeds

SEEDS = Seeds(4)


def array(*trains: list[float]) -> Population:
    return Population("s", len(trains), "SpikeSourceArray", {}, {}, tuple(np.array(t, float) for t in trains))


def poisson(rate: list[float], start: float = 0.0) -> Population:
    n = len(rate)
    values = {"rate": np.array(rate), "start": np.full(n, start), "duration": np.full(n, 1e6)}
    return Population("s", n, "SpikeSourcePoisson", values)


def trains_of(population: Population, first: int = 7) -> PopulationTrains:
    return PopulationTrains(population, np.arange(first, first + population.size), SEEDS)


def emitted(trains: PopulationTrains, since: float, until: float) -> list[tuple[int, float]]:
    ids, times = trains.emitted(since, until)
    return list(zip(ids.tolist(), times.tolist(), strict=True))


def test_a_new_train_replaces_what_has_not_been_emitted():
    trains = trains_of(array([1.0, 9.0], [2.0, 8.0]))
    trains.set_spike_times(np.array([0]), [np.array([1.0, 3.0, 6.0])], 4.0)
    assert emitted(trains, 4.0, 10.0) == [(7, 6.0), (8, 8.0)]


def test_a_spike_at_this_very_moment_comes_yet_unless_it_has_come():
    trains = trains_of(array([5.0], [9.0]))
    trains.set_spike_times(np.array([0, 1]), [np.array([5.0]), np.array([5.0])], 5.0)
    ((neuron, time),) = emitted(trains, 5.0, 10.0)
    assert (neuron, time) == (8, pytest.approx(5.0))


def test_a_state_keeps_replaced_trains_and_a_reset_forgets_them():
    trains = trains_of(array([1.0, 9.0]))
    before = trains.save()
    trains.set_spike_times(np.array([0]), [np.array([6.0])], 4.0)
    after = trains.save()
    trains.restore(before)
    assert emitted(trains, 4.0, 10.0) == [(7, 9.0)]
    trains.restore(after)
    assert emitted(trains, 4.0, 10.0) == [(7, 6.0)]
    trains.reset(SEEDS)
    assert emitted(trains, 0.0, 10.0) == [(7, 1.0), (7, 9.0)]


def test_a_change_of_one_rate_leaves_the_others_their_statistics():
    trains = trains_of(poisson([100.0, 100.0]))
    emitted(trains, 0.0, 1000.0)
    trains.set_parameters(np.array([1]), {"rate": np.array([0.0])})
    later = emitted(trains, 1000.0, 11000.0)
    assert {neuron for neuron, _ in later} == {7}
    assert 850 < len(later) < 1150


def test_a_change_of_the_start_opens_a_new_train():
    trains = trains_of(poisson([200.0, 200.0]))
    emitted(trains, 0.0, 100.0)
    trains.set_parameters(np.array([0]), {"start": np.array([500.0])})
    later = emitted(trains, 100.0, 900.0)
    assert min(time for neuron, time in later if neuron == 7) > 500.0
    assert min(time for neuron, time in later if neuron == 8) < 200.0
    saved = trains.save()
    expected = emitted(trains, 900.0, 1500.0)
    other = trains_of(poisson([200.0, 200.0]))
    other.restore(saved)
    assert emitted(other, 900.0, 1500.0) == expected


@pytest.fixture
def network() -> Network:
    values = {"tau_m": np.full(3, 20.0), "cm": np.ones(3)}
    populations = {"s": array([1.0]), "n": Population("n", 3, "IF_cond_exp", values)}
    index = np.zeros(2, np.int32)
    synapses = Projection("p", "s", "n", "excitatory", index, index, np.ones(2), np.ones(2))
    return Network(populations, (synapses,))


def test_values_go_to_the_cells_in_the_order_in_which_they_are_named(network):
    (change,) = parameter_changes(network, np.array([3, 1]), {"tau_m": [5.0, 6.0], "cm": 2.0})
    assert (change.label, change.index.tolist()) == ("n", [2, 0])
    assert change.values["tau_m"].tolist() == [5.0, 6.0]
    assert change.values["cm"].tolist() == [2.0, 2.0]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"tau": 1.0}, r"'n' \(IF_cond_exp\).*'tau'"),
        ({"tau_m": [1.0, -2.0]}, "'n': tau_m.*-2"),
        ({"tau_m": [1.0, 2.0, 3.0]}, "tau_m"),
    ],
)
def test_parameters_that_cannot_be_are_refused(network, values, message, golden: Golden):
    with golden.raises(NetworkError, match=message):
        parameter_changes(network, np.array([3, 1]), values)


def test_weights_and_trains_that_cannot_be_are_refused(network, golden: Golden):
    with golden.raises(NetworkError, match=r"1 \(0 -> 0\).*-1"):
        new_weights(network, "p", [1.0, -1.0])
    with golden.raises(NetworkError, match="'q'"):
        projection_of(network, "q")
    with golden.raises(NetworkError, match="'n'.*SpikeSourceArray"):
        spike_trains(network, "n", [[1.0]], None)
    with golden.raises(NetworkError, match="'s': 2"):
        spike_trains(network, "s", [[1.0], [2.0]], None)
