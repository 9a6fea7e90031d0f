"""Builds the lazy grid from a grid at any step, and the reverse."""

from __future__ import annotations

from math import e, exp
from typing import Any, Final

import numpy as np

from nrp_brain_event.grid import records as grid_records
from nrp_brain_event.grid.lazy.neuron import watch
from nrp_brain_event.grid.lazy.records import (
    CHANGING,
    DEPTH,
    KEPT,
    LEAK,
    N_COURSE,
    S_EFFECT,
    SECOND,
    X_EFFECT,
    Kind,
    Lazy,
    LazyClock,
    Neuron,
)
from nrp_brain_event.grid.lazy.show import show_all
from nrp_brain_event.grid.records import JUMP, Grid
from nrp_brain_event.handles import handle, opened
from nrp_brain_event.records import Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.brain.network.filters import driven

_DECIDING: Final = ("kind", "alpha", "frozen", "refractory", "v_rest", "reset", "threshold")
_CONSTANTS: Final = ("tau_m", "cm")
_LONG: Final = 80.0
"""Time constants after which nothing remains."""
_SAFETY: Final = 1.001
"""The peaks are looked for at many times, not at all."""
Kinds = tuple[Array, Array, FloatArray]


def load_kinds(grid: Grid, cells: Array) -> Kinds:
    """Return the ``Kind`` records, the kind of each row, and the courses of all kinds.

    Args:
        grid: the grid.
        cells: the ``Cell`` in each row, for its time constants.
    """
    runs, first = grid.runs, cells[grid.runs["first"]]
    chosen, kind_of_run = kinds_of(grid, cells)
    kinds = np.zeros(len(chosen), Kind.dtype())
    courses = np.zeros((len(chosen) * DEPTH, N_COURSE))
    h = float(grid.clock["h"][0])
    for number, (kind, run) in enumerate(zip(kinds, chosen.tolist(), strict=True)):
        kind["course"] = number * DEPTH
        _fill(kind, runs[run], first[run], h, courses[number * DEPTH : (number + 1) * DEPTH])
    kind_of = np.repeat(kind_of_run.astype(np.uint8), runs["last"] - runs["first"])
    return kinds, kind_of, courses


def kinds_of(grid: Grid, cells: Array) -> tuple[IntArray, IntArray]:
    """Return the first run of each kind, and the kind of each run."""
    runs, first = grid.runs, cells[grid.runs["first"]]
    columns = [runs[name].astype(float) for name in _DECIDING] + [first[name] for name in _CONSTANTS]
    deciding = np.column_stack([*columns, first["tau_syn"]])
    _, chosen, kind_of_run = np.unique(deciding, axis=0, return_index=True, return_inverse=True)
    return chosen, kind_of_run.reshape(-1)


def from_plain(grid: Grid, kinds: Kinds) -> Lazy:
    """Return the lazy grid that goes on where a grid is."""
    records, kind_of, courses = kinds
    n_rows, step = len(kind_of), int(grid.clock["step"][0])
    waiting, single = np.isnan(grid.state[grid_records.V]), records["single"][kind_of] == 1
    neurons = np.zeros(n_rows, Neuron.dtype())
    neurons["v"] = np.where(waiting, records["reset"][kind_of], grid.state[grid_records.V])
    neurons["step"], neurons["kind"] = step, kind_of
    neurons["free"] = np.where(waiting, grid.release - 1, step - 1)
    for name, line in (("x", grid_records.X), ("s", grid_records.S)):
        both = grid.state[line : line + 2]
        neurons[name][:, 0] = np.where(single, both.sum(axis=0), both[0])
        neurons[name][:, 1] = np.where(single, 0.0, both[1])
    clock = np.zeros(1, LazyClock.dtype())
    clock["driven"] = (grid.drive != 0.0).any()
    rows = np.zeros((2, n_rows), np.int32)
    lazy = Lazy(clock, records, neurons, courses, rows[0], rows[1])
    _watch_all(handle(grid).places, handle(lazy).places)
    return lazy


def to_plain(grid: Grid, lazy: Lazy) -> Grid:
    """Return the plain grid that goes on where a lazy grid is."""
    grid = grid._replace(
        state=grid.state.copy(), runs=grid.runs.copy(), queue=grid.queue.copy(), release=grid.release.copy()
    )
    show_all(handle(grid).places, handle(lazy).places, np.arange(len(lazy.neurons)))
    waiting = np.isnan(grid.state[grid_records.V])
    grid.release[:] = lazy.neurons["free"] + 1
    grid.runs["head"] = grid.runs["n_waiting"] = 0
    rows = np.flatnonzero(waiting)
    rows = rows[np.argsort(grid.release[rows], kind="stable")]
    of = np.searchsorted(grid.runs["first"], rows, "right") - 1
    for run in np.unique(of):
        mine = rows[of == run]
        grid.queue[grid.runs["first"][run] :][: len(mine)] = mine
        grid.runs["n_waiting"][run] = len(mine)
    return grid


def changing(lazy: Lazy) -> dict[str, Array]:
    """Return copies of all arrays that change while running, by name."""
    return {name: getattr(lazy, name).copy() for name in CHANGING}


def _fill(kind: Any, run: Any, cell: Any, h: float, courses: FloatArray) -> None:
    for name in ("alpha", "frozen", "refractory", "reset", "threshold", "grown"):
        kind[name] = run[name]
    kind["jump"], kind["resistance"] = run["kind"] == JUMP, cell["tau_m"] / cell["cm"]
    tau_m, taus = float(cell["tau_m"]), cell["tau_syn"].tolist()
    kind["single"] = kind["jump"] or taus[0] == taus[1]
    kind["simple"] = kind["single"] and not (kind["jump"] or kind["alpha"])
    unit = tau_m if kind["frozen"] else float(cell["cm"])
    steps = np.arange(DEPTH)
    courses[:, LEAK] = np.exp(-steps * h / tau_m)
    if kind["jump"]:
        kind["x_peak"] = 1.0
        return
    for k, tau in enumerate(taus):
        courses[:, KEPT + k * SECOND] = np.exp(-steps * h / tau)
        every = np.unique(np.geomspace(1.0, max(_LONG * max(tau_m, tau) / h, 2.0), 4 * DEPTH).astype(int))
        for column, x, s in ((X_EFFECT, 1.0, 0.0), (S_EFFECT, 0.0, e / tau)):
            effect = [_effect(n * h, tau_m, tau, x, s) / unit for n in steps.tolist()]
            courses[:, column + k * SECOND] = effect
            peak = max(_effect(n * h, tau_m, tau, x, s) / unit for n in every.tolist()) * _SAFETY
            kind["x_peak" if x else "s_peak"][k] = peak


def _effect(t: float, tau_m: float, tau: float, x: float, s: float) -> float:
    return driven(t, exp(-t / tau_m), exp(-t / tau), 1.0 / tau - 1.0 / tau_m, x, s)


@jit
def _watch_all(places: Array, own: Array) -> None:
    grid, lazy = opened(grid_records.Grid, places), opened(Lazy, own)
    for row in range(len(lazy.neurons)):
        neuron = lazy.neurons[row]
        watch(lazy, neuron, lazy.kinds[neuron.kind], row, grid.drive[row])
