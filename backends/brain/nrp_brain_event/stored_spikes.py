"""Takes the spikes that compiled code has stored."""

from __future__ import annotations

from nrp_brain_event.records import Array
from nrp_core.brain.spikes import NO_SPIKES, Spikes


class StoredSpikes:
    """The new spikes of an engine.

    Args:
        clock: its clock, with their number ``n_spikes``.
        spikes: ``Spike``, the array that they are stored in.
    """

    def __init__(self, clock: Array, spikes: Array) -> None:
        # views, which are found once because every step needs them
        self._n, self._ids, self._times_ms = clock["n_spikes"], spikes["id"], spikes["time"]

    def take(self) -> Spikes:
        """Return and clear the spikes."""
        n = self._n.item(0)
        if not n:
            return NO_SPIKES
        self._n[0] = 0
        return Spikes(self._ids[:n].copy(), self._times_ms[:n].copy())
