"""Spikes and synaptic events as flat arrays.

The objects are never changed. They are not frozen dataclasses because some are created in every step, and
freezing takes four times as long.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray


def _no_ids() -> IntArray:
    return np.empty(0, np.int64)


def _no_times() -> FloatArray:
    return np.empty(0)


@dataclass(slots=True)
class Spikes:
    """Spikes of neurons, ascending in time.

    Args:
        neurons: global ids, shape ``(n,)``.
        times_ms: exact times, never rounded to a clock, shape ``(n,)``.
    """

    neurons: IntArray = field(default_factory=_no_ids)
    times_ms: FloatArray = field(default_factory=_no_times)

    def __len__(self) -> int:
        return len(self.neurons)

    @classmethod
    def merged(cls, parts: Sequence[Spikes]) -> Spikes:
        """Join parts, sorted by time and by id among equal times."""
        if len(parts) > 1:
            parts = [part for part in parts if len(part)]
        if not parts:
            return NO_SPIKES
        whole = parts[0]
        if len(parts) > 1:
            neurons = np.concatenate([part.neurons for part in parts])
            whole = cls(neurons, np.concatenate([part.times_ms for part in parts]))
        neurons, times = whole.neurons, whole.times_ms
        if len(times) < 2:
            return whole
        later = times[1:] > times[:-1]
        if np.count_nonzero(later) == len(later):
            return whole
        if (later | ((times[1:] == times[:-1]) & (neurons[1:] >= neurons[:-1]))).all():
            return whole
        order = times.argsort(kind="stable")  # a merge if the parts are ascending; then only ties are sorted
        neurons, times = neurons[order], times[order]
        tied = np.zeros(len(times), np.bool_)
        tied[1:] = times[1:] == times[:-1]
        tied[:-1] |= tied[1:]
        if tied.any():
            neurons[tied] = neurons[tied][np.lexsort((neurons[tied], times[tied]))]
        return cls(neurons, times)

    def among(self, chosen: npt.NDArray[np.bool_]) -> Spikes:
        """Return the spikes of selected neurons, given as a mask over global ids."""
        (places,) = chosen[self.neurons].nonzero()
        return Spikes(self.neurons[places], self.times_ms[places])

    def within(self, since_ms: float, until_ms: float) -> Spikes:
        """Return the spikes with ``since_ms < t <= until_ms``."""
        first, last = np.searchsorted(self.times_ms, [since_ms, until_ms], side="right")
        return Spikes(self.neurons[first:last], self.times_ms[first:last])

    def later(self, by_ms: float, since_ms: float, until_ms: float) -> Spikes:
        """Return the spikes some time later; rounding moves none out of ``since_ms < t <= until_ms``."""
        times_ms = np.clip(self.times_ms + by_ms, np.nextafter(since_ms, np.inf), until_ms)
        return Spikes(self.neurons, times_ms)


NO_SPIKES: Final = Spikes()


@dataclass(slots=True)
class SynapticEvents:
    """Events from outside the network that arrive at synapses of neurons.

    Args:
        neurons: global ids of the targets, shape ``(n,)``.
        times_ms: exact arrival times, not before now, shape ``(n,)``.
        weights: weights in PyNN's units for the target's cell type, shape ``(n,)``.
        receptor: ``excitatory`` or ``inhibitory``.
    """

    neurons: IntArray
    times_ms: FloatArray
    weights: FloatArray
    receptor: str = "excitatory"

    def __len__(self) -> int:
        return len(self.neurons)

    def earlier(self, by_ms: float, since_ms: float) -> SynapticEvents:
        """Return the events some time earlier; rounding moves none before ``since_ms``."""
        times_ms = np.maximum(self.times_ms - by_ms, since_ms)
        return SynapticEvents(self.neurons, times_ms, self.weights, self.receptor)
