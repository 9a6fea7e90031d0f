"""The combinations of values that a sweep runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import product
from math import prod
from typing import Any
from warnings import catch_warnings, filterwarnings

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.experiment.model.ranges import Range
from nrp_core.seeds import Seeds
from nrp_lab.sweep.axes import Axis, Value
from nrp_lab.sweep.model import GIVEN, GRID, SEED, Design, SweepFile


def number_of_runs(sweep: SweepFile) -> int:
    """Return the number of runs without making them."""
    seeds = _length(sweep.vary[SEED]) if SEED in sweep.vary else 1
    if sweep.design.kind != GRID:
        return sweep.design.points * seeds
    return prod(_length(sweep.vary[key]) for key in sweep.sampled) * seeds


def _length(axis: Axis) -> int:
    return 1 if isinstance(axis, Range) else len(axis)


def combinations(sweep: SweepFile, own_seed: int) -> Iterator[dict[str, Value]]:
    """Yield the values of every run; runs that differ only in the seed follow each other.

    Args:
        sweep: the sweep.
        own_seed: the seed of the experiment, for a sweep without seeds.
    """
    axes = {key: sweep.vary[key] for key in sweep.sampled}
    seeds: Sequence[Any] = sweep.vary[SEED].levels if SEED in sweep.vary else [own_seed]  # type: ignore[union-attr]
    for point in _points(axes, sweep.design):
        for seed in seeds:
            drawn = {
                key: axis.override(key, seed).partition("=")[2]
                for key, axis in sweep.vary.items()
                if isinstance(axis, Range)
            }
            given = {**point, **drawn, SEED: seed}
            yield {key: given[key] for key in sweep.vary}


def _points(axes: Mapping[str, Axis], design: Design) -> Iterator[dict[str, Value]]:
    if design.kind == GRID:
        levels = [axis.levels for axis in axes.values()]  # type: ignore[union-attr]
        yield from (dict(zip(axes, point, strict=True)) for point in product(*levels))
        return
    for shares in _shares(design, len(axes)).tolist():
        yield {
            key: axis.at(share)  # type: ignore[union-attr]
            for (key, axis), share in zip(axes.items(), shares, strict=True)
        }


def _shares(design: Design, dimensions: int) -> FloatArray:
    """Return points of the unit cube, shape ``(points, dimensions)``; the same for equal designs."""
    if design.kind == GIVEN:
        return np.array(design.shares)
    rng = np.random.default_rng(Seeds(0).child("sweep").integer(design.kind))
    if design.kind == "random":
        return rng.random((design.points, dimensions))
    from scipy.stats import qmc

    make = {"sobol": qmc.Sobol, "latin": qmc.LatinHypercube}[design.kind]
    with _any_number_of_points():
        shares: FloatArray = make(dimensions, rng=rng).random(design.points)
    return shares


@contextmanager
def _any_number_of_points() -> Iterator[None]:
    """Accept a number of Sobol points that is not a power of 2; then the sample is slightly less even."""
    with catch_warnings():
        filterwarnings("ignore", message="The balance properties", category=UserWarning)
        yield
