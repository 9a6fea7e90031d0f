"""Synapses of a network found again in a simulator that keeps them in an order of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IntArray

_LAST: Final = "weight"


def same_order(
    ours: Mapping[str, npt.ArrayLike], theirs: Mapping[str, npt.ArrayLike]
) -> tuple[IntArray, IntArray]:
    """Return two orders in which the synapses of both sides are the same.

    Nothing tells apart synapses of equal ends, delays and parameters but their weights. Those may have
    changed by plasticity; but which of them is the larger has not, because all see the same spikes.

    Args:
        ours: values of the synapses by name, each of shape ``(n,)``; ``weight`` is one of them.
        theirs: the same values of the same synapses, each to the last bit, in another order.
    """
    names = [_LAST, *(name for name in ours if name != _LAST)]
    first, second = (np.lexsort([np.atleast_1d(side[name]) for name in names]) for side in (ours, theirs))
    return first, second
