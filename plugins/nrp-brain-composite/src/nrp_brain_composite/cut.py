"""A network, cut into the networks of the parts.

Each part has its own cells, the projections onto them, and the cells of other parts that these projections
come from, as source cells whose spikes the composite brain passes on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from itertools import permutations
from math import lcm

import numpy as np

from nrp_brain_composite.options import CompositeOptions, PartOptions
from nrp_core.brain import (
    BoolArray,
    BrainCapabilities,
    FloatArray,
    Grid,
    IntArray,
    Network,
    Population,
    Projection,
)
from nrp_core.clock import NS_PER_MS, milliseconds, nanoseconds
from nrp_core.errors import CapabilityError, NetworkError, did_you_mean


def owners_of(network: Network, options: CompositeOptions) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return the part of each population with cells, and the parts that share those which no other part has.

    Source cells belong to every part that they project to.

    Raises:
        NetworkError: a population has no part or several, or a part names none.
    """
    cells = [label for label, one in network.populations.items() if not one.is_source]
    owners: dict[str, str] = {}
    sharing = []
    for name, part in options.parts.items():
        chosen = part.populations
        if chosen is None and any(label.startswith(f"{name}.") for label in cells):
            chosen = (name,)
        if chosen is None:
            sharing.append(name)
            continue
        for label in _chosen(name, chosen, network):
            if label in cells and owners.setdefault(label, name) != name:
                raise NetworkError(f"population '{label}' is in the parts '{owners[label]}' and '{name}'")
    left = [label for label in cells if label not in owners]
    if left and not sharing:
        raise NetworkError(
            f"population '{left[0]}' is in none of the parts {_listed(options.parts)}; a part without "
            "`populations` takes the rest"
        )
    owners |= _shared(network, left, sharing, options)
    return {label: owners[label] for label in cells}, tuple(sharing)


def _shared(
    network: Network, labels: Sequence[str], sharing: Sequence[str], options: CompositeOptions
) -> dict[str, str]:
    """Return the part of each of some populations, which several parts share.

    Populations that cannot be in different parts stay together. The largest groups go first, each to the part
    with the fewest cells and synapses.
    """
    known, grid_ns = [options.parts[name].capabilities for name in sharing], resolution_ns(options) or 1
    groups, sizes = {label: {label} for label in labels}, Counter[str]()
    for label in labels:
        sizes[label] = network.populations[label].size
    for one in network.projections:
        sizes[one.post] += one.size
        if one.pre in groups and one.post in groups and not _can_be_cut(one, known, grid_ns):
            joined = groups[one.pre] | groups[one.post]
            groups |= dict.fromkeys(joined, joined)
    distinct = {id(group): group for group in groups.values()}.values()
    found, taken = dict[str, str](), dict.fromkeys(sharing, 0)
    for group in sorted(distinct, key=lambda group: -sum(sizes[label] for label in group)):
        name = min(taken, key=taken.__getitem__)
        taken[name] += sum(sizes[label] for label in group)
        found |= dict.fromkeys(group, name)
    return found


def _can_be_cut(projection: Projection, parts: Sequence[BrainCapabilities], grid_ns: int) -> bool:
    """Return whether a projection can lead from any of some parts to any other one."""
    pairs = permutations(parts, 2) if projection.size else ()
    return not projection.is_continuous and all(_usable_ns(projection, *pair) >= grid_ns for pair in pairs)


def _chosen(part: str, names: Sequence[str], network: Network) -> Iterator[str]:
    for name in names:
        found = [
            label
            for label in network.populations
            if label == name or label.startswith(f"{name}.") or fnmatchcase(label, name)
        ]
        if not found and "*" not in name:
            hint = did_you_mean(name, network.populations)
            raise NetworkError(f"part '{part}': there is no population or model '{name}'{hint}")
        yield from found


def _listed(names: Mapping[str, object]) -> str:
    return ", ".join(f"'{name}'" for name in names)


@dataclass(frozen=True, eq=False)
class Part:
    """The network of one part.

    Args:
        name: the name of the part.
        options: its options.
        network: its network.
        ids: the global id in the whole network of each cell, shape ``(network.size,)``.
        is_own: which of these it simulates; the others are source cells, shape ``(network.size,)``.
        local: the id in its network of each cell of the whole network, -1 where it has none.
        passed_on: the same, for the cells of other parts alone.
        shift_ns: how much later it gets the spikes of other parts; their delays are shorter by this.
    """

    name: str
    options: PartOptions
    network: Network
    ids: IntArray
    is_own: BoolArray
    local: IntArray
    passed_on: IntArray
    shift_ns: int

    @property
    def title(self) -> str:
        """Its name with that of its backend."""
        return self.options.title(self.name)


@dataclass(frozen=True, eq=False)
class Cut:
    """A network in parts.

    Args:
        parts: those with cells.
        owners: the part of each population with cells.
        sharing: the parts that share the populations which no other part has.
        interval_ns: time between two exchanges of spikes; None: there are none.
    """

    parts: tuple[Part, ...]
    owners: Mapping[str, str]
    sharing: tuple[str, ...]
    interval_ns: int | None


def resolution_ns(options: CompositeOptions) -> int | None:
    """Return the distance of the times at which all parts can stop, or None for any time."""
    steps = [part.capabilities.resolution_ns for part in options.parts.values()]
    known = [step for step in steps if step is not None]
    return lcm(*known) if known else None


