"""The partition of a network into cores, and the routing keys of their neurons.

Slices are contiguous and the first ones are full. A key reads, from the top: population, core of the
population, stage of a delay extension, neuron, colour (the sender's tick modulo 16).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from nrp_brain_spinnaker.hardware import (
    COLOUR_BITS,
    CORES_FOR_SYSTEM,
    CORES_FOR_SYSTEM_ON_ETHERNET_CHIP,
    CORES_PER_CHIP,
    NEURONS_PER_CORE,
)
from nrp_brain_spinnaker.hints import cells_per_core, hints_of, slices_of
from nrp_brain_spinnaker.host.delays import bits_for, slots_available, stages
from nrp_brain_spinnaker.host.wiring import Wires, sending
from nrp_brain_spinnaker.mapping.direct_sources import has_room, n_poisson, possible_sources
from nrp_brain_spinnaker.mapping.synapse_cores import synapse_cores
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.network.data import Network


@dataclass(frozen=True, slots=True)
class Core:
    """A core and its neurons.

    Args:
        chip: index of the chip, filled one after another.
        core: number of the core on the chip.
        first, last: neurons within the population, ``last`` excluded.
        key, mask: of the packets it sends, None if it sends none.
        has_synapses_alone: whether it is a synapse-only core for the next core with neurons.
    """

    chip: int
    core: int
    first: int
    last: int
    key: int | None = None
    mask: int | None = None
    has_synapses_alone: bool = False


@dataclass(frozen=True, slots=True)
class Vertex:
    """A population or a delay extension, which is placed on cores.

    Args:
        label: label of the population, ``<label>_delayed`` for an extension.
        cell_type: cell type of the population, ``DelayExtension`` for an extension.
        size: number of neurons.
        per_core: maximum number of neurons on a core.
        sends: whether its spikes have targets.
        stages: number of stages of a delay extension, else 0.
        synapse_cores: number of synapse-only cores for each core with neurons.
        direct: labels of the Poisson sources with a core for each core with neurons, on the same chip.
    """

    label: str
    cell_type: str
    size: int
    per_core: int
    sends: bool
    stages: int = 0
    synapse_cores: int = 0
    direct: tuple[str, ...] = ()

    @property
    def slices(self) -> list[tuple[int, int]]:
        """The neurons on each core."""
        return slices_of(self.size, self.per_core)

    @property
    def local_bits(self) -> int:
        """Bits of a key for the neurons of one core."""
        stage_bits = (self.stages - 1).bit_length() if self.stages else 0
        return bits_for(min(self.size, self.per_core)) + stage_bits + COLOUR_BITS

    @property
    def core_bits(self) -> int:
        """Bits of a key for the cores."""
        return (len(self.slices) - 1).bit_length()


def vertices_of(network: Network, wires: Sequence[Wires], options: SpinnakerOptions) -> list[Vertex]:
    """Return the populations in definition order, then the delay extensions for long delays."""
    senders = {one.pre for one in sending(network)}
    rewarded = {one.post for one in network.projections if one.neuromodulation is not None}
    vertices = [
        Vertex(label, p.cell_type, p.size, cells_per_core(p, options), sends=label in senders)
        if p.is_source
        else _with_synapses(network, label, wires, options, sends=label in senders, alone=label in rewarded)
        for label, p in network.populations.items()
    ]
    per_core = {label: vertex.per_core for vertex in vertices for label in vertex.direct}
    vertices = [
        replace(vertex, per_core=per_core[vertex.label], sends=False) if vertex.label in per_core else vertex
        for vertex in vertices
    ]
    for label, n_stages in _extensions(network, wires, options).items():
        size = network.populations[label].size
        vertices.append(
            Vertex(f"{label}_delayed", "DelayExtension", size, NEURONS_PER_CORE, sends=True, stages=n_stages)
        )
    return vertices


def _with_synapses(
    network: Network,
    label: str,
    wires: Sequence[Wires],
    options: SpinnakerOptions,
    *,
    sends: bool,
    alone: bool,
) -> Vertex:
    """Return a population of neurons, with the cores beside each core of them."""
    population = network.populations[label]
    onto = [part for part in wires if part.projection.post == label]
    possible = possible_sources(network, onto, options.step_us)
    hints, n = hints_of(population, options), n_poisson(network, onto)
    cores = synapse_cores(onto, hints, direct=possible, n_poisson=n, alone=alone)
    direct = possible if cores and has_room(network, onto, cores) else []
    return Vertex(
        label, population.cell_type, population.size, cells_per_core(population, options), sends=sends,
        synapse_cores=cores, direct=tuple(part.projection.pre for part in direct),
    )  # fmt: skip


def _extensions(network: Network, wires: Sequence[Wires], options: SpinnakerOptions) -> dict[str, int]:
    """Return the number of stages for the sources of long delays."""
    needed: dict[str, int] = {}
    for part in wires:
        target = network.populations[part.projection.post]
        on_core = min(target.size, cells_per_core(target, options))
        longest = int(part.ticks.max())
        if longest > slots_available(on_core):
            label = part.projection.pre
            needed[label] = max(needed.get(label, 0), stages(on_core, longest))
    return needed


def place(vertices: Sequence[Vertex], senders: Sequence[str]) -> dict[str, list[Core]]:
    """Place vertices onto chips in order and assign keys to those that send.

    Args:
        vertices: vertices in order of placement.
        senders: labels in the order of their keys.
    """
    keys = _keys([vertex for label in senders for vertex in vertices if vertex.label == label])
    placed: dict[str, list[Core]] = {vertex.label: [] for vertex in vertices}
    beside = {label for vertex in vertices for label in vertex.direct}
    chip, core = 0, CORES_FOR_SYSTEM_ON_ETHERNET_CHIP
    for vertex in (each for each in vertices if each.label not in beside):
        for index, (first, last) in enumerate(vertex.slices):
            if core + vertex.synapse_cores + len(vertex.direct) >= CORES_PER_CHIP:  # on the same chip
                chip, core = chip + 1, CORES_FOR_SYSTEM
            for _ in range(vertex.synapse_cores):
                placed[vertex.label].append(Core(chip, core, first, last, has_synapses_alone=True))
                core += 1
            for label in vertex.direct:
                placed[label].append(Core(chip, core, first, last))
                core += 1
            key, mask = keys[vertex.label][index] if vertex.label in keys else (None, None)
            placed[vertex.label].append(Core(chip, core, first, last, key, mask))
            core += 1
    return placed


def _keys(senders: Sequence[Vertex]) -> dict[str, list[tuple[int, int]]]:
    """Return key and mask of each core; all populations have a block of the size of the largest one."""
    block = max((vertex.core_bits + vertex.local_bits for vertex in senders), default=0)
    return {
        vertex.label: [
            ((index << block) | (core << vertex.local_bits), (0xFFFFFFFF << vertex.local_bits) & 0xFFFFFFFF)
            for core in range(len(vertex.slices))
        ]
        for index, vertex in enumerate(senders)
    }
