"""Nodes and synapses of NEST as a network in PyNN's names and units.

Cells with receptors of several time constants become cells with two.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from pyNN.standardmodels import cells as standard

from nrp_core.brain import FloatArray, IntArray, Network, Population, Projection
from nrp_core.errors import NetworkError
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.model import CELL_TYPE
from nrp_core.network.nest_models import LEAK_NS, NestParameter
from nrp_core.network.picking import CIRCUIT
from nrp_core.network.pynn.export import unique
from nrp_core.network.synapses import ELECTRICAL, STATIC, STDP, TSODYKS_MARKRAM
from nrp_pynest.equations import EQUATIONS
from nrp_pynest.equations.model import numbered, summed
from nrp_pynest.equations.receptors import alpha_current, every, exponential_current, lines_of
from nrp_pynest.kernel import Block, Group, Kernel, Node, Nodes
from nrp_pynest.models import (
    CELLS,
    CURRENT,
    CURRENTS,
    PARROT,
    POISSON,
    POISSONS,
    RECORDERS,
    SPIKE_RECORDERS,
    SPIKES,
    STATES,
    TRAINS,
    TSODYKS_CELL,
    initial_mv,
    valid_recovery_ms,
)

PLAIN: Final = {"iaf_psc_exp_multisynapse": "iaf_psc_exp", "iaf_psc_alpha_multisynapse": "iaf_psc_alpha"}
"""The models with several receptors, and those with two that are otherwise equal."""
RECEPTOR: Final = "receptor_type"
_TIMES: Final = (2.0,)
_KILO: Final = 1e-3
_SIGNS: Final = (("tau_syn_ex", 1.0), ("tau_syn_in", -1.0))


def with_two_receptors(group: Group, kernel: Kernel) -> Group | None:
    """Return a group whose cells have two receptors, and others unchanged.

    None if weights of one sign have several time constants.

    Raises:
        NetworkError: a synapse names no receptor of its target.
    """
    if group.base not in PLAIN:
        return group
    plain = as_plain(group)
    values = dict(plain.values)
    places, weights, times = _incoming(group, kernel)
    for name, factor in _SIGNS:
        chosen = weights * factor > 0
        found = _one_each(group, places[chosen], times[chosen])
        if found is None:
            return None
        values[name] = found
    return replace(plain, values=values)


def as_plain(group: Group) -> Group:
    """Return a group of such cells without their time constants."""
    values, defaults = (
        {name: one for name, one in given.items() if name != "tau_syn"}
        for given in (group.values, group.defaults)
    )
    return replace(group, base=PLAIN[group.base], values=values, defaults=defaults)


def _incoming(group: Group, kernel: Kernel) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the place of the target in the group, weight and time constant of each synapse onto it."""
    parts = list(_parts(group, kernel))
    if not parts:
        return np.empty(0, np.int64), np.empty(0), np.empty(0)
    places, weights, receptors = (np.concatenate(part) for part in zip(*parts, strict=True))
    times_of = [np.atleast_1d(one) for one in _times(group)]
    times = np.empty(len(places))
    for i, (place, receptor) in enumerate(zip(places.tolist(), receptors.tolist(), strict=True)):
        known = times_of[place]
        if not 1 <= receptor <= len(known):
            raise NetworkError(_no_receptor(group, receptor, len(known)))
        times[i] = known[int(receptor) - 1]
    return places, weights, times


def _parts(group: Group, kernel: Kernel) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    for block in kernel.blocks:
        if len(block.pre) and kernel.group_of(int(block.pre[0])).base in (*CURRENTS, *RECORDERS):
            continue
        chosen = (block.post >= group.first) & (block.post < group.first + group.size)
        receptors = block.values.get(RECEPTOR, np.zeros(len(block.post)))
        yield block.post[chosen] - group.first, block.values["weight"][chosen], receptors[chosen]


def _times(group: Group) -> list[Any]:
    """Return the time constants of the receptors of each cell, ms."""
    given = group.values.get("tau_syn", [np.nan] * group.size)
    default = group.defaults.get("tau_syn", _TIMES)
    return [default if np.ndim(one) == 0 and np.isnan(one) else one for one in given]


