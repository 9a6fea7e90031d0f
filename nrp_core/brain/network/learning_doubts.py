"""Rules of plasticity that are valid and probably not meant: their limits and amplitudes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from nrp_core.brain.network.data import Projection

_NOTHING: Final = np.empty(0)
_AMPLITUDES: Final = ("A_plus", "A_minus", "A3_plus", "A3_minus")


def doubts_about_learning(owner: str, projection: Projection) -> Iterator[str]:
    """Yield a sentence for each doubtful limit and amplitude of the weights of a projection.

    Args:
        owner: what it is called in the sentences.
        projection: a projection with synapses.
    """
    yield from _beyond_limits(owner, projection)
    yield from _of_pairs(owner, projection)
    yield from _unchanging(owner, projection)


def _unchanging(owner: str, projection: Projection) -> Iterator[str]:
    """Yield the rules that change no weight; equations have other names."""
    rule = projection.synapse_parameters
    if projection.equations is not None or not projection.plasticity:
        return
    low, high = (np.abs(rule.get(name, _NOTHING)) for name in ("w_min", "w_max"))
    if low.size and high.size and (low == high).all():
        yield f"the weights of {owner} cannot change: w_min and w_max are both {high[0]:g}"
    changes = [rule.get(name, _NOTHING).any() for name in _AMPLITUDES]
    if {"A_plus", "A_minus"} <= rule.keys() and not any(changes):
        yield f"the weights of {owner} cannot change: A_plus and A_minus are 0"


def _beyond_limits(owner: str, projection: Projection) -> Iterator[str]:
    limits = projection.synapse_parameters
    if not {"w_min", "w_max"} <= limits.keys():
        return
    # a current of the inhibitory receptor is negative, the limits of its size are not
    sizes = np.abs(projection.weight)
    above, below = sizes > limits["w_max"], sizes < limits["w_min"]
    for beyond, name, change in ((above, "w_max", "above"), (below, "w_min", "below")):
        if beyond.any():
            first = int(np.flatnonzero(beyond)[0])
            limit = np.broadcast_to(limits[name], sizes.shape)[first]
            yield (
                f"{int(beyond.sum())} of {projection.size} weights of {owner} begin {change} {name}: "
                f"{sizes[first]:g}, and {name} is {limit:g}"
            )


def _of_pairs(owner: str, projection: Projection) -> Iterator[str]:
    """Yield the doubtful amplitudes of spike-timing-dependent plasticity."""
    for name in ("A_plus", "A_minus"):
        values = np.abs(projection.synapse_parameters.get(name, _NOTHING))
        if values.size and values.max() > 1.0:
            yield (
                f"{name} of {owner} is {values.max():g}: a pair of spikes changes a weight by more than the "
                "whole range from w_min to w_max"
            )
    plus, minus = (projection.synapse_parameters.get(name, _NOTHING) for name in ("A_plus", "A_minus"))
    if plus.size and minus.size and plus.min() > 0 and minus.max() < 0:
        yield (
            f"A_minus of {owner} is {minus.max():g}: PyNN subtracts it, so that every pair of "
            "spikes strengthens a synapse; is it meant without the sign?"
        )
