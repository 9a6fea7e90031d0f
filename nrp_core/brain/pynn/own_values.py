"""Values of synapses drawn for a whole projection at once, as PyNN draws them column by column."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from math import inf
from typing import Any

from pyNN.random import NumpyRNG, RandomDistribution

from nrp_core.brain.network.drawing import Drawn, are_drawn_again
from nrp_core.brain.pynn.synapse_columns import constant

_PLAIN = frozenset({"normal", "uniform"})
"""Distributions whose numbers do not depend on how many are drawn at a time."""


def drawn_at_once(space: Any, counts: Any) -> dict[str, Any] | None:
    """Return the values of all synapses by parameter, or None if they must be drawn column by column.

    Args:
        space: PyNN's parameters of the synapses, for the connection matrix.
        counts: the number of synapses of each postsynaptic cell.
    """
    lazy = dict(space.items())
    random = [value for value in lazy.values() if not value.is_homogeneous]
    if any(value.operations or not _is_numpy(value.base_value) for value in random):
        return None
    if len({id(value.base_value.rng.rng) for value in random}) < len(random):
        return None  # they take turns with one generator
    n = int(counts.sum())
    if not n or not all(_is_known(value.base_value, n) for value in random):
        return None
    return {
        name: constant(value.evaluate(simplify=True), n)
        if value.is_homogeneous
        else _drawn(value.base_value, counts, n)
        for name, value in lazy.items()
    }


def _is_numpy(value: Any) -> bool:
    return isinstance(value, RandomDistribution) and isinstance(value.rng, NumpyRNG)


def _is_known(distribution: RandomDistribution, n: int) -> bool:
    return distribution.name in _PLAIN or (distribution.name == "normal_clipped" and are_drawn_again(n))


def _drawn(distribution: RandomDistribution, counts: Any, n: int) -> Any:
    if distribution.name == "uniform" or not are_drawn_again(n):
        return distribution.next(n)
    of = distribution.parameters
    limits = of.get("low", -inf), of.get("high", inf)
    return Drawn.by(distribution.rng.rng, (of["mu"], of["sigma"], *limits), counts)
