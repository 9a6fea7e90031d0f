"""Inputs outside the calendar: spikes of source cells, device events, and earlier spikes in transit.

They are appended in any order, and arranged when the grid runs.
"""

from __future__ import annotations

from math import ceil

import numpy as np

from nrp_brain_event.grid.on_demand import with_kernels
from nrp_brain_event.grid.records import DELIVER_LATE, Grid, GridClock, Input
from nrp_brain_event.grid.sorting import sorting
from nrp_brain_event.handles import opened
from nrp_brain_event.records import Array
from nrp_core._support.jit import inlined, jit
from nrp_core.clock import NS_PER_MS
from nrp_core.network.grid import ROUNDING

_ROOM = 256


def no_inputs() -> Array:
    """Return an empty list with some room."""
    return np.zeros(_ROOM, Input.dtype())


def joined(*parts: Array) -> Array:
    """Return lists of inputs as one, of records: NumPy alone makes it one of plain structures."""
    return np.concatenate(parts, dtype=Input.dtype())


def waiting(grid: Grid) -> tuple[Array, Array]:
    """Return copies of the spikes of sources and of the arrivals that have not been used."""
    clock = grid.clock[0]
    return (
        grid.sources[clock["source"] : clock["n_sources"]].copy(),
        grid.arrivals[clock["arrival"] : clock["n_arrivals"]].copy(),
    )


def with_waiting(grid: Grid, sources: Array, arrivals: Array) -> Grid:
    """Return the grid with other inputs, in order."""
    clock = grid.clock[0]
    clock["source"] = clock["arrival"] = clock["is_mixed"] = 0
    clock["n_sources"], clock["n_arrivals"] = len(sources), len(arrivals)
    kept = [joined(each, no_inputs()) for each in (sources, arrivals)]
    for inputs, n in zip(kept, (len(sources), len(arrivals)), strict=True):
        sort(inputs, n)
    is_plastic = bool((arrivals["synapse"] >= 0).any())
    codes = with_kernels(grid.codes, DELIVER_LATE) if is_plastic else grid.codes
    return grid._replace(sources=kept[0], arrivals=kept[1], codes=codes)


@jit
def fire(places: Array, neurons: Array, times: Array, begin: int) -> int:
    """Append spikes of source cells (global ids; ms), from number ``begin`` on.

    Returns:
        The number of spikes appended; fewer than all if the room is full.
    """
    grid = opened(Grid, places)
    clock = grid.clock[0]
    for k in range(begin, len(neurons)):
        if clock.n_sources == len(grid.sources):
            return k
        _write(grid.sources[clock.n_sources], _first_at(clock, times[k]), neurons[k], 0.0)
        clock.n_sources += 1
        clock.is_mixed = 1
    return len(neurons)


@jit
def inject(places: Array, neurons: Array, times: Array, weights: Array, inhibitory: int, begin: int) -> int:
    """Append events at neurons (global ids), from number ``begin`` on; returns as :func:`fire`."""
    grid = opened(Grid, places)
    clock = grid.clock[0]
    for k in range(begin, len(neurons)):
        if clock.n_arrivals == len(grid.arrivals):
            return k
        step = max(_first_at(clock, times[k]), clock.step + 1)
        _write(grid.arrivals[clock.n_arrivals], step, grid.lines[inhibitory, neurons[k]], weights[k])
        clock.n_arrivals += 1
        clock.is_mixed = 1
    return len(neurons)


@jit
def arrange(clock: GridClock, sources: Array, arrivals: Array) -> None:
    """Sort inputs and drop those that have been used."""
    if clock.is_mixed:
        clock.n_sources = _arranged(sources, clock.source, clock.n_sources)
        clock.n_arrivals = _arranged(arrivals, clock.arrival, clock.n_arrivals)
        clock.source = clock.arrival = clock.is_mixed = 0


@inlined
def _first_at(clock: GridClock, time: float) -> int:
    """Return the first step that ends at or after a time, as :class:`~nrp_core.network.grid.Grid`."""
    return ceil(time * (NS_PER_MS / clock.step_ns) - ROUNDING)


@inlined
def _write(new: Input, step: int, target: int, weight: float) -> None:
    new.step, new.target, new.synapse, new.weight = step, target, -1, weight


@jit
def _arranged(inputs: Array, used: int, n: int) -> int:
    for k in range(used, n if used > 0 else 0):
        inputs[k - used] = inputs[k]
    sort(inputs, n - used)
    return n - used


@jit
def sort(inputs: Array, n: int) -> None:
    """Sort the first n inputs by their fields.

    The steps of most inputs ascend already; the rest is small enough to be sorted in the faster caches.
    """
    order = np.arange(n)
    _order_steps(inputs, order, 0, n)
    first = 0
    for k in range(1, n + 1):
        if k == n or inputs[order[k]].step != inputs[order[first]].step:
            if k - first > 1:
                _order(inputs, order, first, k)
            first = k
    given = inputs[:n].copy()
    for k in range(n):
        inputs[k] = given[order[k]]


@inlined
def _of_earlier_step(inputs: Array, first: int, second: int) -> bool:
    return bool(inputs[first].step < inputs[second].step)


@inlined
def _earlier(inputs: Array, first: int, second: int) -> bool:
    """Return whether the first of two inputs of one step comes before the second one."""
    a, b = inputs[first], inputs[second]
    if a.target != b.target:
        return bool(a.target < b.target)
    if a.synapse != b.synapse:
        return bool(a.synapse < b.synapse)
    return bool(a.weight < b.weight)


_order_steps, _order = sorting(_of_earlier_step), sorting(_earlier)
