"""The named groups of cells, and the synapses between them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray, IntArray
from nrp_core.network.data import Network, Projection
from nrp_core.recording.folder.recording_folder import ranges_of, views_data

FEWEST_CELLS = 17
"""Smaller populations are not divided: the page draws their cells one by one."""
MOST_SYNAPSES = 50_000_000
"""Synapses of larger brains are not counted: that takes seconds, in which the run stands still."""


def groups_data(views: Mapping[str, Mapping[str, Any]], sizes: Mapping[str, int]) -> list[dict[str, Any]]:
    """Return the named groups, each with ranges of its cells by population.

    ``own`` holds the cells that are drawn as the group's: a cell in several groups belongs to the smallest,
    so that a group that consists of smaller ones has none. Other names of a whole population are omitted.

    Args:
        views: ranges of cells by population, by name.
        sizes: the number of cells of each population.
    """
    wholes = [{label: [[0, size]]} for label, size in sizes.items()]
    groups = {name: cells for name, cells in views.items() if cells not in wholes}
    own: dict[str, dict[str, Any]] = {name: {} for name in groups}
    for label, size in sizes.items():
        names, parts = _parts(groups, label, size)
        for number, name in enumerate(names):
            if (cells := np.flatnonzero(parts == number)).size:
                own[name][label] = ranges_of(cells)
    return [{"name": name, "cells": cells, "own": own[name]} for name, cells in groups.items()]


def _parts(groups: Mapping[str, Mapping[str, Any]], label: str, size: int) -> tuple[list[str], IntArray]:
    """Return the groups of a population and, for each cell, the number of its own one; -1: it has none."""
    parts = np.full(size, -1)
    names = [name for name, cells in groups.items() if label in cells] if size >= FEWEST_CELLS else []
    cells_in = {name: sum(end - first for first, end in groups[name][label]) for name in names}
    for name in sorted(names, key=lambda name: (-cells_in[name], -names.index(name))):
        for first, end in groups[name][label]:
            parts[first:end] = names.index(name)
    return names, parts


def connections(network: Network) -> dict[str, Any]:
    """Count the initial synapses between the groups of cells.

    Returns:
        ``parts``: population and group of each part of the brain; the group is None for the cells in no
        group. ``links``: projection, the numbers of the two parts, the number of synapses and their mean
        weight. None for both if there are more than :data:`MOST_SYNAPSES`.
    """
    if sum(projection.size for projection in network.projections) > MOST_SYNAPSES:
        return {"parts": None, "links": None}
    sizes = {label: population.size for label, population in network.populations.items()}
    groups = {one["name"]: one["cells"] for one in groups_data(views_data(network), sizes)}
    parts: list[dict[str, Any]] = []
    numbers: dict[str, IntArray] = {}
    for label, size in sizes.items():
        names, own = _parts(groups, label, size)
        numbers[label] = np.where(own < 0, len(names), own) + len(parts)
        parts += [{"population": label, "group": name} for name in (*names, None)]
    links = [link for each in network.projections for link in _links(each, numbers, len(parts))]
    return {"parts": parts, "links": links}


def _links(projection: Projection, numbers: Mapping[str, IntArray], n: int) -> list[dict[str, Any]]:
    synapses, weights = _sums(projection, numbers[projection.pre], numbers[projection.post], n)
    return [
        {
            "projection": projection.label,
            "from": int(pair // n),
            "to": int(pair % n),
            "synapses": int(synapses[pair]),
            "weight": float(weights[pair] / synapses[pair]),
        }
        for pair in np.flatnonzero(synapses)
    ]


def _sums(projection: Projection, pre: IntArray, post: IntArray, n: int) -> tuple[IntArray, FloatArray]:
    """Return the number of synapses and the sum of their weights, for each pair of parts."""
    synapses, weights = np.zeros(n * n, np.int64), np.zeros(n * n)
    weight, at = projection.weight, 0
    for sources, targets in projection.pairs():
        pairs = pre[sources] * n + post[targets]
        synapses += np.bincount(pairs, minlength=n * n)
        weights += np.bincount(pairs, weight[at : at + len(pairs)], n * n)
        at += len(pairs)
    return synapses, weights