def _one_each(group: Group, places: IntArray, times: FloatArray) -> list[float] | None:
    """Return the time constant of the weights of one sign for each cell, ms; None if there are several."""
    found = np.array([float(np.atleast_1d(one)[0]) for one in _times(group)])
    found[places] = times
    return list(map(float, found)) if (found[places] == times).all() else None


def network_of(kernel: Kernel, variables: Mapping[str, Any]) -> Network:
    """Return the network.

    A Poisson generator sends each target a separate train, as in NEST: each of its synapses gets a source. A
    parrot neuron, which sends the same spikes to all targets, is a cell.

    Args:
        kernel: the kernel with the nodes and synapses.
        variables: variables of the file; those with nodes become views.

    Raises:
        NetworkError: it is inconsistent.
    """
    made = Conversion(kernel)
    return replace(made.network, views=made.views(variables))


@dataclass(frozen=True, slots=True)
class Link:
    """Synapses from one group to another: indices within them, values, and places in their block."""

    source: Group
    target: Group
    pre: IntArray
    post: IntArray
    values: Mapping[str, FloatArray]
    kind: str
    block: Block
    places: Any


class Conversion:
    """The contents of a kernel as a network.

    Args:
        kernel: the kernel with the nodes and synapses.

    Attributes:
        ids: the neurons of nodes, by their numbers.
        sources: the sources of spikes of Poisson generators, one for each synapse, by their numbers.
        places: for each projection, the block and the indices of its synapses there, and the factor from
            NEST's unit to the network's.
        heard: the sources of Poisson generators that each recorder of spikes records.
        current_links: the synapses from generators of currents to cells.
        network: the network, without these currents.
    """

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._links = list(_links(kernel))
        self._populations: dict[str, Population] = {}
        self._projections: list[Projection] = []
        self._labels: dict[int, str] = {}
        self.ids: dict[int, int] = {}
        self.sources: dict[int, list[int]] = {}
        self.places: list[tuple[Block, IntArray, float]] = []
        self.current_links: list[Link] = []
        self.heard: dict[int, list[int]] = {}
        self._repeaters: set[int] = set()
        self._ported: set[int] = set()
        self._gaps: dict[tuple[str, str], list[Link]] = {}
        self.network = self._made()

    def _made(self) -> Network:
        groups = [group for group in self._kernel.groups if group.base in (*CELLS, *TRAINS)]
        for group, label in zip(groups, unique(group.model for group in groups), strict=True):
            self._add(group, label)
        for link in self._links:
            self._connect(link)
        self._join_gaps()
        resolution = float(self._kernel.status["resolution"])
        return Network(self._populations, tuple(self._projections), timestep_ms=resolution)

    @property
    def _n_cells(self) -> int:
        return sum(population.size for population in self._populations.values())

    def _add(self, group: Group, label: str) -> None:
        first = self._n_cells
        self.ids |= {group.first + i: first + i for i in range(group.size)}
        self._labels[group.first] = label
        if group.base == PARROT and (links := self._generators_of(group)):
            self._populations[label] = self._repeated(group, label, links, first)
        elif group.base in CELLS:
            cells, currents = with_two_receptors(group, self._kernel), self._currents(group)
            if cells is None:
                self._ported.add(group.first)
                cells = as_plain(group)
            made = cells_from(cells, label, currents)
            self._populations[label] = with_ports(made, group) if group.first in self._ported else made
        else:
            times = tuple(trains_of(group, self._kernel.random))
            self._populations[label] = Population(label, group.size, "SpikeSourceArray", {}, {}, times)

    def _generators_of(self, group: Group) -> list[Link]:
        """Return the synapses onto parrots whose only input is one Poisson generator each, else nothing."""
        links = [link for link in self._links if link.target is group]
        sources = {link.source.base for link in links}
        posts = np.concatenate([np.empty(0, np.int64), *(link.post for link in links)])
        counts = np.bincount(posts, minlength=group.size)
        is_plain = sources == {POISSON} and (counts == 1).all() and not self._kernel.is_lenient
        return links if is_plain else []

    def _repeated(self, group: Group, label: str, links: list[Link], first: int) -> Population:
        """Return such parrots as sources; a cell could not repeat several spikes of one step."""
        self._repeaters.add(group.first)
        values = {name: np.zeros(group.size) for name in ("rate", "start", "duration")}
        for link in links:
            given = trains_at(link.source, link.pre)
            given["start"] = given["start"] + link.values["delay"]
            for name, column in given.items():
                values[name][link.post] = column
            for place, cell in zip(link.pre.tolist(), link.post.tolist(), strict=True):
                self.sources.setdefault(link.source.first + place, []).append(first + cell)
        return Population(label, group.size, "SpikeSourcePoisson", values)

    def _currents(self, group: Group) -> FloatArray:
        """Return the constant current that generators send into each cell, nA.

        Only a lenient kernel has such: elsewhere a current has a start and can change, see :attr:`currents`.
        """
        currents = np.zeros(group.size)
        if not self._kernel.is_lenient:
            return currents
        for link in self._links:
            if link.target is group and link.source.base == CURRENT:
                sent = link.source.column("amplitude", 0.0)[link.pre] * link.values["weight"] * 1e-3
                np.add.at(currents, link.post, sent)
        return currents

    def _connect(self, link: Link) -> None:
        source, target, pre = link.source, link.target, link.pre
        if target.base not in CELLS:
            if source.base in POISSONS and target.base in SPIKE_RECORDERS:
                first = self._n_cells
                self._own_sources(source, pre)
                for i, place in enumerate(link.post.tolist()):
                    self.heard.setdefault(target.first + place, []).append(first + i)
            return
        if target.first in self._repeaters:
            return
        if source.base in POISSONS:
            label = self._own_sources(source, pre)
            pre = np.arange(len(pre))
        elif source.first in self._labels:
            label = self._labels[source.first]
        else:
            if source.base in CURRENTS:
                self.current_links.append(link)
            return
        if link.kind == ELECTRICAL:
            self._gaps.setdefault((self._labels[source.first], self._labels[target.first]), []).append(link)
            return
        for receptor, chosen in receptors_of(link, has_ports=target.first in self._ported):
            values = {name: column[chosen] for name, column in link.values.items()}
            self._project(label, receptor, pre[chosen], link.post[chosen], values, link)
            conducts = self._populations[self._labels[target.first]].is_conductance_based
            sign = -1.0 if conducts and receptor == "inhibitory" else 1.0
            scale = sign * CELLS[target.base].weight_scale
            places = chosen if isinstance(link.places, slice) else link.places[chosen]
            self.places.append((link.block, places, scale))

    def _join_gaps(self) -> None:
        """Add gap junctions, each of which NEST creates in both directions."""
        for (pre, post), links in self._gaps.items():
            pre_index, post_index, weight = half_of(links, has_other=pre == post or (post, pre) in self._gaps)
            if not len(weight):
                continue
            label = unique([*(one.label for one in self._projections), f"{pre}—{post} electrical"])[-1]
            ends = pre_index.astype(np.int32), post_index.astype(np.int32)
            self._projections.append(
                Projection(
                    label, pre, post, "excitatory", ends[0], ends[1], weight * _KILO, np.zeros(len(weight)),
                    ELECTRICAL,
                )
            )  # fmt: skip
            block = Block(
                "gap_junction", links[0].block.base, pre_index, post_index, {"weight": weight}, self._kernel
            )
            self.places.append((block, np.arange(len(weight)), _KILO))

    def _own_sources(self, source: Group, pre: IntArray) -> str:
        label = unique([*self._populations, source.model])[-1]
        first = self._n_cells
        for i, place in enumerate(pre.tolist()):
            self.sources.setdefault(source.first + place, []).append(first + i)
        parameters, kind = trains_at(source, pre), "SpikeSourcePoisson"
        if "dead_time" in source.defaults and source.column("dead_time", 0.0).any():
            kind, parameters["tau_refrac"] = f"{kind}Refractory", source.column("dead_time", 0.0)[pre]
        self._populations[label] = Population(label, len(pre), kind, parameters)
        return label

    def _project(
        self, pre: str, receptor: str, pre_index: IntArray, post_index: IntArray,
        values: Mapping[str, FloatArray], link: Link,
    ) -> None:  # fmt: skip
        post, scale = self._labels[link.target.first], CELLS[link.target.base].weight_scale
        conducts = self._populations[post].is_conductance_based
        sign = -1.0 if conducts and receptor == "inhibitory" else 1.0
        weight, delay_ms = _scaled(values["weight"], sign * scale), _scaled(values["delay"], 1.0)
        if link.kind == STDP:
            values = {**values, "tau_minus": link.target.column("tau_minus", 20.0)[post_index]}
        kind, values, state = with_plasticity_of_source(link, values, pre_index)
        kind, parameters, plasticity = plasticity_of(kind, values, scale, is_lenient=self._kernel.is_lenient)
        label = unique([*(one.label for one in self._projections), f"{pre}→{post} {receptor}"])[-1]
        self._projections.append(
            Projection(
                label, pre, post, receptor, pre_index.astype(np.int32), post_index.astype(np.int32),
                weight, delay_ms, kind, parameters, plasticity, initial_values=state,
            )
        )  # fmt: skip

    def views(self, variables: Mapping[str, Any]) -> dict[str, IntArray]:
        """Return the neurons in variables of a file."""
        named = {name: value for name, value in variables.items() if not name.startswith("_")}
        circuit = named.get(CIRCUIT)
        if isinstance(circuit, Mapping):
            named |= {str(name): nodes for name, nodes in circuit.items()}
        elif isinstance(circuit, (list, tuple)):
            named[CIRCUIT] = Nodes.of(self._kernel, [int(node) for node in circuit])
        found = {name: self.cells_of(value) for name, value in named.items()}
        return {name: ids for name, ids in found.items() if ids is not None}

    def cells_of(self, value: Any) -> IntArray | None:
        """Return the neurons in a value, None if it is not a collection of nodes with neurons."""
        ids = [self.ids[node] for node in nodes_in(value) if node in self.ids]
        return np.array(ids, dtype=np.int64) if ids else None


