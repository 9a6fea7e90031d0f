"""Short functions that build networks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Network, Population, Projection
from nrp_core.brain.network.synapses import STATIC
from nrp_core.conformance.brain.samples import Sample

Part = Population | Projection
Pairs = Sequence[tuple[int, int]]
Numbers = float | Sequence[float]


def network(*parts: Part) -> Network:
    """Return a network of populations and projections."""
    populations = {part.label: part for part in parts if isinstance(part, Population)}
    return Network(populations, tuple(part for part in parts if isinstance(part, Projection)))


def cells(sample: Sample, label: str, size: int = 1, **parameters: Any) -> Population:
    """Return sample cells; a parameter is one number for all, or one for each."""
    values = {**sample.all_parameters, **parameters}
    return Population(label, size, sample.cell_type, _each(values, size), _each(sample.initial_values, size))


def spikes(label: str, *trains: Sequence[float]) -> Population:
    """Return cells that emit given spikes (ms)."""
    arrays = tuple(np.asarray(train, dtype=float) for train in trains)
    return Population(label, len(trains), "SpikeSourceArray", {}, {}, arrays)


def poisson(label: str, size: int, rate: float) -> Population:
    """Return cells that emit Poisson trains at a constant rate, Hz."""
    values = {"rate": rate, "start": 0.0, "duration": 1e10}
    return Population(label, size, "SpikeSourcePoisson", _each(values, size))


def connect(
    pre: str, post: str, weight: Numbers, delay: Numbers = 1.0, *,
    pairs: Pairs = ((0, 0),), receptor: str = "excitatory", kind: str = STATIC,
    rule: Mapping[str, str] | None = None, **parameters: Numbers,
) -> Projection:  # fmt: skip
    """Return synapses between pairs of cells; a number is the same for all, or one for each; delays in ms."""
    pre_index, post_index = np.array(pairs, np.int32).T
    n = len(pre_index)
    return Projection(
        f"{pre} to {post}, {receptor}", pre, post, receptor, pre_index, post_index,
        _of_each(weight, n), _of_each(delay, n),
        kind, _each(parameters, n), dict(rule or {}),
    )  # fmt: skip


def _each(values: Mapping[str, Any], size: int) -> dict[str, Any]:
    return {name: _of_each(value, size) for name, value in values.items()}


def _of_each(value: Numbers, size: int) -> FloatArray:
    return np.broadcast_to(np.asarray(value, float), size).copy()
