"""Builds, enlarges and copies the grid of a network.

Changes of cells of the grid between two runs.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from nrp_brain_event.cells import load_cells, with_parameters
from nrp_brain_event.connections import load_plastic
from nrp_brain_event.engine import chain_free, doubled
from nrp_brain_event.grid.couplings import no_couplings, with_couplings
from nrp_brain_event.grid.equations import blocks as equations
from nrp_brain_event.grid.equations.blocks import load_blocks
from nrp_brain_event.grid.inputs import no_inputs
from nrp_brain_event.grid.on_demand import codes_for
from nrp_brain_event.grid.poisson import load_noise
from nrp_brain_event.grid.readout import no_probes
from nrp_brain_event.grid.records import BLOCK, CHANGING, CURVED, Grid, GridClock, Memory, Pool, S, V
from nrp_brain_event.grid.tables import input_lines, load_runs, load_state, load_tables
from nrp_brain_event.neuron import move
from nrp_brain_event.records import ALPHA, START, Array, CellParameters, Event, Spike, Work
from nrp_core._support.arrays import FloatArray, IntArray, aligned_copy
from nrp_core._support.jit import jit
from nrp_core.network.changes import ParameterChange
from nrp_core.network.data import Network, Projection
from nrp_core.network.grid import Grid as TimeGrid
from nrp_core.network.limits import distinct


def change_cells(
    grid: Grid, cells: Array, network: Network, change: ParameterChange, row_of: IntArray
) -> tuple[Grid, Array]:
    """Return the grid and the ``Cell`` in each row under other parameters from now on.

    The state of neurons stays: voltages, synaptic variables, ends of refractory periods.

    Raises:
        NetworkError: a parameter is impossible.
    """
    first_id = network.offsets[change.label]
    rows = row_of[first_id + change.index]
    if network.populations[change.label].equations is not None:
        grid, cells = equations.with_parameters(grid, network, change), cells.copy()
        every = row_of[network.ids_of(change.label)]
        cells["i_offset"][every] = equations.offsets_na(grid, network, change.label)
        return grid, cells
    changed = with_parameters(cells[rows], network.populations[change.label], change.values, first_id)
    before, cells = cells, cells.copy()
    for name in CellParameters.dtype().names or ():
        cells[name][rows] = changed[name]
    own = grid.cell_rows[rows]
    if (own >= 0).all():
        _begin_anew(grid.cells, own, float(grid.clock["step"][0] * grid.clock["h"][0]))
        for name in CellParameters.dtype().names or ():
            grid.cells[name][own] = changed[name]
        return grid, cells
    state = grid.state.copy()
    state[V] += before["v_rest"] - cells["v_rest"]
    alpha = cells["synapse"] == ALPHA
    state[S : S + 2, alpha] *= (cells["tau_syn"] / before["tau_syn"]).T[:, alpha]
    return with_runs(grid._replace(state=state), load_runs(cells, float(grid.clock["h"][0]))), cells


def offsets_of(grid: Grid, cells: Array) -> FloatArray:
    """Return the constant current into each row, nA; 0 for rows that are integrated one by one."""
    offsets: FloatArray = np.where(grid.cell_rows < 0, cells["i_offset"], 0.0)
    return offsets


def with_runs(grid: Grid, runs: Array) -> Grid:
    """Return the grid with its neurons in other runs; refractory ones go on waiting."""
    queue, old = grid.queue.copy(), grid.runs[grid.runs["n_waiting"] > 0]
    places = [
        run["first"] + (run["head"] + np.arange(run["n_waiting"])) % (run["last"] - run["first"])
        for run in old
    ]
    waiting = grid.queue[np.concatenate([np.empty(0, np.int64), *places])]
    waiting = waiting[np.argsort(grid.release[waiting], kind="stable")]
    of = np.searchsorted(runs["first"], waiting, "right") - 1
    for r in np.unique(of):
        mine = waiting[of == r]
        runs["n_waiting"][r] = len(mine)
        queue[runs["first"][r] : runs["first"][r] + len(mine)] = mine
    return grid._replace(runs=runs, queue=queue)


@jit
def _begin_anew(cells: Array, rows: IntArray, now: float) -> None:
    """Advance cells to the present time, and schedule their updates again."""
    for k in range(len(rows)):
        cell = cells[rows[k]]
        move(cell, now)
        cell.on_wake, cell.wake = START, now


_ROOM: Final = 1024
_LONGEST_WINDOW: Final = 1000
"""Steps; with longer windows too many spikes would wait."""


def build_grid(
    network: Network, tolerance_mv: float, times: TimeGrid, drawn: frozenset[str]
) -> tuple[Grid, Array, IntArray]:
    """Return the grid of a network at time 0, the ``Cell`` in each row, and the row of each global id.

    Args:
        network: the network.
        tolerance_mv: largest local error of integration steps of curved neurons.
        times: the time grid.
        drawn: labels of the Poisson populations that the grid draws itself.

    Raises:
        NetworkError: the network has invalid parameters or delays.
    """
    cells, row_of = load_cells(network, tolerance_mv)
    tables = load_tables(network, cells, row_of, times, labels_from(network, drawn))
    runs = load_runs(cells, times.step_ms)
    curved = np.repeat(runs["kind"] == CURVED, runs["last"] - runs["first"])
    clock = np.zeros(1, GridClock.dtype())
    clock["h"], clock["step_ns"], clock["failed"], clock["free"] = times.step_ms, times.step_ns, -1, -1
    clock["window"] = shortest_delay(tables, cells["id"])
    state = load_state(cells)
    longest = int(np.max(tables["segments"]["gap"], initial=1))
    grid = Grid(
        clock=clock,
        runs=runs,
        state=state,
        drive=cells["i_offset"].copy(),
        ids=cells["id"].copy(),
        queue=np.zeros(len(cells), np.int32),
        release=np.zeros(len(cells), np.int64),
        cells=cells[curved],
        cell_rows=np.where(curved, np.cumsum(curved) - 1, -1),
        work=np.zeros(1, Work.dtype()),
        **load_blocks(network, row_of, times.step_ms),
        codes=np.empty(0, np.int64),
        scratch=np.zeros((4, BLOCK)),
        fired=np.zeros(len(cells), np.int32),
        **tables,
        **_load_plastic(network, row_of, times, len(cells)),
        slots=np.full(1 << longest.bit_length(), -1, np.int32),
        entry_segment=np.empty(0, np.int32),
        entry_after=np.empty(0, np.int32),
        outbox=np.empty((2, 0), np.int64),
        spikes=np.empty(0, Spike.dtype()),
        sources=no_inputs(),
        arrivals=no_inputs(),
        lines=input_lines(runs, state).take(row_of if len(cells) else [], axis=1),
        **load_noise(network, cells, row_of, times, drawn),
        **no_couplings(),
        **no_probes(),
    )
    grid = with_couplings(grid, cells, network, row_of)
    return enlarged(grid._replace(codes=codes_for(grid))), cells, row_of


def shortest_delay(tables: dict[str, Array], neurons: IntArray) -> int:
    """Return the shortest delay of spikes from neurons (global ids), in steps."""
    first = tables["row_first"]
    sending = neurons[first[neurons] < first[neurons + 1]]
    return int(np.min(tables["segments"]["gap"][first[sending]], initial=_LONGEST_WINDOW))


def labels_from(network: Network, populations: frozenset[str]) -> frozenset[str]:
    """Return the labels of the projections that begin in populations."""
    return frozenset(projection.label for projection in network.projections if projection.pre in populations)


def _load_plastic(network: Network, row_of: IntArray, times: TimeGrid, n_rows: int) -> dict[str, Array]:
    on_grid = [_rounded(p, times) for p in network.projections if p.is_plastic]
    tables = load_plastic(network, on_grid, row_of)
    memories = np.zeros(n_rows if len(tables["plastic"]) else 0, Memory.dtype())
    memories["first_stored"] = memories["last_stored"] = -1
    pool, stored = np.zeros(1, Pool.dtype()), np.zeros(max(2 * len(memories), 1), Event.dtype())
    chain_free(pool, stored, 0)
    return {**tables, "memories": memories, "stored": stored, "pool": pool}


def _rounded(projection: Projection, times: TimeGrid) -> Projection:
    """Return a projection with its delays on the grid."""
    delays = times.time_ms(times.delays(np.array(distinct(projection.delay_ms))))
    return replace(projection, delay_ms=np.broadcast_to(delays, projection.size))


def enlarged(grid: Grid) -> Grid:
    """Return the grid with more room for spikes, calendar entries and stored spikes."""
    clock, n = grid.clock, len(grid.entry_after)
    n_entries = 2 * max(n, len(grid.drive), _ROOM)
    after = np.arange(1, n_entries + 1, dtype=np.int32)
    after[:n], after[-1] = grid.entry_after, clock["free"][0]
    segments = np.zeros(n_entries, np.int32)  # zeros, because snapshots contain also the unused entries
    segments[:n] = grid.entry_segment
    clock["free"] = n
    clock["n_free"] += n_entries - n
    if grid.pool["n_free"][0] < len(grid.memories):
        n_stored, grid = len(grid.stored), grid._replace(stored=doubled(grid.stored))
        chain_free(grid.pool, grid.stored, n_stored)
    n_spikes, n_out = len(grid.spikes), grid.outbox.shape[1]
    spikes = np.zeros(2 * max(n_spikes, len(grid.drive), _ROOM), Spike.dtype())
    outbox = np.zeros((2, 2 * max(n_out, len(grid.drive), _ROOM)), np.int64)
    spikes[:n_spikes], outbox[:, :n_out] = grid.spikes, grid.outbox
    return grid._replace(spikes=spikes, outbox=outbox, entry_after=after, entry_segment=segments)


def changing(grid: Grid, without: frozenset[str] = frozenset()) -> dict[str, Array]:
    """Return copies of all arrays that change while running, by name; ``without`` some."""
    return {name: aligned_copy(getattr(grid, name)) for name in CHANGING if name not in without}
