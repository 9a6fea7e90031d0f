"""Several networks as one: each is a group, whose name is put before the names of its parts.

Population ``eyes`` of the group ``red`` is ``red.eyes``. So are views, projections, and the random streams
that are named after them: what a group does never depends on the groups beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from nrp_core._support.arrays import IntArray
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.indices import stored_form

SEPARATOR = "."


def join_networks(networks: Mapping[str, Network]) -> Network:
    """Return one network with a group for each of some networks, which have no synapses between them.

    Args:
        networks: by the name of their group; global ids follow this order. The time step is the shortest.
    """
    populations: dict[str, Population] = {}
    whole: dict[str, list[object]] = {"projections": [], "currents": [], "remarks": []}
    views: dict[str, IntArray] = {}
    offset = 0
    for group, network in networks.items():
        begin = f"{group}{SEPARATOR}"
        for label, one in network.populations.items():
            populations[begin + label] = replace(one, label=begin + label)
        whole["projections"] += (_renamed(one, begin) for one in network.projections)
        whole["currents"] += (replace(one, neurons=one.neurons + offset) for one in network.currents)
        whole["remarks"] += (f"{group}: {remark}" for remark in network.remarks)
        views |= {begin + name: ids + offset for name, ids in network.views.items()}
        offset += network.size
    steps = [one.timestep_ms for one in networks.values() if one.timestep_ms is not None]
    parts = {name: tuple(values) for name, values in whole.items()}
    return Network(populations, views=views, timestep_ms=min(steps, default=None), **parts)  # type: ignore[arg-type]


def _renamed(projection: Projection, begin: str) -> Projection:
    """Return a projection whose label and populations have a prefix; its arrays are not copied."""
    rewiring = projection.rewiring
    if rewiring is not None and rewiring.stream:
        rewiring = replace(rewiring, stream=begin + rewiring.stream)
    kept = {name: stored_form(projection, name) for name in ("weight", "delay_ms", "pre_index", "post_index")}
    names = {name: begin + getattr(projection, name) for name in ("label", "pre", "post")}
    return replace(projection, **names, **kept, rewiring=rewiring)
