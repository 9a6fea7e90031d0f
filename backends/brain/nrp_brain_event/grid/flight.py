"""Spikes in transit, synapse by synapse: weights can be read, and changed for later spikes only."""

from __future__ import annotations

import numpy as np

from nrp_brain_event.grid.delivery import send_all
from nrp_brain_event.grid.inputs import sort, waiting, with_waiting
from nrp_brain_event.grid.loader import changing, enlarged
from nrp_brain_event.grid.records import PLASTIC, SHORT_TERM, Grid, Input
from nrp_brain_event.grid.synapses import transmitted
from nrp_brain_event.plasticity import bring_up_to
from nrp_brain_event.records import Array
from nrp_brain_event.synapse_kernels import SIMULTANEOUS, released_share
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit


def unfolded(grid: Grid) -> Grid:
    """Return the grid with an empty calendar, and all inputs in transit among its arrivals.

    Spikes that have passed their synapses keep their weights.
    """
    grid = _sent(grid)
    sources, ahead = waiting(grid)
    arrivals = np.concatenate([ahead, _synapses_ahead(grid)])
    grid.slots[:] = -1
    n = len(grid.entry_after)
    grid.entry_after[:] = np.arange(1, n + 1)
    grid.entry_after[-1] = -1
    grid.clock["free"], grid.clock["n_free"] = 0, n
    sort(arrivals, len(arrivals))
    passed, weights = _pass(grid, arrivals)
    arrivals["weight"][passed], arrivals["synapse"][passed] = weights, -1
    return with_waiting(grid, sources, arrivals)


def plastic_now(grid: Grid) -> Array:
    """Return plastic synapses after processing all spikes of both sides that have reached them by now.

    Because of the axonal and dendritic parts of the delay, synapses process a spike before it arrives.
    """
    seen = _sent(grid._replace(**changing(grid)))
    arrivals = np.concatenate([waiting(seen)[1], _synapses_ahead(seen)])
    sort(arrivals, len(arrivals))
    _pass(seen, arrivals)
    hear_all(seen)
    return seen.plastic


def hear_all(grid: Grid) -> None:
    """Process the spikes of targets up to now in plastic synapses."""
    none = np.empty(0, np.int64)
    bring_up_to(_now(grid), grid.memories, grid.plastic, grid.rules, grid.stored, none)


def _sent(grid: Grid) -> Grid:
    """Return the grid with all spikes in the calendar."""
    while grid.clock["n_free"][0] < grid.clock["n_out"][0]:
        grid = enlarged(grid)
    _send_all(grid)
    return grid


def _now(grid: Grid) -> float:
    return float(grid.clock["step"][0] * grid.clock["h"][0])


def _synapses_ahead(grid: Grid) -> Array:
    """Return the inputs through each synapse of the spikes in the calendar.

    For short-term plasticity the weight is the released share.
    """
    n = _count_ahead(grid)
    steps, segments = np.empty(n, np.int64), np.empty(n, np.int64)
    _list_ahead(grid, steps, segments)
    order = np.argsort(steps, kind="stable")
    steps, segments = steps[order], segments[order]
    passed = grid.segments[segments]
    lengths = passed["length"].astype(np.int64)
    begins = passed["start"] - (np.cumsum(lengths) - lengths)
    synapses = np.repeat(begins, lengths) + np.arange(lengths.sum())
    steps, tables = np.repeat(steps, lengths), grid.tables[np.repeat(passed["table"], lengths)]
    weights, own = tables["weight"].copy(), tables["own"] > 0
    weights[own] = grid.weights[synapses[own] + tables["weights"][own]]
    dynamic = np.flatnonzero(tables["dynamic"] == SHORT_TERM)
    rows = synapses[dynamic] + tables["dynamics"][dynamic]
    weights[dynamic] *= _released(grid.short_term, rows, steps[dynamic] * grid.clock["h"][0])
    plastic, of = np.full(len(steps), -1, np.int64), tables["dynamic"] == PLASTIC
    plastic[of] = grid.plastic_rows[synapses[of] + tables["dynamics"][of]]
    found = np.zeros(len(steps), Input.dtype())
    found["step"], found["target"] = steps, tables["line"] + grid.targets[synapses]
    found["synapse"], found["weight"] = plastic, weights
    return found


def _pass(grid: Grid, inputs: Array) -> tuple[IntArray, FloatArray]:
    """Process the spikes that have reached plastic synapses by now; return these and their weights."""
    plastic = np.flatnonzero(inputs["synapse"] >= 0)
    synapses, arrivals_ms = inputs["synapse"][plastic], inputs["step"][plastic] * grid.clock["h"][0]
    heard = arrivals_ms - grid.plastic["dendritic_delay"][synapses]
    chosen = np.flatnonzero(heard <= _now(grid) + SIMULTANEOUS)
    chosen = chosen[np.argsort(heard[chosen], kind="stable")]
    passed, weights = plastic[chosen], np.empty(len(chosen))
    _transmit(grid, synapses[chosen], arrivals_ms[chosen], weights)
    return passed, weights


@jit
def _send_all(grid: Grid) -> None:
    send_all(grid.clock[0], grid)


@jit
def _count_ahead(grid: Grid) -> int:
    n = 0
    for slot in range(len(grid.slots)):
        entry = grid.slots[slot]
        while entry >= 0:
            segment = grid.entry_segment[entry]
            n += 1
            while not grid.segments[segment].last:
                segment += 1
                n += 1
            entry = grid.entry_after[entry]
    return n


@jit
def _list_ahead(grid: Grid, steps: IntArray, segments: IntArray) -> None:
    now, n_slots, n = grid.clock[0].step, len(grid.slots), 0
    for ahead in range(1, n_slots + 1):
        entry = grid.slots[(now + ahead) & (n_slots - 1)]
        while entry >= 0:
            segment, step = grid.entry_segment[entry], now + ahead
            steps[n], segments[n] = step, segment
            n += 1
            while not grid.segments[segment].last:
                segment += 1
                step += grid.segments[segment].gap
                steps[n], segments[n] = step, segment
                n += 1
            entry = grid.entry_after[entry]


@jit
def _released(short_term: Array, rows: IntArray, times: FloatArray) -> FloatArray:
    shares = np.empty(len(rows))
    for k in range(len(rows)):
        shares[k] = released_share(short_term[rows[k]], times[k])
    return shares


@jit
def _transmit(grid: Grid, rows: IntArray, times: FloatArray, weights: FloatArray) -> None:
    for k in range(len(rows)):
        weights[k] = transmitted(grid, rows[k], times[k])
