"""Nodes and synapses of NEST as a network in PyNN's names and units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pyNN.standardmodels import cells as standard

from nrp_core.brain.network import (
    STATIC,
    STDP,
    TSODYKS_MARKRAM,
    FloatArray,
    IntArray,
    Network,
    Population,
    Projection,
)
from nrp_core.brain.picking import CIRCUIT
from nrp_core.brain.pynn.export import unique
from nrp_core.brain.sonata.models import LEAK_NS, Parameter
from nrp_legacy.nest.kernel import Group, Kernel, Node, Nodes
from nrp_legacy.nest.models import CELLS, CURRENT, PARROT, POISSON, SPIKES

_INITIAL_MV = {"izhikevich": -65.0, "hh_cond_exp_traub": -60.0}


def network_of(kernel: Kernel, variables: Mapping[str, Any]) -> Network:
    """Return what was made.

    A Poisson generator sends every target a train of its own, as in NEST: each of its synapses gets a source.
    A parrot repeats the generator before it to all.

    Args:
        kernel: has it.
        variables: of the file; those that hold nodes become views.

    Raises:
        NetworkError: it contradicts itself.
    """
    return _Network(kernel).made(variables)


@dataclass(frozen=True, slots=True)
class Link:
    """Synapses from one group to another: indices within them, and values, one a synapse."""

    source: Group
    target: Group
    pre: IntArray
    post: IntArray
    values: Mapping[str, FloatArray]
    kind: str


class _Network:
    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._links = list(_links(kernel))
        self._populations: dict[str, Population] = {}
        self._projections: list[Projection] = []
        self._labels: dict[int, str] = {}
        self._ids: dict[int, int] = {}

    def made(self, variables: Mapping[str, Any]) -> Network:
        groups = [group for group in self._kernel.groups if group.base in (*CELLS, SPIKES, PARROT)]
        for group, label in zip(groups, unique(group.model for group in groups), strict=True):
            self._add(group, label)
        for link in self._links:
            self._connect(link)
        return Network(
            self._populations, tuple(self._projections), self._views(variables),
            timestep_ms=float(self._kernel.status["resolution"]),
        )  # fmt: skip

    def _add(self, group: Group, label: str) -> None:
        first = sum(population.size for population in self._populations.values())
        self._ids |= {group.first + i: first + i for i in range(group.size)}
        self._labels[group.first] = label
        if group.base in CELLS:
            self._populations[label] = _cells(group, label, self._currents(group))
        elif group.base == SPIKES:
            trains = group.values.get("spike_times", [()] * group.size)
            times = tuple(np.sort(np.asarray(train, float).ravel()) for train in trains)
            self._populations[label] = Population(label, group.size, "SpikeSourceArray", {}, {}, times)
        else:
            self._populations[label] = self._parrots(group, label)

    def _currents(self, group: Group) -> FloatArray:
        """Return the constant current that generators send into each cell, nA."""
        currents = np.zeros(group.size)
        for link in self._links:
            if link.target is group and link.source.base == CURRENT:
                sent = link.source.column("amplitude", 0.0)[link.pre] * link.values["weight"] * 1e-3
                np.add.at(currents, link.post, sent)
        return currents

    def _parrots(self, group: Group, label: str) -> Population:
        """Return parrots as sources with the rate of the generators before them."""
        rates = np.zeros(group.size)
        for link in (link for link in self._links if link.target is group):
            if link.source.base == POISSON:
                np.add.at(rates, link.post, link.source.column("rate", 0.0)[link.pre])
            else:
                self._kernel.note(f"parrots do not repeat {link.source.model} here")
        return _poisson(label, rates, np.zeros(group.size), np.full(group.size, 1e10))

    def _connect(self, link: Link) -> None:
        source, target, pre = link.source, link.target, link.pre
        if target.base not in CELLS:
            return
        if source.base == POISSON:
            label = self._own_sources(source, pre)
            pre = np.arange(len(pre))
        elif source.first in self._labels:
            label = self._labels[source.first]
        else:
            return
        is_negative = link.values["weight"] < 0
        for receptor, chosen in (("excitatory", ~is_negative), ("inhibitory", is_negative)):
            if chosen.any():
                values = {name: column[chosen] for name, column in link.values.items()}
                self._project(label, receptor, pre[chosen], link.post[chosen], values, link)

    def _own_sources(self, source: Group, pre: IntArray) -> str:
        label = unique([*self._populations, source.model])[-1]
        rate, start = source.column("rate", 0.0)[pre], source.column("start", 0.0)[pre]
        lasts = np.minimum(source.column("stop", np.inf)[pre], 1e10) - start
        self._populations[label] = _poisson(label, rate, start, lasts)
        return label

    def _project(
        self, pre: str, receptor: str, pre_index: IntArray, post_index: IntArray,
        values: Mapping[str, FloatArray], link: Link,
    ) -> None:  # fmt: skip
        post, scale = self._labels[link.target.first], CELLS[link.target.base].weight_scale
        weight = values["weight"] * scale
        conducts = self._populations[post].is_conductance_based
        kind, parameters, plasticity = _changing(link.kind, values, scale)
        label = unique([*(one.label for one in self._projections), f"{pre}→{post} {receptor}"])[-1]
        self._projections.append(
            Projection(
                label, pre, post, receptor, pre_index.astype(np.int32), post_index.astype(np.int32),
                np.abs(weight) if conducts else weight, values["delay"].copy(), kind, parameters, plasticity,
            )
        )  # fmt: skip

    def _views(self, variables: Mapping[str, Any]) -> dict[str, IntArray]:
        named = {name: value for name, value in variables.items() if not name.startswith("_")}
        circuit = named.get(CIRCUIT)
        if isinstance(circuit, Mapping):
            named |= {str(name): nodes for name, nodes in circuit.items()}
        elif isinstance(circuit, (list, tuple)):
            named[CIRCUIT] = Nodes.of(self._kernel, [int(node) for node in circuit])
        views: dict[str, IntArray] = {}
        for name, value in named.items():
            nodes = [value] if isinstance(value, Node) else value
            if isinstance(nodes, (list, tuple)) and nodes and all(isinstance(node, Node) for node in nodes):
                ids = [self._ids[node] for node in nodes if node in self._ids]
                views |= {name: np.array(ids, dtype=np.int64)} if ids else {}
        return views


def _links(kernel: Kernel) -> Iterator[Link]:
    """Yield the synapses of each block from one group to another."""
    starts = [group.first for group in kernel.groups]
    for block in kernel.blocks:
        ends = np.stack([np.searchsorted(starts, nodes, "right") - 1 for nodes in (block.pre, block.post)])
        for source, target in np.unique(ends, axis=1).T.tolist():
            chosen = np.flatnonzero((ends[0] == source) & (ends[1] == target))
            pre, post = block.pre[chosen] - starts[source], block.post[chosen] - starts[target]
            values = {name: column[chosen] for name, column in block.values.items()}
            yield Link(kernel.groups[source], kernel.groups[target], pre, post, values, block.base.kind)


def _cells(group: Group, label: str, current_na: FloatArray) -> Population:
    model, base = CELLS[group.base], getattr(standard, CELLS[group.base].cell_type)
    parameters = {
        name: _parameter(group, model.parameters.get(name, Parameter(name, 1.0, default)))
        for name, default in base.default_parameters.items()
    }
    if group.base in LEAK_NS:
        parameters["tau_m"] = parameters["cm"] * 1e3 / group.column("g_L", LEAK_NS[group.base])
    parameters["i_offset"] = parameters["i_offset"] + current_na
    initial = {name: np.full(group.size, value) for name, value in base.default_initial_values.items()}
    rest = parameters["v_rest"] if "v_rest" in parameters else np.full(group.size, _INITIAL_MV[group.base])
    given = group.column("V_m", np.nan) if "V_m" in {**group.values, **group.defaults} else rest
    initial["v"] = np.where(np.isnan(given), rest, given)
    return Population(label, group.size, model.cell_type, parameters, initial)


def _parameter(group: Group, parameter: Parameter) -> FloatArray:
    if parameter.name in ("tau_syn_ex", "tau_syn_in") and "tau_syn" in {**group.values, **group.defaults}:
        return group.column("tau_syn", parameter.default)
    return np.asarray(group.column(parameter.name, parameter.default) * parameter.scale)


def _poisson(label: str, rate: FloatArray, start: FloatArray, duration: FloatArray) -> Population:
    parameters = {"rate": rate, "start": start, "duration": duration}
    return Population(label, len(rate), "SpikeSourcePoisson", parameters)


def _changing(
    kind: str, values: Mapping[str, FloatArray], scale: float
) -> tuple[str, dict[str, FloatArray], dict[str, str]]:
    """Return how synapses change: kind, parameters, and the names of the rules."""
    if kind == TSODYKS_MARKRAM:
        return kind, dict(_tsodyks(values)), {}
    if kind == STDP and (values["weight"] >= 0).all() and (values["Wmax"] > 0).all():
        additive = not values["mu_plus"].any()
        rate = values["lambda"]
        parameters = {
            "tau_plus": values["tau_plus"], "tau_minus": np.full_like(rate, 20.0),
            "A_plus": rate, "A_minus": rate * values["alpha"],
            "w_min": np.zeros_like(rate), "w_max": values["Wmax"] * scale,
            "dendritic_delay_fraction": np.ones_like(rate),
        }  # fmt: skip
        dependence = f"{'Additive' if additive else 'Multiplicative'}WeightDependence"
        return kind, parameters, {"timing_dependence": "SpikePairRule", "weight_dependence": dependence}
    return STATIC, {}, {}


def _tsodyks(values: Mapping[str, FloatArray]) -> Iterator[tuple[str, FloatArray]]:
    for name, spelling in (("U", "U"), ("tau_rec", "tau_rec"), ("tau_facil", "tau_fac")):
        yield name, values[spelling].copy()