def _links(kernel: Kernel) -> Iterator[Link]:
    """Yield the synapses of each block from one group to another."""
    starts = [group.first for group in kernel.groups]
    for block in kernel.blocks:
        for source, target, chosen in by_ends(block, starts):
            pre, post = block.pre[chosen] - starts[source], block.post[chosen] - starts[target]
            values = {name: column[chosen] for name, column in block.values.items()}
            ends_of = kernel.groups[source], kernel.groups[target]
            if ends_of[0].base == SPIKES and "spike_weights" in {**ends_of[0].defaults, **ends_of[0].values}:
                values["weight"] = values["weight"] * spike_weights(ends_of[0])[pre]
            yield Link(*ends_of, pre, post, values, block.base.kind, block, chosen)


def spike_weights(group: Group) -> FloatArray:
    """Return the factor by which each spike generator multiplies the weights of its synapses.

    Raises:
        NetworkError: it differs between the spikes of a generator.
    """
    given = group.values.get("spike_weights", [group.defaults.get("spike_weights", ())] * group.size)
    rows = [np.unique(np.asarray(one, float)) for one in given]
    for row in rows:
        if len(row) > 1:
            raise NetworkError(
                f"nest: 'spike_weights' of '{group.model}' are {row[0]:g} and {row[1]:g}; here they must be "
                "equal for all spikes of a generator"
            )
    return np.array([row[0] if len(row) else 1.0 for row in rows])


