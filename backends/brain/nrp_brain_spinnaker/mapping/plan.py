"""The placement of a network on a real machine: cores, keys, memory, traffic, load and power.

Counts (cores, keys, shifts, delay slots) equal those of sPyNNaker 7.4.1; time and power are estimates from
instruction counts and the assumed rates.

Advice on the parts of a network that would not fit a machine or not keep up.

A network on a real machine, as data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np

from nrp_brain_spinnaker import hardware
from nrp_brain_spinnaker.host.wiring import Wires, sending, slots_available, slots_used
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.mapping.fidelity import rate_hz, spikes_per_tick
from nrp_brain_spinnaker.mapping.partition import (
    Core,
    Vertex,
    dtcm_bytes,
    longest_row,
    neuron_core_bytes,
    place,
    source_bytes,
    vertices_of,
)
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.network.data import Network


@dataclass(frozen=True, slots=True)
class VertexMap:
    """One population, or a delay extension, on the machine.

    Args:
        label, cell_type, size: as in the network.
        cores: its cores.
        sdram_bytes: SDRAM of each core, estimated.
        packets_per_s: packets sent by all its cores, 1/s.
        left_shifts: excitatory and inhibitory left shift; empty for sources.
        delay_slots: slots available on a core and used; empty for sources.
        dtcm_bytes: DTCM of each core, 0 for sources.
        utilisation: used fraction of a time step on the fullest core, estimated; 0 for sources.
        spikes_per_step: spikes that reach the fullest core at the assumed rates; 0 for sources.
        longest_row: largest number of synapses from one neuron into one core.
        synapse_cores: synapse-only cores of each slice.
    """

    label: str
    cell_type: str
    size: int
    cores: tuple[Core, ...]
    sdram_bytes: int
    packets_per_s: float
    left_shifts: tuple[int, ...] = ()
    delay_slots: tuple[int, ...] = ()
    dtcm_bytes: int = 0
    utilisation: float = 0.0
    spikes_per_step: float = 0.0
    longest_row: int = 0
    synapse_cores: int = 0

    @property
    def late(self) -> float:
        """Share of the fullest core's work in a step that would be late."""
        return max(0.0, 1.0 - 1.0 / self.utilisation) if self.utilisation else 0.0


@dataclass(frozen=True, slots=True)
class MachineMap:
    """A network on the machine.

    Args:
        vertices: populations in definition order, then delay extensions.
        chips, boards: numbers of used ones.
        application_cores, system_cores: numbers of used ones.
        router_entries: routing entries of the fullest chip, one for each sender that reaches it.
        packets_per_s: packets of the whole network, 1/s.
        power_w: estimated power, W.
        slowdown: factor relative to real time at which no core is late.
        advice: advice on parts that would not fit or be late.
    """

    vertices: tuple[VertexMap, ...]
    chips: int
    boards: int
    application_cores: int
    system_cores: int
    router_entries: int
    packets_per_s: float
    power_w: float
    slowdown: int
    advice: tuple[str, ...]

    @property
    def joules_per_simulated_s(self) -> float:
        """Energy of one simulated second, estimated."""
        return self.power_w * self.slowdown


def advise(maps: Sequence[VertexMap], chips: int, entries: int, packets_per_s: float) -> tuple[str, ...]:
    """Return a sentence for each problem.

    Args:
        maps: all vertices.
        chips: number of used chips.
        entries: number of routing entries of the fullest chip.
        packets_per_s: packets of the whole network, 1/s.
    """
    advice = [line for vertex in maps for line in _on_vertex(vertex)]
    if chips > hardware.LARGEST_MACHINE_CHIPS:
        advice.append(f"{chips} chips: the largest machine has {hardware.LARGEST_MACHINE_CHIPS}")
    if entries > hardware.ROUTER_ENTRIES:
        advice.append(f"{entries} routing entries: a chip has {hardware.ROUTER_ENTRIES}; merge populations")
    if packets_per_s > hardware.LINK_PACKETS_PER_S:
        advice.append(f"{packets_per_s:.3g} packets/s: a link carries {hardware.LINK_PACKETS_PER_S:.0g}")
    sdram = np.bincount(
        [core.chip for vertex in maps for core in vertex.cores],
        weights=[vertex.sdram_bytes for vertex in maps for _ in vertex.cores],
    )
    if sdram.size and sdram.max() > hardware.SDRAM_BYTES:
        needed, has = (n >> 20 for n in (int(sdram.max()), hardware.SDRAM_BYTES))
        advice.append(f"{needed} MB of SDRAM on one chip: it has {has}; use fewer neurons_per_core")
    return tuple(advice)


