"""One tick of the machine, and many.

The order is the machine's: synapses form and vanish; input is transferred from the ring; every neuron is
updated and compared with its threshold, and its synapses decay; then the spikes are sent. A spike in tick
``t`` with a delay of ``d`` ticks acts in the update of tick ``t + d``.
"""

from __future__ import annotations

from typing import NamedTuple

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.neuron_kernels import gather_currents, update_neurons
from nrp_brain_spinnaker.machine.rewired_rows import Rewired, deliver_rewired, emit_rewired, has_room
from nrp_brain_spinnaker.machine.rewiring import rewire
from nrp_brain_spinnaker.machine.ring import Ring, transfer
from nrp_brain_spinnaker.machine.synaptic_inputs import add_arrived, decay_synapses, read_values
from nrp_brain_spinnaker.state import Machine
from nrp_brain_spinnaker.synapses.laws import Stores, note_spike, send
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import borrowed, jit


class Window(NamedTuple):
    """The input and output of the machine during a run.

    Args:
        source_spikes: ticks and global ids of source cells, ascending in time, shape ``(2, n)``.
        device_input: ticks, lines and s16.15 values, ascending in time, shape ``(3, n)``.
        spikes: ticks and global ids of other cells, with room for at least those of one tick.
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
    """Run ticks up to ``until``, or until there is too little room for output; return the tick reached."""
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