def cells_from(group: Group, label: str, current_na: FloatArray) -> Population:
    """Return the nodes of a group as a population.

    Args:
        group: nodes of a model of cells.
        label: the label of the population.
        current_na: a constant current into each.
    """
    if group.base in EQUATIONS:
        return _equation_cells(group, label)
    model, base = CELLS[group.base], getattr(standard, CELLS[group.base].cell_type)
    parameters = {
        name: _parameter(group, model.parameters.get(name, NestParameter(name, 1.0, default)))
        for name, default in base.default_parameters.items()
    }
    if group.base in LEAK_NS:
        parameters["tau_m"] = parameters["cm"] * 1e3 / group.column("g_L", LEAK_NS[group.base])
    parameters["i_offset"] = parameters["i_offset"] + current_na
    initial = {name: np.full(group.size, value) for name, value in base.default_initial_values.items()}
    initial["v"] = group.column("V_m", initial_mv(group.base))
    for name, (own, scale) in STATES.items():
        if own != "v" and name in {*group.values, *group.defaults} and own in initial:
            initial[own] = group.column(name, 0.0) * scale
    return Population(label, group.size, model.cell_type, parameters, initial)


_UNITS: Final = {"cm": "nF", "i_offset": "nA"} | dict.fromkeys(("v_rest", "v_reset", "v_thresh"), "mV")