def cut_network(network: Network, options: CompositeOptions) -> Cut:
    """Cut a network into its parts.

    Raises:
        NetworkError: the parts do not fit the network.
        CapabilityError: a projection between parts is shorter than the time between two exchanges, or
            transmits voltages.
    """
    owners, sharing = owners_of(network, options)
    between = [one for one in network.projections if _is_between(one, owners)]
    known = {name: part.capabilities for name, part in options.parts.items()}
    interval_ns = _interval_ns(between, owners, known, resolution_ns(options) or 1)
    parts = []
    for name in dict.fromkeys(owners.values()):
        shift_ns = 0 if known[name].late_spikes else interval_ns or 0
        lags_ns = {label: known[owner].spike_lag_ns for label, owner in owners.items()}
        parts.append(_part(name, options.parts[name], network, owners, shift_ns, lags_ns))
    return Cut(tuple(parts), owners, sharing, interval_ns)


def _is_between(projection: Projection, owners: Mapping[str, str]) -> bool:
    return projection.pre in owners and owners[projection.pre] != owners[projection.post]


def _interval_ns(
    between: Sequence[Projection],
    owners: Mapping[str, str],
    known: Mapping[str, BrainCapabilities],
    grid_ns: int,
) -> int | None:
    """Return the time between two exchanges: the shortest delay between parts, as far as parts can stop."""
    shortest_ns: int | None = None
    for projection in between:
        sender, receiver = owners[projection.pre], owners[projection.post]
        if projection.is_continuous:
            raise CapabilityError(
                f"projection '{projection.label}' transmits voltages from part '{sender}' to part "
                f"'{receiver}'; parts exchange only spikes: give both populations to one part"
            )
        if not projection.size:
            continue
        usable_ns = _usable_ns(projection, known[sender], known[receiver])
        if usable_ns < grid_ns:
            delay_ns = int(_delays_ns(projection.delay_ms, known[receiver]).min())
            needed_ns = delay_ns - usable_ns + grid_ns
            raise CapabilityError(
                f"projection '{projection.label}' from part '{sender}' to part '{receiver}' has a delay of "
                f"{milliseconds(delay_ns):g} ms; these parts need at least {milliseconds(needed_ns):g} ms"
            )
        shortest_ns = usable_ns if shortest_ns is None else min(shortest_ns, usable_ns)
    return None if shortest_ns is None else shortest_ns // grid_ns * grid_ns


def _usable_ns(projection: Projection, sender: BrainCapabilities, receiver: BrainCapabilities) -> int:
    """Return how late another part may learn of a spike that travels over a projection."""
    delay_ns = int(_delays_ns(projection.delay_ms, receiver).min())
    usable_ns = delay_ns - max(0, sender.spike_lag_ns - receiver.spike_lag_ns)
    if not receiver.late_spikes:  # it needs a step for the rest of the way
        usable_ns -= receiver.resolution_ns or 0
    return usable_ns


def _delays_ns(delays_ms: FloatArray, receiver: BrainCapabilities) -> IntArray:
    """Return delays as the receiving part simulates them."""
    if receiver.resolution_ns is None:
        return nanoseconds(delays_ms)
    delays: IntArray = Grid(receiver.resolution_ns).delays(delays_ms) * receiver.resolution_ns
    return delays


def _part(
    name: str, options: PartOptions, network: Network, owners: Mapping[str, str], shift_ns: int,
    lags_ns: Mapping[str, int],
) -> Part:  # fmt: skip
    onto = [one for one in network.projections if owners[one.post] == name]
    needed = {label for label, owner in owners.items() if owner == name} | {one.pre for one in onto}
    populations: dict[str, Population] = {}
    ids: list[IntArray] = []
    is_own: list[BoolArray] = []
    for label, one in network.populations.items():
        if label in needed:
            is_mine = owners.get(label) == name
            populations[label] = one if is_mine or one.is_source else _relayed(one)
            ids.append(network.ids_of(label))
            is_own.append(np.full(one.size, is_mine))
    projections = [
        _shortened(one, shift_ns + lags_ns[one.pre], options.capabilities)
        if shift_ns and _is_between(one, owners)
        else one
        for one in onto
    ]
    every, own = np.concatenate(ids), np.concatenate(is_own)
    local, passed_on = np.full((2, network.size), -1)
    local[every] = np.arange(len(every))
    foreign = ~own & ~_are_sources(every, network)
    passed_on[every[foreign]] = np.flatnonzero(foreign)
    inner = Network(populations, tuple(projections), timestep_ms=network.timestep_ms)
    return Part(name, options, inner, every, own, local, passed_on, shift_ns)


def _relayed(population: Population) -> Population:
    """Return the source cells that stand for the cells of another part."""
    return Population(
        population.label, population.size, "SpikeSourceArray", {},
        spike_times_ms=(np.empty(0),) * population.size, positions_um=population.positions_um,
    )  # fmt: skip


def _shortened(projection: Projection, by_ns: int, receiver: BrainCapabilities) -> Projection:
    delays_ns = _delays_ns(projection.delay_ms, receiver) - by_ns
    return replace(projection, delay_ms=delays_ns / NS_PER_MS)


def _are_sources(ids: IntArray, network: Network) -> BoolArray:
    found = np.zeros(network.size, np.bool_)
    for label, one in network.populations.items():
        if one.is_source:
            found[network.ids_of(label)] = True
    chosen: BoolArray = found[ids]
    return chosen