def _on_vertex(vertex: VertexMap) -> list[str]:
    where, row, queue = f"population '{vertex.label}'", hardware.LONGEST_ROW, hardware.QUEUED_SPIKES
    advice = []
    if vertex.left_shifts and vertex.cell_type not in hardware.UPDATE_INSTRUCTIONS:
        advice.append(f"{where}: sPyNNaker has no {vertex.cell_type} cells; the load is a rough estimate")
    if vertex.longest_row > row:
        advice.append(f"{where}: {vertex.longest_row} synapses from one neuron; a row holds {row}")
    if vertex.synapse_cores > hardware.SYNAPSE_CORES:
        advice.append(
            f"{where}: {vertex.synapse_cores} cores for the synapses of each core of neurons; a chip has "
            f"{hardware.SYNAPSE_CORES}; use fewer neurons_per_core or a time step of 1 ms"
        )
    if vertex.dtcm_bytes > hardware.DTCM_BYTES:
        advice.append(f"{where}: a core's own memory is too small; use fewer neurons_per_core")
    if vertex.spikes_per_step > queue:
        advice.append(
            f"{where}: {vertex.spikes_per_step:.0f} spikes in a time step; a core can queue {queue}"
        )
    if vertex.utilisation > hardware.BUSY:
        slower = ceil(vertex.utilisation / hardware.BUSY)
        advice.append(
            f"{where}: a core is busy for {vertex.utilisation:.0%} of a time step; run {slower} times slower "
            "(time_scale_factor) or use fewer neurons_per_core"
        )
    return advice


def map_network(
    network: Network, cells: Cells, wires: Sequence[Wires], options: SpinnakerOptions
) -> MachineMap:
    """Return the placement of a network on a machine.

    Args:
        network: the network.
        cells: its neurons with their shifts.
        wires: its projections.
        options: the options of the user.
    """
    vertices = vertices_of(network, wires, options)
    sends = {vertex.label for vertex in vertices if vertex.sends}
    senders = list(dict.fromkeys(one.pre for one in sending(network) if one.pre in sends))
    senders += [vertex.label for vertex in vertices if vertex.stages]
    placed = place(vertices, senders)
    shifts = cells.populations[:, [kinds.SHIFT_EXC, kinds.SHIFT_INH]].tolist()
    neurons = [label for label, population in network.populations.items() if not population.is_source]
    shift_of = dict(zip(neurons, map(tuple, shifts), strict=True))
    maps = tuple(
        _vertex_map(vertex, placed[vertex.label], network, wires, shift_of, options) for vertex in vertices
    )
    return _summary(maps)


