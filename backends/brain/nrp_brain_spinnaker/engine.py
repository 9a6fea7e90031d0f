"""Run the machine: ticks, input that waits for its tick, and spikes as output.

One tick of the machine, and many.

The order is the machine's: synapses form and vanish; input is transferred from the ring; every neuron is
updated and compared with its threshold, and its synapses decay; then the spikes are sent. A spike in tick
``t`` with a delay of ``d`` ticks acts in the update of tick ``t + d``.

The data of the compiled code.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.neuron_kernels import gather_currents, update_neurons
from nrp_brain_spinnaker.machine.rewired_rows import (
    Rewired,
    changing_rewired,
    deliver_rewired,
    emit_rewired,
    has_room,
)
from nrp_brain_spinnaker.machine.rewiring import rewire
from nrp_brain_spinnaker.machine.synaptic_inputs import (
    Ring,
    add_arrived,
    decay_synapses,
    read_values,
    transfer,
)
from nrp_brain_spinnaker.synapses.laws import Stores, changing, note_spike, send
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import borrowed, jit


class Machine(NamedTuple):
    """The arrays of a network on the machine."""

    cells: Cells
    ring: Ring
    stores: Stores


class Window(NamedTuple):
    """The input and output of the machine during a run.

    Args:
        source_spikes: ticks and global ids of source cells, ascending in time, shape ``(2, n)``.
        device_input: ticks, lines and s16.15 values, ascending in time, shape ``(3, n)``.
        spikes: ticks and global ids of other cells, with room for at least the spikes of one tick.
        taken: numbers of used source spikes, used device inputs and emitted spikes.
    """

    source_spikes: IntArray
    device_input: IntArray
    spikes: IntArray
    taken: IntArray


@jit
def begin_tick(cells: Cells, ring: Ring, tick: int) -> None:
    """Transfer the input of a tick; the recorded state of a tick is the state after this."""
    for population in range(cells.populations.shape[0]):
        transfer(cells, ring, population, tick)
        add_arrived(cells, population)


@jit
def finish_tick(cells: Cells) -> None:
    """Update all neurons."""
    cells.n_fired[0] = 0
    for population in range(cells.populations.shape[0]):
        for _ in range(cells.populations[population, kinds.SUBSTEPS]):
            read_values(cells, population)
            gather_currents(cells, population)
            update_neurons(cells, population)
            decay_synapses(cells, population)


@jit
def advance(machine: Machine, rewired: Rewired | None, window: Window, tick: int, until: int) -> int:
    """Run ticks up to ``until``, or until the output is full; return the tick reached."""
    lent = borrowed(machine)  # counting shares in the arrays takes most of a short tick
    cells, ring = lent.cells, lent.ring
    sources, devices = borrowed(window.source_spikes), borrowed(window.device_input)
    taken = borrowed(window.taken)
    room = window.spikes.shape[1] - cells.fired.size
    while tick < until and taken[2] <= room and (rewired is None or has_room(rewired)):
        while taken[1] < devices.shape[1] and devices[0, taken[1]] <= tick:
            ring.device[devices[1, taken[1]]] += devices[2, taken[1]]
            taken[1] += 1
        if rewired is not None:  # without them this is not compiled
            rewire(rewired, tick)
        while taken[0] < sources.shape[1] and sources[0, taken[0]] < tick:  # late, but not at its targets
            send(lent.stores, ring, sources[1, taken[0]], sources[0, taken[0]])
            if rewired is not None:
                deliver_rewired(rewired, ring, sources[1, taken[0]], sources[0, taken[0]])
            taken[0] += 1
        begin_tick(cells, ring, tick)
        finish_tick(cells)
        if cells.n_fired[0] > 0:
            _emit(cells, ring, lent.stores, window, tick)
            if rewired is not None:
                emit_rewired(rewired, cells, ring, tick)
        while taken[0] < sources.shape[1] and sources[0, taken[0]] <= tick:
            send(lent.stores, ring, sources[1, taken[0]], tick)
            if rewired is not None:
                deliver_rewired(rewired, ring, sources[1, taken[0]], tick)
            taken[0] += 1
        tick += 1
    return tick


@jit
def _emit(cells: Cells, ring: Ring, stores: Stores, window: Window, tick: int) -> None:
    """Store the spikes, then send them."""
    n_fired = cells.n_fired[0]
    for k in range(n_fired):
        note_spike(stores, cells.fired[k], tick)
    for k in range(n_fired):
        neuron, place = cells.ids[cells.fired[k]], window.taken[2] + k
        window.spikes[0, place], window.spikes[1, place] = tick, neuron
        send(stores, ring, neuron, tick)
    window.taken[2] += n_fired


_ROOM = 1024


class Waiting:
    """Entries that wait for their tick, in the memory layout for which the code is compiled.

    Args:
        width: number of columns of an entry: its tick, then its data.
    """

    def __init__(self, width: int) -> None:
        self._entries = np.empty((width, 0), np.int64)

    def add(self, entries: IntArray) -> None:
        """Add entries, shape ``(width, n)``; entries of one tick are ordered by their second column."""
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
        rewired: the store of synapses that form and vanish, if the network has such.
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
