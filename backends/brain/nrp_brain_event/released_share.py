"""The share of its weight that a spike transmits, by the law of its synapse."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nrp_brain_event.synapse_laws import SHARES, Share
from nrp_core._support.jit import jit


def one_of(kernels: Sequence[Share]) -> Share:
    """Return a kernel that calls the one selected by the ``law`` of a record; a single one itself."""
    *others, chosen = kernels
    for number, kernel in reversed(list(enumerate(others))):
        chosen = _either(number, kernel, chosen)
    return chosen


def _either(number: int, kernel: Share, other: Share) -> Share:
    def share(synapse: Any, t: float) -> float:
        if synapse.law == number:
            return kernel(synapse, t)
        return other(synapse, t)

    return jit(share)


released_share = one_of([load() for load in SHARES.values()])
