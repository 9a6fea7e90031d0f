"""Random numbers come from the script's generators, or from streams that the experiment's seed names."""

from collections.abc import Callable
from copy import deepcopy
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.network.data import Network
from nrp_core.network.pynn import builder


def random_network(sim: ModuleType, rng: Any = None, more: bool = False) -> Network:
    """Build a network in which all that can be random is."""

    def between(low: float, high: float) -> Any:
        return sim.RandomDistribution("uniform", (low, high), rng=rng)

    if more:
        sim.Population(3, sim.IF_cond_exp(tau_m=between(5.0, 9.0)), label="another")
    cells = sim.Population(
        10, sim.IF_cond_exp(tau_m=between(5.0, 9.0), cm=between(0.5, 1.0)), label="cells",
        structure=sim.RandomStructure(sim.Sphere(100.0), rng=rng),
        initial_values={"v": between(-70.0, -60.0)},
    )  # fmt: skip
    cells[3:].set(tau_syn_E=between(1.0, 2.0))
    synapse = sim.StaticSynapse(weight=between(0.1, 0.2), delay=between(1.0, 2.0))
    connectors = {
        "probability": sim.FixedProbabilityConnector(0.5, rng=rng),
        "into": sim.FixedNumberPreConnector(3, rng=rng),
        "out of": sim.FixedNumberPostConnector(3, rng=rng),
        "total": sim.FixedTotalNumberConnector(20, rng=rng),
        "small world": sim.SmallWorldConnector(200.0, 0.5, rng=rng),
    }
    for label, connector in connectors.items():
        sim.Projection(cells, cells, connector, synapse, label=label)
    sampled = cells.sample(4, rng)
    sim.Projection(sampled, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=0.1), label="sampled")
    network: Network = sim.network()
    return network


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_equal_seeds_give_equal_networks_and_others_give_others(seed: int) -> None:
    assert random_network(builder(seed)).digest == random_network(builder(seed)).digest
    assert random_network(builder(seed)).digest != random_network(builder(seed + 1)).digest


def test_a_script_with_its_own_generators_draws_the_same_under_any_seed() -> None:
    digests = {random_network(sim, sim.NumpyRNG(7)).digest for sim in (builder(1), builder(2))}
    assert len(digests) == 1


def test_one_thing_more_does_not_change_the_numbers_of_the_others() -> None:
    alone, beside = random_network(builder(1)), random_network(builder(1), more=True)
    first, second = alone.populations["cells"], beside.populations["cells"]
    np.testing.assert_equal(first.parameters, second.parameters)
    np.testing.assert_equal(first.initial_values, second.initial_values)
    np.testing.assert_equal(first.positions_um, second.positions_um)
    for one, other in zip(alone.projections, beside.projections, strict=True):
        np.testing.assert_equal((one.pre_index, one.weight), (other.pre_index, other.weight))


def test_draws_for_different_purposes_differ() -> None:
    network = random_network(builder(1))
    weights = {projection.label: projection.weight[0] for projection in network.projections[:5]}
    assert len(set(weights.values())) == 5
    parameters = network.populations["cells"].parameters
    assert not np.allclose((parameters["tau_m"] - 5.0) / 4.0, (parameters["cm"] - 0.5) / 0.5)


@pytest.mark.parametrize(
    "draw",
    [
        lambda sim: sim.NumpyRNG().next(3),
        lambda sim: sim.NumpyRNG().permutation(np.arange(9)),
        lambda sim: sim.NativeRNG().next(3),
        lambda sim: sim.RandomDistribution("normal", (0.0, 1.0)).next(3),
        lambda sim: sim.random.RandomDistribution("normal", (0.0, 1.0)).next(3),
    ],
)
def test_random_numbers_that_a_script_draws_follow_from_the_seed(draw: Callable[[ModuleType], Any]) -> None:
    assert draw(builder(3)).tolist() == draw(builder(3)).tolist()
    assert draw(builder(3)).tolist() != draw(builder(4)).tolist()


def test_generators_without_a_name_are_independent() -> None:
    sim = builder(3)
    assert sim.NumpyRNG().next(3).tolist() != sim.NumpyRNG().next(3).tolist()


def test_a_copy_of_a_generator_goes_on_where_the_original_is() -> None:
    rng = builder(3).NumpyRNG()
    rng.next(5)
    assert deepcopy(rng).next(3).tolist() == rng.next(3).tolist()


def test_the_global_generator_is_neither_read_nor_changed() -> None:
    np.random.seed(1)  # noqa: NPY002
    before = np.random.get_state()[1].tolist()  # noqa: NPY002
    first = random_network(builder(1)).digest
    assert np.random.get_state()[1].tolist() == before  # noqa: NPY002
    np.random.seed(2)  # noqa: NPY002
    assert random_network(builder(1)).digest == first
