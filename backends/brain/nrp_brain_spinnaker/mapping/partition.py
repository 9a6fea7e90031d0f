"""The partition of a network into cores, and the routing keys of their neurons.

Slices are contiguous and the first ones are full. A key reads, from the top: population, core of the
population, stage of a delay extension, neuron, colour (the sender's tick modulo 16).

Poisson sources whose spikes reach one population through the memory of a chip, without a routing key.

The software has such a core for each core of neurons, on the same chip, if the target has synapse-only cores,
and the source has no other projection.

Synapse-only cores, on the same chip as the core of their neurons.

With a time step of 1 ms or more a core has time for both; with a shorter one the software uses separate cores
for the synapses onto each slice of a population.

The memory that cores need: synaptic rows and parameters in SDRAM, ring buffers and state in DTCM.

The size of a row block is that of the software; the other needs of a core were fitted to its allocations. The
error is 1 % for lists of synapses and about 10 % for random connectors.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Final

import numpy as np

from nrp_brain_spinnaker import hardware
from nrp_brain_spinnaker.hardware import (
    COLOUR_BITS,
    CORES_FOR_SYSTEM,
    CORES_FOR_SYSTEM_ON_ETHERNET_CHIP,
    CORES_PER_CHIP,
    NEURONS_PER_CORE,
    SYNAPSE_CORES,
)
from nrp_brain_spinnaker.host.weights import binomial_quantile, connection_probability
from nrp_brain_spinnaker.host.wiring import (
    N_RECEPTORS,
    Wires,
    bits_for,
    sending,
    slots_available,
    slots_used,
    stages,
)
from nrp_brain_spinnaker.options import Hints, SpinnakerOptions, cells_per_core, hints_of, slices_of
from nrp_core.network.data import Network
from nrp_core.network.synapses import STATIC, STDP

_POISSON = "SpikeSourcePoisson"


def possible_sources(network: Network, onto: Sequence[Wires], step_us: int) -> list[Wires]:
    """Return the projections onto a population that need no routing if it has synapse-only cores."""
    outgoing = Counter(one.pre for one in sending(network))
    return [
        part for part in onto if outgoing[part.projection.pre] == 1 and _is_direct(network, part, step_us)
    ]


def _is_direct(network: Network, part: Wires, step_us: int) -> bool:
    projection = part.projection
    return (
        network.populations[projection.pre].cell_type == _POISSON
        and part.n_pre == part.post_last - part.post_first
        and projection.origin.connector == "OneToOneConnector"
        and projection.synapse_type == STATIC
        and projection.rewiring is None
        and projection.origin.delay == step_us / 1000
    )


def has_room(network: Network, onto: Sequence[Wires], synapse_cores: int) -> bool:
    """Return whether a chip has room for the cores of all Poisson sources of a population."""
    return n_poisson(network, onto) + synapse_cores + 1 < hardware.CORES_PER_CHIP - 1


def n_poisson(network: Network, onto: Sequence[Wires]) -> int:
    """Return the number of projections from Poisson sources."""
    return sum(network.populations[part.projection.pre].cell_type == _POISSON for part in onto)


_HEADER_WORDS = 3
_BASE_BYTES, _NEURON_BYTES, _FURTHER_PROJECTION_BYTES, _CONDUCTANCE_BYTES = 1300, 524.13, 5600, 8
_STATE_BYTES = 64
_ARRAY_BASE_BYTES, _POISSON_BASE_BYTES, _POISSON_BYTES, _EXTENSION_BYTES = 512, 548, 74, 520


def source_bytes(cell_type: str, n: int) -> int:
    """Return the fixed SDRAM of a core with ``n`` sources or entries of a delay extension."""
    if cell_type == "SpikeSourceArray":
        return _ARRAY_BASE_BYTES + spike_bytes_per_tick(n)
    return _POISSON_BASE_BYTES + _POISSON_BYTES * n if cell_type == "SpikeSourcePoisson" else _EXTENSION_BYTES


def spike_bytes_per_tick(n: int) -> int:
    """Return the size of one tick's spikes of ``n`` array sources, bytes: keys in packets of 64."""
    return 4 * n + 6 * -(-n // 64)


def longest_row(part: Wires, per_core: int) -> int:
    """Return the largest probable number of synapses from one neuron into one core, or the room for them."""
    rewiring = part.projection.rewiring
    room = 0 if rewiring is None else rewiring.s_max
    n_post = part.post_last - part.post_first
    probability = connection_probability(part.projection)
    if probability is not None:
        n_probable = binomial_quantile(min(n_post, per_core), probability, 1 - 1e-4 / (part.n_pre * n_post))
        return max(room, n_probable)
    slices = -(-n_post // per_core)
    places = part.projection.pre_index.astype(np.int64) * slices + part.projection.post_index // per_core
    return int(np.bincount(places).max(initial=room))


def neuron_core_bytes(wires: Sequence[Wires], n: int, per_core: int) -> int:
    """Return the SDRAM of a core of a population.

    Args:
        wires: the projections onto the population.
        n: number of its neurons on a core.
        per_core: maximum number of neurons on a core.
    """
    matrix = 0
    for part in wires:
        rows = part.n_pre * max(1, stages(n, int(part.ticks.max())))  # a delay extension sends once per stage
        block = rows * (_HEADER_WORDS + longest_row(part, per_core)) * 4
        matrix += -(-block // 16) * 16
    conductance = any(part.model.is_conductance_based for part in wires)
    further = max(len(wires) - 1, 0) * _FURTHER_PROJECTION_BYTES
    own = _BASE_BYTES + round((_NEURON_BYTES + conductance * _CONDUCTANCE_BYTES) * n)
    return matrix + own + further


def dtcm_bytes(wires: Sequence[Wires], n: int, per_core: int) -> int:
    """Return the DTCM of a neuron core: ring buffer, state, and two rows in transfer."""
    longest = max((int(part.ticks.max()) for part in wires), default=0)
    slots = slots_used(n, min(longest, slots_available(n)))
    ring = slots * N_RECEPTORS * (1 << bits_for(n)) * 2
    rows = max((longest_row(part, per_core) for part in wires), default=0)
    return ring + _STATE_BYTES * n + 2 * 4 * (_HEADER_WORDS + rows)


_SHARED_FROM_US: Final = 1000
_STATIC_EVENTS_PER_S: Final = 13e6
_PLASTIC_EVENTS_PER_S: Final = 1.4e6
"""The software's limits for one core with a plastic projection."""


def synapse_cores(
    onto: Sequence[Wires], hints: Hints, *, direct: Sequence[Wires], n_poisson: int, alone: bool = False
) -> int:
    """Return the number of synapse-only cores of each slice of a population.

    Args:
        onto: the projections onto the population.
        hints: the hints of the population.
        direct: those of them that may bypass such a core.
        n_poisson: the number of them that come from Poisson sources.
        alone: whether its synapses need such a core, as with rewards.
    """
    options = hints.options
    if hints.synapse_cores is not None:
        return hints.synapse_cores
    if any(part.projection.rewiring is not None for part in onto):
        return 1  # the software has them on one such core only
    if options.step_us >= _SHARED_FROM_US and not alone:
        return 0
    plastic = any(part.projection.synapse_type == STDP for part in onto)
    limit = _PLASTIC_EVENTS_PER_S if plastic else _STATIC_EVENTS_PER_S

    def needed(parts: Sequence[Wires]) -> int:
        rows = sum(part.n_pre * longest_row(part, options.neurons_per_core) for part in parts)
        return ceil(rows * options.spikes_per_second / limit)

    cores = needed([part for part in onto if part not in direct])
    if cores + n_poisson >= SYNAPSE_CORES:  # no room for sources of their own
        cores = needed(onto)
    return max(cores, 1) if alone else cores


@dataclass(frozen=True, slots=True)
class Core:
    """A core and its neurons.

    Args:
        chip: index of the chip; chips are filled in order.
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
    """Return a population of neurons, with the synapse cores of each neuron core."""
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
