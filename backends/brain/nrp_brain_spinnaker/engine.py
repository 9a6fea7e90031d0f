"""Run the machine: ticks, input that waits for its tick, and spikes as output."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.machine.rewired_rows import Rewired, changing_rewired
from nrp_brain_spinnaker.state import Machine
from nrp_brain_spinnaker.synapses.laws import changing
from nrp_brain_spinnaker.tick import Window, advance
from nrp_core._support.arrays import IntArray

_ROOM = 1024


class Waiting:
    """Entries that wait for their tick, in the memory layout for which the code is compiled.

    Args:
        width: number of columns of an entry: its tick, then its data.
    """

    def __init__(self, width: int) -> None:
        self._entries = np.empty((width, 0), np.int64)

    def add(self, entries: IntArray) -> None:
        """Add entries, shape ``(width, n)``; those of one tick are taken in order of their second column."""
        if self._entries.size:
            entries = np.concatenate([self._entries, entries], axis=1)
        self._entries = entries.take(np.lexsort((entries[1], entries[0])), axis=1)

    def entries(self) -> IntArray:
        """Return all entries in order."""
        return self._entries

    def drop(self, n: int) -> None:
        """Remove the first entries."""
        if n:
            self._entries = self._entries[:, n:].copy()

    def replace(self, entries: IntArray) -> None:
        """Replace all entries."""
        self._entries = entries


class MachineEngine:
    """A machine at a tick.

    Args:
        machine: its arrays, which the engine changes in place.
        rewired: those of synapses that form and vanish, if there are any.
    """

    def __init__(self, machine: Machine, rewired: Rewired | None) -> None:
        self.machine, self.rewired = machine, rewired
        self.tick = 0
        self.source_spikes = Waiting(2)
        """Ticks and global ids."""
        self.device_input = Waiting(3)
        """Ticks, lines and s16.15 values."""
        self.changes: list[IntArray] = []
        """What formed and vanished, as in :class:`Sites`."""

    def run(self, until: int) -> IntArray:
        """Run all ticks before ``until``; return ticks and global ids of the spikes, shape ``(2, n)``."""
        parts = []
        while self.tick < until:
            window = self._window()
            self.tick = advance(self.machine, self.rewired, window, self.tick, until)
            n_sources, n_devices, n_spikes = window.taken.tolist()
            self.source_spikes.drop(n_sources)
            self.device_input.drop(n_devices)
            parts.append(window.spikes[:, :n_spikes])
            self._take_changes()
        return parts[0] if len(parts) == 1 else np.concatenate([np.empty((2, 0), np.int64), *parts], axis=1)

    def _take_changes(self) -> None:
        if self.rewired is not None and (n := int(self.rewired.sites.n_changes[0])):
            self.changes.append(self.rewired.sites.changes[:, :n].copy())
            self.rewired.sites.n_changes[0] = 0

    def _window(self) -> Window:
        room = max(_ROOM, 2 * self.machine.cells.fired.size)
        return Window(
            self.source_spikes.entries(), self.device_input.entries(),
            spikes=np.empty((2, room), np.int64), taken=np.zeros(3, np.int64),
        )  # fmt: skip

    def save(self) -> object:
        """Return the state between two ticks."""
        arrays = [array.copy() for array in self._changing()]
        return self.tick, arrays, self.source_spikes.entries(), self.device_input.entries(), [*self.changes]

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self.tick, arrays, source_spikes, device_input, changes = saved
        for array, values in zip(self._changing(), arrays, strict=True):
            array[...] = values
        self.source_spikes.replace(source_spikes)
        self.device_input.replace(device_input)
        self.changes = [*changes]

    def _changing(self) -> list[npt.NDArray[Any]]:
        """Return the arrays that change during a run."""
        cells, ring, stores = self.machine
        own: list[npt.NDArray[Any]] = [
            cells.state, cells.synapse_state, cells.current, ring.slots, ring.saturated,
        ]  # fmt: skip
        more = [] if self.rewired is None else changing_rewired(self.rewired)
        return [*own, *changing(stores), *more]
