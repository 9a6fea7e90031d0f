"""Values of large projections are drawn again when they are read, and are PyNN's."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest
from golden import Golden
from pyNN.random import NumpyRNG, RandomDistribution

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import COMPILED
from nrp_core.checks.network_units import unlikely_units
from nrp_core.errors import NetworkError
from nrp_core.network.data import Network
from nrp_core.network.drawing import Drawn, sorted_by
from nrp_core.network.indices import stored_form
from nrp_core.network.pynn import builder
from nrp_core.network.pynn.rng import random_pairs
from nrp_core.seeds import Seeds

DELAYS = 1.5, 0.75, 0.1, inf
"""Mean, deviation and limits: about every thirtieth is replaced."""
COUNTS = np.random.RandomState(3).randint(0, 60, size=3000)
GENERATORS = {
    "seeded": lambda: np.random.RandomState(5),
    "named": lambda: np.random.RandomState(Seeds(1).stream("projection/a/delay").bit_generator),
}


def as_pynn_draws(generator: np.random.RandomState, counts: IntArray) -> FloatArray:
    """Return the columns as PyNN's own distribution returns them one by one."""
    rng = NumpyRNG(seed=1)
    rng.rng = generator
    clipped = RandomDistribution("normal_clipped", DELAYS, rng)
    return np.concatenate([clipped.next(int(n)) for n in counts])


@pytest.mark.skipif(not COMPILED, reason="without a compiler all values are kept")
@pytest.mark.parametrize("make", GENERATORS.values(), ids=GENERATORS)
def test_values_and_generator_are_those_of_pynn(make: Callable[[], np.random.RandomState]) -> None:
    ours, theirs = make(), make()
    expected = as_pynn_draws(theirs, COUNTS)
    drawn = Drawn.by(ours, DELAYS, COUNTS)
    np.testing.assert_array_equal(drawn.whole(), expected)
    np.testing.assert_array_equal(drawn.whole(), expected)  # and at each further read
    np.testing.assert_array_equal(drawn.bounds, [expected.min(), expected.max()])
    assert len(drawn) == len(expected)
    assert ours.normal() == theirs.normal()


@pytest.mark.skipif(not COMPILED, reason="without a compiler all values are kept")
def test_values_replaced_after_the_last_column_would_be_others() -> None:
    """The comparison above notices the mistake that is nearest."""
    make = GENERATORS["seeded"]
    as_one = Drawn.by(make(), DELAYS, np.array([COUNTS.sum()])).whole()
    assert not np.array_equal(as_one, as_pynn_draws(make(), COUNTS))


def built(fewest: int, monkeypatch: pytest.MonkeyPatch) -> Network:
    monkeypatch.setattr("nrp_core.network.drawing.FEWEST", fewest)
    sim = builder(seed=1)
    sim.setup(timestep=0.1)
    pre, post = (
        sim.Population(n, sim.IF_curr_exp(), label=label) for n, label in ((40, "pre"), (30, "post"))
    )
    weight = sim.RandomDistribution("normal_clipped", mu=0.1, sigma=0.05, low=0.0, high=inf)
    delay = sim.RandomDistribution("normal_clipped", mu=1.5, sigma=0.75, low=0.1, high=inf)
    synapse = sim.StaticSynapse(weight=weight, delay=delay)
    one = sim.Projection(pre, post, sim.FixedTotalNumberConnector(2000), synapse, label="one")
    assert one.get("weight", format="list")[0][2] == one[0].weight
    return sim.network()


def test_a_network_is_the_same_whether_values_are_kept_or_drawn_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    small, large = built(10**6, monkeypatch), built(100, monkeypatch)
    assert isinstance(stored_form(large.projections[0], "weight"), Drawn) == COMPILED
    assert isinstance(stored_form(small.projections[0], "weight"), np.ndarray)
    np.testing.assert_array_equal(large.projections[0].delay_ms, small.projections[0].delay_ms)
    assert large.digest == small.digest


@pytest.mark.skipif(not COMPILED, reason="without a compiler all values are kept")
def test_an_impossible_value_among_drawn_ones_is_named(
    monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    network = built(100, monkeypatch)
    (one,) = network.projections
    values = Drawn.by(np.random.RandomState(1), (0.1, 0.05, -inf, inf), stored_form(one, "weight").counts)
    first = int(np.argmax(values.whole() < 0))
    with golden.raises(NetworkError, match=f"{first}.*->"):
        Network(network.populations, (replace(one, delay_ms=values),))
    assert deepcopy(values).whole()[first] == values.whole()[first]


@pytest.mark.skipif(not COMPILED, reason="without a compiler all values are kept")
def test_drawn_values_are_checked_by_their_extremes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing those of a large network again takes longer than to build it."""
    network = built(100, monkeypatch)
    (one,) = network.projections
    assert unlikely_units(network) == []
    slow = Drawn.by(np.random.RandomState(1), (3000.0, 500.0, 0.1, inf), stored_form(one, "delay_ms").counts)
    slow_network = Network(network.populations, (replace(one, delay_ms=slow),))
    monkeypatch.setattr(Drawn, "_draw", None)
    (message,) = unlikely_units(slow_network)
    assert message == f"a delay of the projection 'one' is {slow.bounds[1]:g} ms; is it meant in us?"


@pytest.mark.skipif(not COMPILED, reason="without a compiler there is one way")
def test_many_synapses_are_paired_and_sorted_as_few_are(monkeypatch: pytest.MonkeyPatch) -> None:
    def made() -> tuple[list[np.ndarray[Any, Any]], int]:
        rng = NumpyRNG(seed=3)
        pre, post = random_pairs(rng, 37, 90, 5000)
        return [pre, post, *sorted_by(post, pre, 90)], int(rng.rng.randint(1 << 30))

    few, after = made()
    monkeypatch.setattr("nrp_core.network.pynn.rng._FEW", 0)
    monkeypatch.setattr("nrp_core.network.drawing._FEW", 0)
    many, after_many = made()
    for one, other in zip(few, many, strict=True):
        np.testing.assert_array_equal(one, other)
    assert after == after_many
