"""Maps the synapses of a network to those of a simulator that stores them in another order."""

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
    """Return two orders that put the synapses of both sides in the same sequence.

    Synapses of equal ends, delays and parameters differ only in their weights. Plasticity may have changed
    these, but not their order, because all such synapses see the same spikes.

    Args:
        ours: values of the synapses by name, each of shape ``(n,)``, including ``weight``.
        theirs: the same values of the same synapses, equal to the last bit, in another order.
    """
    names = [_LAST, *(name for name in ours if name != _LAST)]
    first, second = (np.lexsort([np.atleast_1d(side[name]) for name in names]) for side in (ours, theirs))
    return first, second
