"""One tick of the machine, and many.

The order is the machine's: input is transferred from the ring, then every neuron is updated, tested against
its threshold and its synapses decay; then the spikes go out. A spike in tick ``t`` with a delay of ``d``
ticks acts in the update of tick ``t + d``.
"""

from __future__ import annotations

from typing import NamedTuple

from nrp_brain_spinnaker import kinds
from nrp_brain_spinnaker.kinds import Cells
from nrp_brain_spinnaker.neuron_kernels import gather_currents, update_neurons
from nrp_brain_spinnaker.ring import Ring, Rows, deliver, transfer
from nrp_brain_spinnaker.stdp import StdpRows, deliver_plastic, remember
from nrp_brain_spinnaker.synapse_kernels import add_arrived, decay_synapses, read_values
from nrp_brain_spinnaker.tsodyks_markram import TsodyksRows, deliver_dynamic
from nrp_core.brain.network import IntArray
from nrp_core.jit import jit


class Machine(NamedTuple):
    """All that the compiled code works on."""

    cells: Cells
    ring: Ring
    static: Rows
    dynamic: TsodyksRows
    plastic: StdpRows


class Window(NamedTuple):
    """What enters and leaves the machine while it advances.

    Args:
        source_spikes: ticks and global ids of source cells, ascending in time, shape ``(2, n)``.
        device_input: ticks, lines and s16.15 values, ascending in time, shape ``(3, n)``.
        fired: scratch for the neurons that spike in one tick.
        spikes: ticks and global ids of other cells, with room for at least those of one tick.
        taken: how many source spikes and how much device input were used, and how many spikes came out.
    """

    source_spikes: IntArray
    device_input: IntArray
    fired: IntArray
    spikes: IntArray
    taken: IntArray


@jit
def begin_tick(cells: Cells, ring: Ring, tick: int) -> None:
    """Transfer the input of a tick; what is recorded in a tick is the state after this."""
    for population in range(cells.populations.shape[0]):
        transfer(cells, ring, population, tick)
        add_arrived(cells, population)


@jit
def finish_tick(cells: Cells, fired: IntArray) -> int:
    """Update all neurons; return how many entries of ``fired`` name one that spiked."""
    n_fired = 0
    for population in range(cells.populations.shape[0]):
        for _ in range(cells.populations[population, kinds.SUBSTEPS]):
            read_values(cells, population)
            gather_currents(cells, population)
            n_fired = update_neurons(cells, population, fired, n_fired)
            decay_synapses(cells, population)
    return n_fired


@jit
def advance(machine: Machine, window: Window, tick: int, until: int) -> int:
    """Run ticks up to ``until``, or until the room for spikes is short; return the tick reached."""
    cells, ring = machine.cells, machine.ring
    fired, taken = window.fired, window.taken
    sources, devices = window.source_spikes, window.device_input
    while tick < until and window.spikes.shape[1] - taken[2] >= fired.size:
        while taken[1] < devices.shape[1] and devices[0, taken[1]] <= tick:
            ring.device[devices[1, taken[1]]] += devices[2, taken[1]]
            taken[1] += 1
        begin_tick(cells, ring, tick)
        n_fired = finish_tick(cells, fired)
        if n_fired > 0:
            _emit(machine, window, n_fired, tick)
        while taken[0] < sources.shape[1] and sources[0, taken[0]] <= tick:
            _send(machine, sources[1, taken[0]], tick)
            taken[0] += 1
        tick += 1
    return tick


@jit
def _emit(machine: Machine, window: Window, n_fired: int, tick: int) -> None:
    """Note who fired, then let the spikes go out."""
    for k in range(n_fired):
        remember(machine.plastic, window.fired[k], tick)
    for k in range(n_fired):
        neuron, place = machine.cells.ids[window.fired[k]], window.taken[2] + k
        window.spikes[0, place], window.spikes[1, place] = tick, neuron
        _send(machine, neuron, tick)
    window.taken[2] += n_fired


@jit
def _send(machine: Machine, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) through all its synapses."""
    deliver(machine.static, machine.ring, neuron, tick)
    deliver_dynamic(machine.dynamic, machine.ring, neuron, tick)
    deliver_plastic(machine.plastic, machine.ring, neuron, tick)