def with_ports(cells: Population, group: Group) -> Population:
    """Return leaky cells as cells in equations that have a receptor for each time constant of their group."""
    times = _lists(group, "tau_syn")
    kind = exponential_current if cells.cell_type == "IF_curr_exp" else alpha_current
    names = numbered(times.shape[1])
    receptors = every(kind, names)
    given = {
        name: one for name, one in cells.parameters.items() if name not in ("tau_syn_E", "tau_syn_I")
    } | {f"tau_syn_{name}": times[:, k] for k, name in enumerate(names)}
    equations = CellEquations(
        equations=lines_of(receptors.values()).replace(": pA", ": nA")
        + f"\ndv/dt = (v_rest - v)/tau_m + ({summed('I_syn', len(names), 'nA')} + i_offset)/cm : mV "
        "(unless refractory)",
        threshold="v >= v_thresh",
        reset="v = v_reset",
        refractory="tau_refrac",
        receptors={name: one.effect for name, one in receptors.items()},
        units={name: _UNITS.get(name, "ms") for name in given},
    )
    initial = {name: np.zeros(cells.size) for name in equations.model.variables}
    initial["v"] = cells.initial_values["v"]
    return replace(cells, cell_type=CELL_TYPE, parameters=given, initial_values=initial, equations=equations)


def _equation_cells(group: Group, label: str) -> Population:
    model = EQUATIONS[group.base]
    lists = {name: _lists(group, name) for name in model.lists}
    cell = model.cell_of({name: table.shape[1] for name, table in lists.items()})
    given = {name: group.column(name, value) for name, value in model.numbers.items() if name != "i_offset"}
    given |= {f"{name}_{k + 1}": table[:, k] for name, table in lists.items() for k in range(table.shape[1])}
    given |= {"i_offset": group.column("I_e", 0.0), **model.derive(given)}
    initial = {
        name: given[name]
        if name in given
        else group.column(nest := _NEST_NAMES.get(name, name), model.initial.get(nest, 0.0))
        for name in cell.model.variables
    }
    parameters = {name: given[name] for name in cell.units}
    return Population(label, group.size, CELL_TYPE, parameters, initial, equations=cell)


_NEST_NAMES: Final = dict.fromkeys(("v", "now", "before"), "V_m")
"""The variables of equations that have other names in NEST."""


def _lists(group: Group, name: str) -> FloatArray:
    """Return a parameter that is a list, one row for each cell.

    Raises:
        NetworkError: the lists of the cells have different lengths.
    """
    default = group.defaults.get(name, _TIMES)
    rows = [default if np.ndim(one) == 0 else one for one in group.values.get(name, [default] * group.size)]
    lengths = sorted({len(row) for row in rows})
    if len(lengths) > 1:
        raise NetworkError(
            f"nest: the lists '{name}' of '{group.model}' have {lengths[0]} and {lengths[-1]} elements "
            "in one call of Create; create cells with different lengths by several calls"
        )
    return np.array(rows, dtype=float).reshape(group.size, lengths[0])


def _parameter(group: Group, parameter: NestParameter) -> FloatArray:
    if parameter.name in ("tau_syn_ex", "tau_syn_in") and "tau_syn" in {**group.values, **group.defaults}:
        return group.column("tau_syn", parameter.default)
    return np.asarray(group.column(parameter.name, parameter.default) * parameter.scale)


def _scaled(values: FloatArray, factor: float) -> FloatArray:
    """Return values times a factor; equal values that share memory still do."""
    if values.strides == (0,) and len(values):
        return np.broadcast_to(values[:1] * factor, values.shape)
    return np.asarray(values * factor)


def trains_of(group: Group, random: np.random.RandomState) -> list[FloatArray]:
    """Return the spike times of generators, ms, ascending; those of pulse packets are drawn once."""
    default = group.defaults.get("spike_times", ())
    if "pulse_times" in group.defaults and "spike_times" not in group.values:
        group.values["spike_times"] = [_packets(group, place, random) for place in range(group.size)]
    trains = group.values.get("spike_times", [default] * group.size)
    return [np.sort(np.asarray(train, float).ravel()) for train in trains]


