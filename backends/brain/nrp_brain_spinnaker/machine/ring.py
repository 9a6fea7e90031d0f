"""Synaptic input buffers: a ring of slots, one per tick, of unsigned 16-bit entries per neuron and receptor.

An entry saturates at 65535, and the loss is counted. A left shift, one per population and receptor, converts
an entry to s16.15. Input from devices, which do not belong to the network, is added after the shift.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import clamp, wrap
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_core._support.arrays import IndexArray, IntArray
from nrp_core._support.jit import jit

LARGEST_ENTRY: Final = 65535

WeightArray = npt.NDArray[np.uint16]


class Ring(NamedTuple):
    """Input in transit. The *line* of neuron ``i`` of ``n`` is ``receptor * n + i``.

    Args:
        slots: entries, shape ``(a power of two, 2 n)``.
        device: s16.15 input of devices for the current tick, shape ``(2 n,)``.
        saturated: number of losses of each line, shape ``(2 n,)``.
    """

    slots: WeightArray
    device: IntArray
    saturated: IntArray


class Rows(NamedTuple):
    """Static synapses, ordered by source neuron.

    Args:
        start: first synapse of each global id, shape ``(network.size + 1,)``.
        line, weight, delay: target line, raw weight, delay in ticks; shape ``(n_synapses,)``.
    """

    start: IntArray
    line: IndexArray
    weight: WeightArray
    delay: WeightArray


@jit
def add_entry(ring: Ring, slot: int, line: int, weight: int | np.int64) -> None:
    """Add a raw weight to an entry."""
    total = np.int64(ring.slots[slot, line]) + weight
    if total > LARGEST_ENTRY:
        total = np.int64(LARGEST_ENTRY)
        ring.saturated[line] += 1
    ring.slots[slot, line] = total


@jit
def deliver(rows: Rows, ring: Ring, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) in ``tick`` through its static synapses."""
    mask = ring.slots.shape[0] - 1
    for k in range(rows.start[neuron], rows.start[neuron + 1]):
        slot = (tick + np.int64(rows.delay[k])) & mask
        add_entry(ring, slot, rows.line[k], np.int64(rows.weight[k]))


@jit
def transfer(cells: Cells, ring: Ring, population: int, tick: int) -> None:
    """Move a population's input of ``tick`` into ``cells.arrived`` and clear it."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    slot, n = tick & (ring.slots.shape[0] - 1), cells.ids.size
    for receptor in range(2):
        shift = cells.populations[population, kinds.SHIFT_EXC + receptor]
        for i in range(first, last):
            line = receptor * n + i
            x = wrap(np.int64(ring.slots[slot, line]) << shift)
            ring.slots[slot, line] = 0
            extra = ring.device[line]
            if extra != 0:
                ring.device[line] = 0
                ring.saturated[line] += clamp(x + extra) != x + extra
                x = clamp(x + extra)
            cells.arrived[receptor, i] = x
