"""The share of its weight with which a spike arrives, by the law of its synapse."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nrp_brain_event.synapse_laws import SHARES, Share
from nrp_core._support.jit import jit


def one_of(kernels: Sequence[Share]) -> Share:
    """Return a kernel that runs the one whose number is the ``law`` of a record; one alone as it is."""
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