def _packets(group: Group, place: int, random: np.random.RandomState) -> FloatArray:
    own = {name: (group.values[name][place] if name in group.values else value)
           for name, value in group.defaults.items()}  # fmt: skip
    activity, sdev = int(own["activity"]), float(own["sdev"])
    drawn = [random.normal(0.0, sdev, activity) + pulse if sdev else np.full(activity, pulse)
             for pulse in np.asarray(own["pulse_times"], float)]  # fmt: skip
    times = np.concatenate([np.empty(0), *drawn])
    return times[times > 0]


def trains_at(group: Group, generators: IntArray) -> dict[str, FloatArray]:
    """Return the parameters of a Poisson source for each of these generators, which may be repeated."""
    origin = group.column("origin", 0.0)[generators]
    start = group.column("start", 0.0)[generators] + origin
    lasts = np.minimum(group.column("stop", np.inf)[generators] + origin, 1e10) - start
    return {"rate": group.column("rate", 0.0)[generators], "start": start, "duration": lasts}


def by_ends(block: Block, starts: Sequence[int]) -> Iterator[tuple[int, int, Any]]:
    """Yield the synapses from one group to another: the places of both groups, and the index of the synapses.

    Args:
        block: the synapses.
        starts: the first node of each group, ascending.
    """
    first, last = (
        np.searchsorted(starts, [nodes.min(initial=2**62), nodes.max(initial=-1)], "right") - 1
        for nodes in (block.pre, block.post)
    )
    if not len(block.pre):
        return
    if first[0] == first[1] and last[0] == last[1]:  # most calls connect one group with another
        yield int(first[0]), int(last[0]), slice(None)
        return
    ends = [np.searchsorted(starts, nodes, "right") - 1 for nodes in (block.pre, block.post)]
    pairs = ends[0] * len(starts) + ends[1]
    for pair in np.unique(pairs).tolist():
        yield *divmod(pair, len(starts)), np.flatnonzero(pairs == pair)


def by_receptor(weight: FloatArray) -> Iterator[tuple[str, Any]]:
    """Yield the receptors of positive and of negative weights, as far as they occur, with their indices."""
    if not len(weight):
        return
    if (weight >= 0).all() or (weight < 0).all():
        yield "inhibitory" if weight[0] < 0 else "excitatory", slice(None)
        return
    is_negative = weight < 0
    for receptor, chosen in (("excitatory", ~is_negative), ("inhibitory", is_negative)):
        if chosen.any():
            yield receptor, chosen


def half_of(links: Sequence[Link], *, has_other: bool) -> tuple[IntArray, IntArray, FloatArray]:
    """Return one of the two directions of gap junctions: indices of both ends, and weights.

    Args:
        links: the junctions from one group to another.
        has_other: whether there are junctions back.

    Raises:
        NetworkError: a junction exists only in one direction.
    """
    pre, post = (np.concatenate([getattr(one, end) for one in links]) for end in ("pre", "post"))
    source, target = links[0].source, links[0].target
    kept = pre + source.first < post + target.first
    if not has_other or (source is target and 2 * kept.sum() != (pre != post).sum()):
        raise NetworkError(
            f"nest: a gap junction from '{source.model}' to '{target.model}' exists in one direction only; "
            "connect both, or use 'make_symmetric'"
        )
    return pre[kept], post[kept], np.concatenate([one.values["weight"] for one in links])[kept]


def with_plasticity_of_source(
    link: Link, values: Mapping[str, FloatArray], pre_index: IntArray
) -> tuple[str, Mapping[str, FloatArray], dict[str, FloatArray]]:
    """Return the kind, the values and the state at time 0 of synapses.

    Cells of ``iaf_tum_2000`` have the short-term plasticity of their synapses with receptor type 1.

    Raises:
        NetworkError: such a cell fires at random.
    """
    source = link.source
    if source.base != TSODYKS_CELL or not (values.get(RECEPTOR, np.zeros(1)) == 1).all():
        return link.kind, values, {}
    if source.column("delta", 0.0).any():
        raise NetworkError("nest: 'delta' of iaf_tum_2000, by which it fires at random, must be 0 here")
    own = {name: source.column(name, 0.0)[pre_index] for name in ("U", "tau_rec", "tau_fac", "x", "y", "u")}
    state = {"u": own["u"], "y": own["y"], "z": 1.0 - own["x"] - own["y"]}
    return TSODYKS_MARKRAM, {**values, **own}, state


