"""The inputs and outputs of a brain in one step of the loop, as columns in shared memory."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.data import RECEPTORS
from nrp_core.brain.remote.columns import SharedColumns
from nrp_core.brain.remote.messages import Numbers
from nrp_core.brain.spikes import Spikes, SynapticEvents


class Inputs:
    """The inputs of a brain for its next step."""

    def __init__(self) -> None:
        self._fired: list[tuple[IntArray, FloatArray]] = []
        self._events: dict[str, list[SynapticEvents]] = {receptor: [] for receptor in RECEPTORS}
        self._currents_na: list[FloatArray] = []

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Add spikes of source cells."""
        self._fired.append((neurons, times_ms))

    def inject(self, events: SynapticEvents) -> None:
        """Add synaptic events."""
        self._events[events.receptor].append(events)

    def set_current(self, currents_na: FloatArray) -> None:
        """Set the currents; only the last ones are used."""
        self._currents_na = [currents_na]

    def write(self, memory: SharedColumns) -> Numbers:
        """Write everything; return the numbers of spikes, of events at each receptor, and of currents."""
        columns = [*(neurons for neurons, _ in self._fired), *(times_ms for _, times_ms in self._fired)]
        counts = [sum(map(len, columns)) // 2]
        for events in self._events.values():
            for name in ("neurons", "times_ms", "weights"):
                columns += [getattr(one, name) for one in events]
            counts.append(sum(map(len, events)))
        columns += self._currents_na
        counts.append(sum(map(len, self._currents_na)))
        memory.write(columns)
        return tuple(counts)


def carry_out(brain: Brain, memory: SharedColumns, counts: Numbers) -> None:
    """Pass the inputs written by :meth:`Inputs.write` to a brain."""
    n_fired, *n_events, n_currents = counts
    column = _Cutter(memory.read(2 * n_fired + 3 * sum(n_events) + n_currents))
    if n_fired:
        brain._do_fire(column.integers(n_fired), column.floats(n_fired))
    for receptor, n in zip(RECEPTORS, n_events, strict=True):
        if n:
            events = SynapticEvents(column.integers(n), column.floats(n), column.floats(n), receptor)
            brain._do_inject(events)
    if n_currents:
        brain._do_set_current(column.floats(n_currents))


def write_spikes(memory: SharedColumns, spikes: Spikes) -> int:
    """Write spikes and return their number."""
    memory.write([spikes.neurons, spikes.times_ms])
    return len(spikes)


def read_spikes(memory: SharedColumns, n: int) -> Spikes:
    """Return the spikes written by :func:`write_spikes`."""
    column = _Cutter(memory.read(2 * n))
    return Spikes(column.integers(n), column.floats(n))


class _Cutter:
    """Splits a block of numbers into consecutive columns."""

    def __init__(self, block: IntArray) -> None:
        self._block, self._at = block, 0

    def integers(self, n: int) -> IntArray:
        column = self._block[self._at : self._at + n]
        self._at += n
        return column

    def floats(self, n: int) -> FloatArray:
        return self.integers(n).view(np.float64)
