"""The grid in motion: one step after another.

In a step all neurons advance to the next grid point, then everything arrives that is due there, then
those that have crossed their threshold fire. Membranes that arrivals move at once advance after them.
Spikes of neurons wait for the end of a window before which none of them arrives: in a window the parts
of a grid have nothing to do with each other.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_event.grid.curved import DIVERGED as CELL_DIVERGED
from nrp_brain_event.grid.curved import FIRED, set_cell_current, update_cell
from nrp_brain_event.grid.delivery import deliver, keep_in_mind, send, send_all, transmitted
from nrp_brain_event.grid.noise import add_noise, hear_noise
from nrp_brain_event.grid.records import CURVED, JUMP, Grid, GridClock, Run, X
from nrp_brain_event.grid.spiking import update_run
from nrp_brain_event.handles import opened
from nrp_brain_event.records import DIVERGED, DONE, FULL, Array, constant
from nrp_core._support.jit import inlined, jit

_EARLY: Final = constant(0)
_LATE: Final = constant(1)


@jit
def run(places: Array, sources: Array, inputs: Array, weights: Array, until: int) -> int:
    """Advance to a step.

    Args:
        places: of the arrays of the grid, or of a part of it.
        sources: steps and global ids of the spikes of source cells, ascending, shape ``(2, n)``.
        inputs: steps and flat indices into the state of what arrives apart from the calendar, ascending, and
            the plastic synapse that decides its weight, or -1; shape ``(3, n)``.
        weights: of these, shape ``(n,)``.
        until: the step.

    Returns:
        ``DONE``; ``FULL`` where spikes or entries need more room (give it and call again);
        ``DIVERGED`` where a neuron cannot be integrated.
    """
    grid = opened(Grid, places)
    clock, lines = grid.clock[0], grid.state.reshape(-1)
    while clock.step < until:
        step = clock.step + 1
        due = clock.n_sources
        while due < sources.shape[1] and sources[0, due] <= step:
            due += 1
        if clock.n_free < clock.n_out + due - clock.n_sources or grid.pool[0].n_free < len(grid.memories):
            return FULL
        if not _hear(clock, grid, step):
            return FULL
        if clock.step % clock.window == 0:
            send_all(clock, grid)
        while clock.n_sources < due:
            fired_at = max(sources[0, clock.n_sources], clock.step)  # earlier than this step where it is now
            send(clock, grid, sources[1, clock.n_sources], fired_at)
            clock.n_sources += 1
        clock.n_fired = 0
        _update(clock, grid, _EARLY, step)
        n_early = clock.n_fired
        deliver(clock, grid, lines, step)
        for k in range(len(grid.noise)):
            add_noise(grid.noise[k], grid, lines, step)
        _let_in(clock, grid, lines, inputs, weights, step)
        _update(clock, grid, _LATE, step)
        if clock.failed >= 0:
            return DIVERGED
        _emit(clock, grid, step, n_early)
        clock.step = step
    return DONE


@jit
def set_currents(places: Array, currents: Array) -> bool:
    """Hold these currents (nA, by row) from now on; false where a neuron cannot be integrated under it."""
    grid = opened(Grid, places)
    clock = grid.clock[0]
    for row in range(len(currents)):
        index = grid.cell_rows[row]
        if index < 0:
            grid.drive[row] = currents[row]
        elif not set_cell_current(grid.cells[index], grid.work[0], currents[row], clock.step * clock.h):
            clock.failed = grid.ids[row]
            return False
    return True


@inlined
def _hear(clock: GridClock, grid: Grid, step: int) -> bool:
    """Note the spikes of Poisson cells that somebody listens to, if there is room for all of the step."""
    n_before = clock.n_spikes
    for k in range(len(grid.noise)):
        if grid.noise[k].heard and not hear_noise(clock, grid.noise[k], grid, step):
            clock.n_spikes = n_before
            return False
    room = min(grid.spikes.shape[1] - clock.n_spikes, grid.outbox.shape[1] - clock.n_out)
    if room < len(grid.fired):
        clock.n_spikes = n_before
        return False
    return True


@inlined
def _let_in(clock: GridClock, grid: Grid, lines: Array, inputs: Array, weights: Array, step: int) -> None:
    """Let arrive what is due apart from the calendar at the rows of this part."""
    while clock.n_inputs < inputs.shape[1] and inputs[0, clock.n_inputs] <= step:
        line, synapse, weight = inputs[1, clock.n_inputs], inputs[2, clock.n_inputs], weights[clock.n_inputs]
        if grid.runs[0].first <= line % len(grid.drive) < grid.runs[-1].last:
            if synapse >= 0:
                weight = transmitted(grid, synapse, step * clock.h)
            lines[line] += weight
        clock.n_inputs += 1


@inlined
def _update(clock: GridClock, grid: Grid, when: int, step: int) -> None:
    """Advance the neurons whose turn it is before the arrivals, or after them."""
    for r in range(len(grid.runs)):
        part = grid.runs[r]
        if (part.kind >= JUMP) == (when == _LATE):
            if part.kind == CURVED:
                _update_cells(clock, grid, part, step)
            else:
                update_run(
                    clock, part, grid.state, grid.drive, grid.scratch,
                    grid.queue, grid.release, grid.fired, step,
                )  # fmt: skip


@jit
def _update_cells(clock: GridClock, grid: Grid, part: Run, step: int) -> None:
    arrived, arrived_inhibition = grid.state[X], grid.state[X + 1]
    for row in range(part.first, part.last):
        cell = grid.cells[grid.cell_rows[row]]
        what = update_cell(cell, grid.work[0], arrived[row], arrived_inhibition[row], step * clock.h)
        arrived[row] = arrived_inhibition[row] = 0.0
        if what == CELL_DIVERGED:
            clock.failed = grid.ids[row]
        elif what == FIRED:
            grid.fired[clock.n_fired] = row
            clock.n_fired += 1


@inlined
def _emit(clock: GridClock, grid: Grid, step: int, n_early: int) -> None:
    """Let those that fire be reported, and their spikes wait to be sent."""
    for k in range(clock.n_fired):
        row = grid.fired[k]
        if len(grid.memories) > 0:
            keep_in_mind(grid, row, step * clock.h)
        grid.spikes[0, clock.n_spikes], grid.spikes[1, clock.n_spikes] = step, grid.ids[row]
        grid.outbox[0, clock.n_out], grid.outbox[1, clock.n_out] = 2 * step + (k >= n_early), row
        clock.n_spikes += 1
        clock.n_out += 1