def receptors_of(link: Link, *, has_ports: bool) -> Iterator[tuple[str, Any]]:
    """Yield the receptors of synapses, as far as they occur, with the indices of the synapses.

    Args:
        link: the synapses.
        has_ports: whether the target has a receptor for each time constant, see :func:`with_ports`.

    Raises:
        NetworkError: a synapse names a receptor that its target does not have.
    """
    model = EQUATIONS.get(link.target.base)
    if has_ports:
        n = _lists(link.target, "tau_syn").shape[1]
    elif model is None or not (model.ports or model.n_ports):
        yield from by_receptor(link.values["weight"])
        return
    else:
        n = _lists(link.target, model.ports).shape[1] if model.ports else model.n_ports
    numbers = link.values.get(RECEPTOR, np.zeros(len(link.pre)))
    for number in np.unique(numbers).tolist():
        if not 1 <= number <= n:
            raise NetworkError(_no_receptor(link.target, number, n))
        yield f"receptor{number:g}", np.flatnonzero(numbers == number)


def _no_receptor(group: Group, number: float, n: int) -> str:
    named = f"receptor {number:g}" if number else "no receptor"
    return f"nest: a synapse onto '{group.model}' names {named}; receptor_type must be 1 to {n}"


def nodes_in(value: Any) -> Sequence[Node]:
    """Return the nodes of a value; none if it is not a node or a collection of nodes."""
    nodes = [value] if isinstance(value, Node) else value
    are_nodes = isinstance(nodes, (list, tuple)) and all(isinstance(one, Node) for one in nodes)
    return nodes if are_nodes else ()


def plasticity_of(
    kind: str, values: Mapping[str, FloatArray], scale: float, *, is_lenient: bool = True
) -> tuple[str, dict[str, FloatArray], dict[str, str]]:
    """Return the plasticity of synapses: kind, parameters of each, and the names of the rules.

    Args:
        kind: the synapse type of their model.
        values: their values in NEST's names and units, ``tau_minus`` of their targets among them.
        scale: the factor from NEST's unit of weights.
        is_lenient: whether STDP that has no equivalent is left out.

    Raises:
        NetworkError: it has none.
    """
    if kind == TSODYKS_MARKRAM:
        return kind, dict(_tsodyks(values)), {}
    if kind != STDP:
        return STATIC, {}, {}
    mus = {float(one) for name in ("mu_plus", "mu_minus") for one in np.unique(values[name])}
    fits = (values["weight"] >= 0).all() and (values["Wmax"] > 0).all()
    if not is_lenient and not (fits and mus in ({0.0}, {1.0})):
        raise NetworkError(
            "nest: STDP needs weights from 0 on, a positive Wmax, and mu_plus and mu_minus both 0 or both 1; "
            f"here mu is {sorted(mus)}"
        )
    if not fits:
        return STATIC, {}, {}
    additive = not values["mu_plus"].any()
    rate = values["lambda"]
    parameters = {
        "tau_plus": values["tau_plus"], "tau_minus": values.get("tau_minus", np.full_like(rate, 20.0)),
        "A_plus": rate, "A_minus": rate * values["alpha"],
        "w_min": np.zeros_like(rate), "w_max": values["Wmax"] * scale,
        "dendritic_delay_fraction": np.ones_like(rate),
    }  # fmt: skip
    dependence = f"{'Additive' if additive else 'Multiplicative'}WeightDependence"
    return kind, parameters, {"timing_dependence": "SpikePairRule", "weight_dependence": dependence}


def _tsodyks(values: Mapping[str, FloatArray]) -> Iterator[tuple[str, FloatArray]]:
    for name, spelling in (("U", "U"), ("tau_rec", "tau_rec"), ("tau_facil", "tau_fac")):
        yield name, valid_recovery_ms(values[spelling]) if name == "tau_rec" else values[spelling].copy()
