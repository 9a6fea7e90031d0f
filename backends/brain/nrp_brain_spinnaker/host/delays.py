"""Delays in ticks, and the limits of the machine's slots and delay extensions."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray

RING_BITS = 14
"""Bits of the index into a core's ring buffer: 16384 entries of 16 bits."""
MOST_STAGES = 8
"""Stages of a delay extension, each as long as the ring."""
RECEPTORS = 2


def bits_for(n: int) -> int:
    """Return the number of bits of an index over ``n`` items, at least 1."""
    return max(1, (n - 1).bit_length())


def slots_available(neurons_on_core: int) -> int:
    """Return the maximum delay in the ring buffer of a core, in ticks."""
    return 1 << (RING_BITS - bits_for(neurons_on_core) - bits_for(RECEPTORS))


def slots_used(neurons_on_core: int, longest: int) -> int:
    """Return the number of slots for a longest delay in ticks, 0 without any synapse."""
    if not longest:
        return 1
    return min(slots_available(neurons_on_core), 1 << bits_for(longest))


def longest_delay(neurons_on_core: int) -> int:
    """Return the longest delay in ticks with all stages of a delay extension."""
    return slots_available(neurons_on_core) * (MOST_STAGES + 1)


def stages(neurons_on_core: int, longest: int) -> int:
    """Return the number of stages of the delay extension for a longest delay in ticks."""
    return -(-longest // slots_available(neurons_on_core)) - 1


def to_ticks(delays_ms: FloatArray, step_us: int, *, drawn_on_machine: bool) -> IntArray:
    """Convert delays to ticks, possibly 0: to the nearest, or truncated if a core draws them."""
    ticks = delays_ms * 1000 / step_us
    return (np.floor(ticks) if drawn_on_machine else np.rint(ticks)).astype(np.int64)
