"""A SONATA circuit as a network."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from nrp_core.brain import IntArray, Network, Projection
from nrp_core.errors import ExperimentError, NetworkError, did_you_mean
from nrp_core.network.files.hdf5 import attribute, group, groups, reading
from nrp_core.network.picking import Selection, with_views
from nrp_core.paths import path_of
from nrp_core.utilities import checks_arguments
from nrp_formats.sonata.attribute_checks import not_numbers, not_read, not_used
from nrp_formats.sonata.clamps import ALL, read_clamps
from nrp_formats.sonata.config import Config, Files, read_config
from nrp_formats.sonata.edges import DELAY_MS, EDGE_NAMES, read_edges
from nrp_formats.sonata.items import SonataItems, read_items, read_types
from nrp_formats.sonata.node_sets import read_node_sets, without_nodes
from nrp_formats.sonata.nodes import Nodes, Trains, read_nodes, read_spikes
from nrp_formats.sonata.synapses import MODEL_NAMES, unused_of_synapses

_MAGIC = 0x0A7A
T = TypeVar("T")


@checks_arguments()
def read_sonata(
    path: Path | str,
    *,
    populations: Mapping[str, Selection] | None = None,
    seed: int = 0,  # noqa: ARG001  readers of all kinds of files take it
) -> Network:
    """Read a circuit from its configuration or from a simulation's configuration.

    A population of nodes becomes a population of the same name, or several (``name/cell type``) if its nodes
    are of several models; a view of that name has all nodes in their order. Each name in the column
    ``pop_name`` of node types and each node set becomes a view too. Edges become one projection for each
    receptor and synapse type.

    Args:
        path: ``circuit_config.json`` or ``simulation_config.json``, whose spike inputs are read too.
        populations: additional named selections of nodes, numbered through all populations in turn.
        seed: has no effect, since a circuit has no random values to draw.

    Raises:
        NetworkError: a file is missing, truncated or inconsistent; with file and place.
        NeuronSelectionError: ``populations`` reaches outside the circuit.
        CapabilityError: the circuit has unsupported cells or synapses.
    """
    path = path_of(path, NetworkError)
    config = read_config(path)
    try:
        spikes = read_spikes(config.spikes)
        nodes = _nodes(config, spikes)
        cells = {p.label: p for part in nodes.values() for p in part.populations}
        remarks = list(config.unused)
        for part in nodes.values():
            used = {name for model, _ in part.models for name in model.names}
            for check in (not_used, not_numbers, not_read):
                remarks += check(part.items, used)
        remarks += _unused_spikes(spikes, nodes)
        network = Network(cells, tuple(_projections(config, nodes, remarks)))
        views = _views(network, nodes)
        ids = {name: views[name] for name in nodes}
        for path_of_sets in config.node_sets:
            sets = read_node_sets(path_of_sets, nodes, ids)
            remarks += without_nodes(path_of_sets, sets)
            _add_sets(views, path_of_sets, sets)
        remarks += _missing_targets(config, {*views, *nodes})
        network = Network(cells, network.projections, views, remarks=tuple(remarks))
        currents = tuple(read_clamps(path, config.clamps, nodes, network))
        network = replace(network, currents=currents) if currents else network
        return with_views(network, populations or {})
    except ExperimentError as error:
        error.path = error.path or path
        raise


def _add_sets(views: dict[str, IntArray], path: Path, sets: Mapping[str, IntArray]) -> None:
    """Add node sets to the named views; a set may repeat the name of an identical population.

    Raises:
        NetworkError: a set has the name of a view of other nodes.
    """
    for name, chosen in sets.items():
        if name in views and not np.array_equal(views[name], chosen):
            raise NetworkError(f"the node set '{name}' has the name of other nodes", path=path)
        views[name] = chosen


def _nodes(config: Config, spikes: Mapping[str, Trains]) -> dict[str, Nodes]:
    nodes: dict[str, Nodes] = {}
    for files in config.nodes:

        def read(part: Any, items: SonataItems) -> Nodes:
            if items.name in nodes:
                raise NetworkError(f"two populations of nodes have the name '{items.name}'")
            return read_nodes(part, items, spikes.get(items.name, {}))

        for found in _read(files, "node", config.point_neuron_models, read):
            nodes[found.items.name] = found
    return nodes


def _projections(config: Config, nodes: Mapping[str, Nodes], remarks: list[str]) -> list[Projection]:
    """Return the projections of all edges; sentences about unused attributes are added to the remarks."""
    found: dict[str, list[Projection]] = {}

    def read(part: Any, items: SonataItems) -> None:
        if items.name in found:
            raise NetworkError(f"two populations of edges have the name '{items.name}'")
        found[items.name] = list(read_edges(part, items, nodes))
        if not len(items):
            remarks.append(f"the edges '{items.name}' are none: they connect nothing")
        if undelayed := int(np.isnan(items.numbers("delay")).sum()):
            remarks.append(
                f"{undelayed} edges '{items.name}' have no delay, and get that of NEST, {DELAY_MS:g} ms"
            )
        for check in (not_used, not_numbers, not_read):
            remarks.extend(check(items, EDGE_NAMES | MODEL_NAMES))
        remarks.extend(unused_of_synapses(items))
        if functions := {name for name in items.texts("weight_function").values() if name}:
            shown = ", ".join(f"'{name}'" for name in sorted(functions))
            remarks.append(
                f"weight_function of the edges '{items.name}' is {shown}: the weights are used as given"
            )

    remarks += [
        f"{files.data.name} has no population of edges: it connects nothing"
        for files in config.edges
        if not _read(files, "edge", config.synaptic_models, read)
    ]
    if not config.edges:
        remarks.append("the circuit has no edges: 'networks' of its configuration has no 'edges'")
    return [projection for some in found.values() for projection in some]


def _read(files: Files, kind: str, parameters: Path, read: Callable[[Any, SonataItems], T]) -> list[T]:
    """Return the result of reading each population of nodes or edges in a file."""
    types = read_types(files.types, kind, parameters)
    with reading(files.data) as file:
        if "magic" in file.attrs and attribute(file, "magic", int) != _MAGIC:
            raise NetworkError("is HDF5, but not SONATA: its attribute 'magic' has another value")
        return [
            read(part, read_items(part, name, kind, types)) for name, part in groups(group(file, f"{kind}s"))
        ]


def _unused_spikes(spikes: Mapping[str, Trains], nodes: Mapping[str, Nodes]) -> Iterator[str]:
    """Yield a sentence for each population of an input that drives nothing, or nodes that do not exist."""
    for name, trains in spikes.items():
        owner = f"the input's spikes of '{name}' have no effect"
        if name not in nodes:
            yield f"{owner}: no nodes have this name{did_you_mean(name, nodes)}"
            continue
        listed = [one.label for one in nodes[name].populations if one.cell_type == "SpikeSourceArray"]
        if not listed:
            yield f"{owner}: its nodes are not virtual, or have a rate"
        elif lost := trains.keys() - set(nodes[name].node_ids.tolist()):
            many = f"{len(lost)} nodes that '{name}' does not have"
            yield f"the input has spikes of {many}, such as {min(lost)}"


def _missing_targets(config: Config, known: set[str]) -> Iterator[str]:
    """Yield a sentence for each input of spikes whose nodes do not exist."""
    for name, target in config.targets.items():
        if target not in known and target != ALL:
            missing = f"which does not exist{did_you_mean(target, known)}"
            yield f"the input '{name}' is for the node set '{target}', {missing}"


def _views(network: Network, nodes: Mapping[str, Nodes]) -> dict[str, IntArray]:
    views: dict[str, IntArray] = {}
    for name, part in nodes.items():
        ids = np.empty(len(part.items), np.int64)
        for (_, chosen), population in zip(part.models, part.populations, strict=True):
            ids[chosen] = network.ids_of(population.label)
        views[name] = ids
        for number, label in part.items.texts("pop_name").items():
            mine = ids[part.items.type_ids == number]
            if label and label not in nodes:
                views[label] = np.concatenate([views.get(label, mine[:0]), mine])
    return views