def _vertex_map(
    vertex: Vertex,
    cores: Sequence[Core],
    network: Network,
    wires: Sequence[Wires],
    shift_of: dict[str, tuple[int, ...]],
    options: SpinnakerOptions,
) -> VertexMap:
    population = network.populations[vertex.label.removesuffix("_delayed") if vertex.stages else vertex.label]
    packets = rate_hz(population, options) * vertex.size * max(1, vertex.stages) if vertex.sends else 0.0
    n = min(vertex.size, vertex.per_core)
    if vertex.label not in shift_of:
        used = source_bytes(vertex.cell_type, n)
        return VertexMap(vertex.label, vertex.cell_type, vertex.size, tuple(cores), used, packets)
    onto = [part for part in wires if part.projection.post == vertex.label]
    spikes = _spikes_per_step(onto, network, options)
    longest = max((int(part.ticks.max()) for part in onto), default=0)
    return VertexMap(
        vertex.label, vertex.cell_type, vertex.size, tuple(cores),
        sdram_bytes=neuron_core_bytes(onto, n, vertex.per_core) // (1 + vertex.synapse_cores),
        packets_per_s=packets,
        left_shifts=shift_of[vertex.label],
        delay_slots=(slots_available(n), slots_used(n, longest)),
        dtcm_bytes=dtcm_bytes(onto, n, vertex.per_core),
        utilisation=_busy_us(vertex, onto, spikes, options.substeps) / options.step_us,
        spikes_per_step=sum(spikes) / max(1, vertex.synapse_cores),
        longest_row=max((longest_row(part, vertex.per_core) for part in onto), default=0),
        synapse_cores=vertex.synapse_cores,
    )  # fmt: skip


def _spikes_per_step(onto: Sequence[Wires], network: Network, options: SpinnakerOptions) -> list[float]:
    """Return the number of spikes of each projection at a core of its target in a time step."""
    pre = [network.populations[part.projection.pre] for part in onto]
    return [population.size * spikes_per_tick(population, options) for population in pre]


def _busy_us(vertex: Vertex, onto: Sequence[Wires], spikes: Sequence[float], substeps: int) -> float:
    """Return the busy time of the fullest core of a population in a time step."""
    n = min(vertex.size, vertex.per_core)
    update = hardware.UPDATE_INSTRUCTIONS.get(vertex.cell_type, max(hardware.UPDATE_INSTRUCTIONS.values()))
    instructions = update * substeps + hardware.TRANSFER_INSTRUCTIONS
    updating = n * instructions * hardware.CYCLES_PER_INSTRUCTION / hardware.CYCLES_PER_US
    receiving = 0.0
    for part, arriving in zip(onto, spikes, strict=True):
        synapses_a_row = part.projection.size / part.n_pre * n / vertex.size
        receiving += arriving * (hardware.ROW_FETCH_US + synapses_a_row * hardware.SYNAPSE_US)
    if vertex.synapse_cores:
        return max(updating, receiving / vertex.synapse_cores)
    return updating + receiving


def _summary(maps: Sequence[VertexMap]) -> MachineMap:
    cores = [core for vertex in maps for core in vertex.cores]
    chips = max((core.chip for core in cores), default=0) + 1
    boards = -(-chips // hardware.CHIPS_PER_BOARD)
    packets = sum(vertex.packets_per_s for vertex in maps)
    busiest = max((vertex.utilisation for vertex in maps), default=0.0)
    entries = sum(any(core.key is not None for core in vertex.cores) for vertex in maps)
    return MachineMap(
        vertices=tuple(maps),
        chips=chips,
        boards=boards,
        application_cores=len(cores),
        system_cores=boards * (hardware.CHIPS_PER_BOARD + 1),
        router_entries=entries,
        packets_per_s=packets,
        power_w=_power_w(len(cores), chips, boards, packets),
        slowdown=max(1, ceil(busiest / hardware.BUSY)),
        advice=advise(maps, chips, entries, packets),
    )


def _power_w(cores: int, chips: int, boards: int, packets_per_s: float) -> float:
    """Return the power of the boards in use; a packet is assumed to cross about one side of them."""
    frames = -(-boards // hardware.BOARDS_PER_FRAME)
    around = hardware.BOX_W if boards == 1 else frames * hardware.FRAME_W
    idle = boards * hardware.IDLE_BOARD_W + around
    return idle + cores * hardware.ACTIVE_CORE_W + packets_per_s * sqrt(chips) * hardware.PACKET_HOP_J
