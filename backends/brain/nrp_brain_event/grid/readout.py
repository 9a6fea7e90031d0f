"""State variables of neurons on a grid, and the check that they are finite.

State variables that are recorded while the grid runs, inside compiled code.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, isnan
from typing import Final

import numpy as np

from nrp_brain_event.grid.equations.blocks import places_of
from nrp_brain_event.grid.records import Grid, Probe, V, X
from nrp_brain_event.handles import opened
from nrp_brain_event.kernels import READABLE
from nrp_brain_event.neuron import voltage_at
from nrp_brain_event.records import Array, Cell, constant
from nrp_brain_event.rise import remaining_at
from nrp_brain_event.runge_kutta import state_at
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import inlined, jit
from nrp_core.brain.devices.sinks import Trace
from nrp_core.network.data import Network
from nrp_core.network.grid import Grid as TimeGrid

_LAST_OF_CURVED: Final = constant(2)
"""Index in ``READABLE`` of the last state variable of curved neurons; those of synapses follow."""


def read(grid: Grid, rows: IntArray, variable: str) -> FloatArray:
    """Return the present values of a state variable of rows."""
    if variable == "v":
        of = grid.runs[np.searchsorted(grid.runs["first"], rows, "right") - 1]
        above_rest = grid.state[V, rows]
        values = of["v_rest"] + np.where(np.isnan(above_rest), of["reset"], above_rest)
    else:
        values = grid.state[X + (variable == "gsyn_inh"), rows]
    now = float(grid.clock["step"][0] * grid.clock["h"][0])
    _read_cells(grid.cells, grid.cell_rows[rows], reading_of(variable), now, values)
    return values


def reading_of(variable: str) -> int:
    """Return the number of a state variable in compiled code."""
    return READABLE.index(variable)


def lost_row(grid: Grid) -> int:
    """Return a row whose voltage is not a number; there must be one."""
    lost = ~np.isfinite(grid.state[V])
    for run in grid.runs[grid.runs["n_waiting"] > 0]:
        places = (run["head"] + np.arange(run["n_waiting"])) % (run["last"] - run["first"])
        lost[grid.queue[run["first"] + places]] = False
    return int(np.argmax(lost))


@inlined
def is_lost(grid: Grid) -> bool:
    """Return whether a voltage is not a number in this part; those of refractory rows are NaN by design."""
    n = 0
    for k in range(len(grid.runs)):
        run = grid.runs[k]
        n -= run.n_waiting
        for row in range(run.first, run.last):
            n += not isfinite(grid.state[V, row])
    return n > 0


@jit
def _read_cells(cells: Array, indices: IntArray, variable: int, now: float, out: FloatArray) -> None:
    for k in range(len(indices)):
        if indices[k] >= 0:
            out[k] = _read_cell(cells[indices[k]], variable, now)


@inlined
def _read_cell(cell: Cell, variable: int, now: float) -> float:
    if variable == 0:
        return voltage_at(cell, now)
    if variable <= _LAST_OF_CURVED:
        return state_at(cell, 1, now)
    return remaining_at(cell, variable - 1 - _LAST_OF_CURVED, now - cell.t)


@jit
def sampled(grid: Grid, probe: Probe, step: int) -> None:
    """Store what :func:`read` returns at a step, for the rows of this part."""
    first, last, now = grid.runs[0].first, grid.runs[-1].last, step * grid.clock[0].h
    out = probe.sample + probe.taken * probe.n_rows
    if probe.plain:
        row = grid.probe_rows[probe.row]
        begin, end = max(first - row, 0), min(last - row, probe.n_rows)
        own = grid.probe_rest[:, probe.row + begin : probe.row + max(begin, end)]
        _store_voltages(grid.state[V, row + begin :], own, grid.samples[out + begin :])
        return
    inhibitory = probe.variable == _LAST_OF_CURVED + 2
    for k in range(probe.n_rows):
        row = grid.probe_rows[probe.row + k]
        if not first <= row < last:
            continue
        if grid.probe_values[0, probe.row + k] >= 0:
            place = int(grid.probe_values[0, probe.row + k])
            value = grid.values[place] / grid.probe_values[1, probe.row + k]
        elif grid.cell_rows[row] >= 0:
            value = _read_cell(grid.cells[grid.cell_rows[row]], probe.variable, now)
        elif probe.variable > 0:
            value = grid.state[X + inhibitory, row]
        elif isnan(grid.state[V, row]):
            value = grid.probe_rest[1, probe.row + k]
        else:
            value = grid.probe_rest[0, probe.row + k] + grid.state[V, row]
        grid.samples[out + k] = value


@jit
def _store_voltages(above_rest: Array, rest: Array, out: Array) -> None:
    """Store voltages; those above rest are not numbers while refractory. The loop compiles to vector code."""
    for k in range(rest.shape[1]):
        out[k] = rest[1, k] if isnan(above_rest[k]) else rest[0, k] + above_rest[k]


_NONE = {
    "probes": np.empty(0, Probe.dtype()), "probe_steps": np.empty(0, np.int64),
    "probe_rows": np.empty(0, np.int64), "probe_values": np.empty((2, 0)), "probe_rest": np.empty((2, 0)),
    "samples": np.empty(0),
}  # fmt: skip


def no_probes() -> dict[str, Array]:
    """Return the arrays of a grid that records nothing."""
    return dict(_NONE)


def load_probes(
    grid: Grid,
    network: Network,
    traces: Sequence[Trace],
    samples: FloatArray,
    row_of: IntArray,
    times: TimeGrid,
) -> dict[str, Array]:
    """Return the arrays of a grid that stores the samples of traces, one trace after another."""
    probes = np.zeros(len(traces), Probe.dtype())
    places = [places_of(grid, network, row_of[trace.neurons], trace.variable) for trace in traces]
    probes["variable"] = [
        reading_of(trace.variable) if (own < 0).any() else -1
        for trace, (own, _) in zip(traces, places, strict=True)
    ]
    shapes = np.array([trace.shape for trace in traces])
    probes["n_steps"], probes["n_rows"] = shapes.T
    for name, sizes in (("step", shapes[:, 0]), ("row", shapes[:, 1]), ("sample", shapes.prod(axis=1))):
        probes[name] = np.cumsum(sizes) - sizes
    rows = row_of[np.concatenate([trace.neurons for trace in traces])]
    probes["plain"] = [
        trace.variable == "v" and (own < 0).all() and _are_plain(grid, row_of[trace.neurons])
        for trace, (own, _) in zip(traces, places, strict=True)
    ]
    runs = grid.runs[np.searchsorted(grid.runs["first"], rows, "right") - 1]
    return {
        "probes": probes,
        "probe_steps": np.concatenate([trace.times_ns for trace in traces]) // times.step_ns,
        "probe_rows": rows,
        "probe_values": np.concatenate([np.stack(both).astype(float) for both in places], axis=1),
        "probe_rest": np.stack([runs["v_rest"], runs["v_rest"] + runs["reset"]]),
        "samples": samples,
    }


def _are_plain(grid: Grid, rows: IntArray) -> bool:
    """Return whether rows follow each other, and all of their neurons advance in a loop."""
    return bool((np.diff(rows) == 1).all() and (grid.cell_rows[rows] < 0).all())


def take_samples(places: Array, step: int) -> int:
    """Take the samples that are due at a step, of the rows of this part."""
    grid = opened(Grid, places)
    for k in range(len(grid.probes)):
        probe = grid.probes[k]
        if probe.taken < probe.n_steps and grid.probe_steps[probe.step + probe.taken] == step:
            sampled(grid, probe, step)
            probe.taken += 1
    return 0
