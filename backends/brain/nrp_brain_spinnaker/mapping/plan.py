"""The placement of a network on a real machine: cores, keys, memory, traffic, load and power.

Counts (cores, keys, shifts, delay slots) equal those of sPyNNaker 7.4.1; time and power are estimates from
instruction counts and the assumed rates.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt

from nrp_brain_spinnaker import hardware
from nrp_brain_spinnaker.host.delays import slots_available, slots_used
from nrp_brain_spinnaker.host.wiring import Wires, sending
from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.mapping.activity import rate_hz, spikes_per_tick
from nrp_brain_spinnaker.mapping.advice import advise
from nrp_brain_spinnaker.mapping.machine_map import MachineMap, VertexMap
from nrp_brain_spinnaker.mapping.memory import dtcm_bytes, longest_row, neuron_core_bytes, source_bytes
from nrp_brain_spinnaker.mapping.partition import Core, Vertex, place, vertices_of
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.network.data import Network


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
    """Return the power of the boards in use; a packet crosses about a side of them."""
    frames = -(-boards // hardware.BOARDS_PER_FRAME)
    around = hardware.BOX_W if boards == 1 else frames * hardware.FRAME_W
    idle = boards * hardware.IDLE_BOARD_W + around
    return idle + cores * hardware.ACTIVE_CORE_W + packets_per_s * sqrt(chips) * hardware.PACKET_HOP_J
