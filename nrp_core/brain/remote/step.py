"""What a step of the loop brings to a brain and takes from it, as columns in shared memory."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.data import RECEPTORS
from nrp_core.brain.remote.columns import SharedColumns
from nrp_core.brain.remote.messages import Numbers
from nrp_core.brain.spikes import Spikes, SynapticEvents


class Inputs:
    """What a brain is to get before it runs on."""

    def __init__(self) -> None:
        self._fired: list[tuple[IntArray, FloatArray]] = []
        self._events: dict[str, list[SynapticEvents]] = {receptor: [] for receptor in RECEPTORS}
        self._currents_na: list[FloatArray] = []

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Let source cells emit spikes."""
        self._fired.append((neurons, times_ms))

    def inject(self, events: SynapticEvents) -> None:
        """Let events arrive."""
        self._events[events.receptor].append(events)

    def set_current(self, currents_na: FloatArray) -> None:
        """Hold these currents; the last ones count."""
        self._currents_na = [currents_na]

    def write(self, memory: SharedColumns) -> Numbers:
        """Write everything, and return how many spikes, events at each receptor, and currents there are."""
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
    """Give a brain what :meth:`Inputs.write` wrote."""
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
    """Write spikes, and return how many there are."""
    memory.write([spikes.neurons, spikes.times_ms])
    return len(spikes)


def read_spikes(memory: SharedColumns, n: int) -> Spikes:
    """Return what :func:`write_spikes` wrote."""
    column = _Cutter(memory.read(2 * n))
    return Spikes(column.integers(n), column.floats(n))


class _Cutter:
    """Cuts columns off a block of numbers, one after the other."""

    def __init__(self, block: IntArray) -> None:
        self._block, self._at = block, 0

    def integers(self, n: int) -> IntArray:
        column = self._block[self._at : self._at + n]
        self._at += n
        return column

    def floats(self, n: int) -> FloatArray:
        return self.integers(n).view(np.float64)
