"""SONATA's populations of edges as projections."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, Final

import numpy as np

from nrp_core.brain import RECEPTORS, FloatArray, IndexArray, IntArray, Population, Projection
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.files.hdf5 import attribute, column
from nrp_core.network.nest_models import CellModel
from nrp_formats.sonata.items import SonataItems
from nrp_formats.sonata.nodes import Nodes
from nrp_formats.sonata.synapses import Chosen, Values, models_of

EDGE_NAMES: Final = frozenset({"syn_weight", "weight", "delay", "nsyns", "receptor_type"})
"""The attributes of every edge that are used; a model of synapses has more."""
DELAY_MS: Final = 1.0
"""The default of NEST's synapses."""


def read_edges(part: Any, items: SonataItems, nodes: Mapping[str, Nodes]) -> Iterator[Projection]:
    """Yield the projections of a population of edges: one for each pair of cell populations and receptor.

    Args:
        part: its HDF5 group.
        items: the edges.
        nodes: all populations of nodes.

    Raises:
        NetworkError: an edge refers to a missing node, or has an invalid weight or delay.
        CapabilityError: the synapse model is not supported.
    """
    models = list(models_of(items))
    pre, pre_places = _ends(part, "source", items, nodes)
    post, post_places = _ends(part, "target", items, nodes)
    weight = _weights(items)
    delay_ms = _delays_ms(items)
    inhibitory = _is_inhibitory(items, weight)
    for pre_population, _, pre_index in _cells(pre, pre_places):
        for post_population, model, post_index in _cells(post, post_places):
            between = (pre_index >= 0) & (post_index >= 0)
            signs = zip(RECEPTORS, (~inhibitory, inhibitory), strict=True)
            for (receptor, sign), (name, synapses, of_model) in product(signs, models):
                chosen = np.flatnonzero(between & sign & of_model)
                if not len(chosen):
                    continue
                label = _label(items.name, pre, post, pre_population.label, post_population.label, receptor)
                tau_minus = post.items.numbers("tau_minus")[post_places[chosen]]
                which = Chosen(
                    owner=f"edges '{items.name}'", values=_reader(items, chosen), target=post_population,
                    post_index=post_index[chosen], tau_minus=tau_minus, receptor=receptor,
                    weight_scale=_times(items)[chosen] * model.weight_scale,
                )  # fmt: skip
                kind = synapses(which)
                yield Projection(
                    label=f"{label} {name}" if len(models) > 1 else label,
                    pre=pre_population.label, post=post_population.label, receptor=receptor,
                    pre_index=pre_index[chosen], post_index=post_index[chosen],
                    weight=_signed(weight[chosen], model, receptor),
                    delay_ms=np.ascontiguousarray(delay_ms[chosen]), synapse_type=kind.synapse_type,
                    synapse_parameters=kind.synapse_parameters, plasticity=kind.plasticity,
                )  # fmt: skip


def _label(name: str, pre: Nodes, post: Nodes, source: str, target: str, receptor: str) -> str:
    between = f" ({source}→{target})" if len(pre.populations) > 1 or len(post.populations) > 1 else ""
    return f"{name}{between} {receptor}"


def _reader(items: SonataItems, chosen: IntArray) -> Values:
    def values(name: str, default: float) -> FloatArray:
        given = items.numbers(name)[chosen]
        return np.where(np.isnan(given), default, given)

    return values


def _ends(part: Any, end: str, items: SonataItems, nodes: Mapping[str, Nodes]) -> tuple[Nodes, IntArray]:
    ids = column(part, f"{end}_node_id", np.int64)
    if len(ids) != len(items):
        raise NetworkError(f"edges '{items.name}' are {len(items)}, and {len(ids)} of them have a {end}")
    name = attribute(part[f"{end}_node_id"], "node_population", str)
    if name not in nodes:
        raise NetworkError(
            f"edges '{items.name}': no {end} nodes have the name '{name}'{did_you_mean(name, nodes)}"
        )
    return nodes[name], nodes[name].places_of(ids, items.name)


def _cells(nodes: Nodes, places: IntArray) -> Iterator[tuple[Population, CellModel, IndexArray]]:
    """Yield each cell population of nodes, with the index of every node at ``places`` in it, or -1."""
    for (model, chosen), population in zip(nodes.models, nodes.populations, strict=True):
        index = np.full(len(nodes.items), -1, np.int32)
        index[chosen] = np.arange(len(chosen))
        yield population, model, index[places]


def _weights(items: SonataItems) -> FloatArray:
    """Return weights in the file's unit: a synapse's weight times the number of synapses of an edge."""
    return _required(items, ("syn_weight", "weight")) * _times(items)


def _times(items: SonataItems) -> FloatArray:
    """Return the number of synapses of each edge."""
    n = items.numbers("nsyns")
    if (n < 0).any():
        edge = int(np.argmax(n < 0))
        raise NetworkError(f"edge {edge} of '{items.name}' has nsyns {n[edge]:g}; it must be 0 or more")
    if (n % 1.0 > 0.0).any():  # a missing number is not more than 0
        edge = int(np.argmax(n % 1.0 > 0.0))
        raise NetworkError(f"edge {edge} of '{items.name}' has nsyns {n[edge]:g}; it must be a whole number")
    return np.where(np.isnan(n), 1.0, n)


def _delays_ms(items: SonataItems) -> FloatArray:
    """Return the delay of each edge; one without has the default of NEST's synapses."""
    given = items.numbers("delay")
    return np.where(np.isnan(given), DELAY_MS, given) if np.isnan(given).any() else given


def _required(items: SonataItems, names: tuple[str, ...]) -> FloatArray:
    values = items.numbers(names[0])
    for name in names[1:]:
        values = np.where(np.isnan(values), items.numbers(name), values) if np.isnan(values).any() else values
    missing = np.isnan(values)
    if missing.any():
        edge = int(np.argmax(missing))
        raise NetworkError(
            f"edge {edge} of '{items.name}' (type {items.type_ids[edge]}) has no {' or '.join(names)}; its "
            f"attributes: {', '.join(sorted(items.names()))}"
        )
    return values


def _is_inhibitory(items: SonataItems, weight: FloatArray) -> Any:
    """Return which edges are inhibitory, by receptor type or else by a negative weight."""
    inhibitory = np.asarray(weight < 0)
    for number, receptor in items.texts("receptor_type").items():
        if receptor in ("", "default"):
            continue
        if receptor not in RECEPTORS:
            hint = did_you_mean(receptor, RECEPTORS)
            raise NetworkError(f"edge type {number} of '{items.name}': receptor_type '{receptor}'{hint}")
        inhibitory = np.where(items.type_ids == number, receptor == "inhibitory", inhibitory)
    return inhibitory


def _signed(weight: FloatArray, model: CellModel, receptor: str) -> FloatArray:
    """Return weights in PyNN's units; conductances are never negative on either receptor."""
    scaled = np.ascontiguousarray(weight) * model.weight_scale
    if "_cond_" in model.cell_type and receptor == "inhibitory":
        return np.abs(scaled)
    return scaled
