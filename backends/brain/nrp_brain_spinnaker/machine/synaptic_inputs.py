"""Synapses convert input to a current or conductance over time: exponential, alpha, delta.

A tick has three phases: input is added, the value is read, the state decays. The alpha function with a peak
is ours: its value is the mean over the step, as for the machine's exponential, so the charge of an event is
right on any grid.

Synaptic input buffers: a ring of slots, one per tick, of unsigned 16-bit entries per neuron and receptor.

An entry saturates at 65535, and the loss is counted. A left shift, one per population and receptor, converts
an entry to s16.15. Input from devices, which do not belong to the network, is added after the shift.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import ONE, clamp, div, mul, scale, wrap
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


@jit
def add_arrived(cells: Cells, population: int) -> None:
    """Add the input of this tick to each synapse; no input differs from an input of 0."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    kind = cells.populations[population, kinds.SYNAPSE]
    for receptor in range(2):
        arrived, state = cells.arrived[receptor], cells.synapse_state[receptor]
        constants = cells.synapse_constants[receptor]
        for i in range(first, last):
            x = arrived[i]
            if x == 0:
                continue
            if kind == kinds.EXPONENTIAL:
                state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + scale(x, constants[kinds.INIT, i]))
            elif kind == kinds.PEAKED_ALPHA:
                state[kinds.RISE, i] = wrap(state[kinds.RISE, i] + x)
                state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + scale(x, constants[kinds.INIT, i]))
            elif kind == kinds.DELTA:
                state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + x)
            elif x > 0:
                _add_alpha(state, constants[kinds.DECAY, i], constants[kinds.GAIN, i], i, x)


@jit
def _add_alpha(state: IntArray, decay: int, gain: int, i: int, x: int) -> None:
    """Add input to the machine's alpha synapse, a line times an exponential; the earlier slope is lost."""
    exponential = wrap(scale(state[kinds.RISE, i], decay) + ONE)
    share = wrap(ONE - div(ONE, exponential)) if exponential > 0 else ONE
    state[kinds.PENDING, i] = x
    state[kinds.RISE, i] = exponential
    state[kinds.VALUE, i] = mul(wrap(state[kinds.VALUE, i] + mul(x, gain)), share)


@jit
def read_values(cells: Cells, population: int) -> None:
    """Write the value of each synapse to ``cells.value``."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    product = cells.populations[population, kinds.SYNAPSE] == kinds.ALPHA
    for receptor in range(2):
        value, state = cells.value[receptor], cells.synapse_state[receptor]
        for i in range(first, last):
            value[i] = mul(state[kinds.VALUE, i], state[kinds.RISE, i]) if product else state[kinds.VALUE, i]


@jit
def decay_synapses(cells: Cells, population: int) -> None:
    """Advance the synapses by one step."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    kind = cells.populations[population, kinds.SYNAPSE]
    for receptor in range(2):
        state, constants = cells.synapse_state[receptor], cells.synapse_constants[receptor]
        if kind == kinds.EXPONENTIAL:
            for i in range(first, last):
                state[kinds.VALUE, i] = scale(state[kinds.VALUE, i], constants[kinds.DECAY, i])
        elif kind == kinds.DELTA:
            state[kinds.VALUE, first:last] = 0
        elif kind == kinds.PEAKED_ALPHA:
            _decay_peaked(state, constants, first, last)
        else:
            _decay_alpha(state, constants, first, last)


@jit
def _decay_peaked(state: IntArray, constants: IntArray, first: int, last: int) -> None:
    for i in range(first, last):
        decay, gain, rise = constants[kinds.DECAY, i], constants[kinds.GAIN, i], state[kinds.RISE, i]
        state[kinds.VALUE, i] = wrap(scale(state[kinds.VALUE, i], decay) + scale(rise, gain))
        state[kinds.RISE, i] = scale(rise, decay)


@jit
def _decay_alpha(state: IntArray, constants: IntArray, first: int, last: int) -> None:
    for i in range(first, last):
        slope = mul(state[kinds.PENDING, i], constants[kinds.GAIN, i])
        state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + slope)
        state[kinds.RISE, i] = scale(state[kinds.RISE, i], constants[kinds.DECAY, i])
