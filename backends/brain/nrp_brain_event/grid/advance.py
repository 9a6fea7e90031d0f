"""Advance the grid step by step.

In a step all neurons advance to the next grid point, then the inputs due there arrive, then neurons above
threshold fire. Membranes on which inputs act at once advance after these. Spikes of neurons are sent at the
end of a window that is shorter than all delays, so the parts of a grid are independent within a window.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_event.grid.curved import DIVERGED as CELL_DIVERGED
from nrp_brain_event.grid.curved import FIRED, set_cell_current, update_cell
from nrp_brain_event.grid.delivery import deliver, send, send_all, store_spike_of, transmitted
from nrp_brain_event.grid.equations.advance import update_blocks
from nrp_brain_event.grid.noise import add_noise, hear_noise
from nrp_brain_event.grid.probes import take_samples
from nrp_brain_event.grid.records import CURVED, EQUATIONS, JUMP, Grid, GridClock, Run, X
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
        places: places of the arrays of the grid, or of a part of it.
        sources: steps and global ids of the spikes of source cells, ascending, shape ``(2, n)``.
        inputs: steps and flat indices into the state of inputs outside the calendar, ascending, and the
            plastic synapse that determines the weight, or -1; shape ``(3, n)``.
        weights: weights of these, shape ``(n,)``.
        until: the step.

    Returns:
        ``DONE``; ``FULL`` if spikes or entries need more room (enlarge the arrays and call again);
        ``DIVERGED`` if a neuron cannot be integrated.
    """
    grid = opened(Grid, places)
    clock, lines = grid.clock[0], grid.state.reshape(-1)
    while clock.step < until:
        step = clock.step + 1
        if not accept(clock, grid, sources, step):
            return FULL
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
        emit(clock, grid, step, n_early)
        clock.step = step
        take_samples(grid, step)
    return DONE


@jit
def set_currents(places: Array, currents: Array) -> bool:
    """Set constant currents (nA, by row); false if a neuron cannot be integrated with its current."""
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
def accept(clock: GridClock, grid: Grid, sources: Array, step: int) -> bool:
    """Enter the spikes of neurons and sources into the calendar; false if there is no room for a step."""
    due = clock.n_sources
    while due < sources.shape[1] and sources[0, due] <= step:
        due += 1
    if clock.n_free < clock.n_out + due - clock.n_sources or grid.pool[0].n_free < len(grid.memories):
        return False
    if not _hear(clock, grid, step):
        return False
    if clock.step % clock.window == 0:
        send_all(clock, grid)
    while clock.n_sources < due:
        fired_at = max(sources[0, clock.n_sources], clock.step)  # entries before this step come first
        send(clock, grid, sources[1, clock.n_sources], fired_at)
        clock.n_sources += 1
    return True


@inlined
def _hear(clock: GridClock, grid: Grid, step: int) -> bool:
    """Store the spikes of recorded Poisson cells, if there is room for all of the step."""
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
    """Apply the inputs outside the calendar that are due at the rows of this part."""
    while clock.n_inputs < inputs.shape[1] and inputs[0, clock.n_inputs] <= step:
        line, synapse, weight = inputs[1, clock.n_inputs], inputs[2, clock.n_inputs], weights[clock.n_inputs]
        if grid.runs[0].first <= line % len(grid.drive) < grid.runs[-1].last:
            if synapse >= 0:
                weight = transmitted(grid, synapse, step * clock.h)
            lines[line] += weight
        clock.n_inputs += 1


@inlined
def _update(clock: GridClock, grid: Grid, when: int, step: int) -> None:
    """Advance the neurons that advance before the arrivals, or those that advance after them."""
    for r in range(len(grid.runs)):
        part = grid.runs[r]
        if (part.kind >= JUMP) == (when == _LATE):
            if part.kind == CURVED:
                _update_cells(clock, grid, part, step)
            elif part.kind == EQUATIONS:
                update_blocks(clock, grid, part, step)
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
def emit(clock: GridClock, grid: Grid, step: int, n_early: int) -> None:
    """Store the spikes of neurons that fire, and queue them to be sent."""
    for k in range(clock.n_fired):
        row = grid.fired[k]
        if len(grid.memories) > 0:
            store_spike_of(grid, row, step * clock.h)
        grid.spikes[0, clock.n_spikes], grid.spikes[1, clock.n_spikes] = step, grid.ids[row]
        grid.outbox[0, clock.n_out], grid.outbox[1, clock.n_out] = 2 * step + (k >= n_early), row
        clock.n_spikes += 1
        clock.n_out += 1
