"""Advance the grid step by step.

In a step all neurons advance to the next grid point, then the inputs due there arrive, then neurons above
threshold fire. Membranes on which inputs act at once advance after these. Spikes of neurons are sent at the
end of a window that is shorter than all delays, so the parts of a grid are independent within a window.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_event.grid.inputs import arrange
from nrp_brain_event.grid.readout import is_lost
from nrp_brain_event.grid.records import (
    ADD_NOISE,
    COUPLE,
    CURVED,
    DELIVER,
    DELIVER_LATE,
    EQUATIONS,
    FOLLOW,
    HEAR_NOISE,
    JUMP,
    SET_CURVED_CURRENT,
    STORE_FOR_PLASTIC,
    TAKE_SAMPLES,
    UPDATE_BLOCKS,
    UPDATE_CURVED,
    Grid,
    GridClock,
)
from nrp_brain_event.grid.spiking import update_run
from nrp_brain_event.grid.synapses import send, send_all, store
from nrp_brain_event.handles import call, opened
from nrp_brain_event.records import DIVERGED, DONE, FULL, Array, constant
from nrp_core._support.jit import inlined, jit

_EARLY: Final = constant(0)
_LATE: Final = constant(1)


@jit
def run(places: Array, until: int) -> int:
    """Advance to a step.

    Args:
        places: places of the arrays of the grid, or of a part of it whose inputs are arranged.
        until: the step.

    Returns:
        ``DONE``; ``FULL`` if spikes or entries need more room (enlarge the arrays and call again);
        ``DIVERGED`` if a neuron cannot be integrated, or its voltage is not a number in the end.
    """
    grid = opened(Grid, places)
    clock, lines = grid.clock[0], grid.state.reshape(-1)
    arrange(clock, grid.sources, grid.arrivals)
    while clock.step < until:
        step = clock.step + 1
        if not accept(clock, grid, places, step):
            return FULL
        clock.n_fired = 0
        if len(grid.coupled) > 0:
            call(grid.codes[COUPLE], (places,))
        _update(clock, grid, places, _EARLY, step)
        n_early = clock.n_fired
        if grid.slots[step & (len(grid.slots) - 1)] >= 0:
            call(grid.codes[DELIVER], (places, step))
        if len(grid.noise) > 0:
            call(grid.codes[ADD_NOISE], (places, step))
        _let_in(clock, grid, lines, places, step)
        _update(clock, grid, places, _LATE, step)
        if clock.failed >= 0:
            return DIVERGED
        emit(clock, grid, places, step, n_early)
        clock.step = step
        if len(grid.coupled) > 0:
            call(grid.codes[FOLLOW], (places, step))
        if len(grid.probes) > 0:
            call(grid.codes[TAKE_SAMPLES], (places, step))
    return DIVERGED if is_lost(grid) else DONE


@jit
def set_currents(places: Array, currents: Array) -> bool:
    """Set constant currents (nA, by row); false if a neuron cannot be integrated with its current."""
    grid = opened(Grid, places)
    clock = grid.clock[0]
    for row in range(len(currents)):
        if grid.cell_rows[row] < 0:
            grid.drive[row] = currents[row]
        elif call(grid.codes[SET_CURVED_CURRENT], (places, row, currents[row])) == 0:
            clock.failed = grid.ids[row]
            return False
    return True


@inlined
def accept(clock: GridClock, grid: Grid, places: Array, step: int) -> bool:
    """Enter the spikes of neurons and sources into the calendar; return false if a step's room is full."""
    due = clock.source
    while due < clock.n_sources and grid.sources[due].step <= step:
        due += 1
    if clock.n_free < clock.n_out + due - clock.source or grid.pool[0].n_free < len(grid.memories):
        return False
    if not _hear(clock, grid, places, step):
        return False
    if clock.n_out > 0 and clock.step % clock.window == 0:
        send_all(clock, grid)
    while clock.source < due:
        spike = grid.sources[clock.source]
        send(clock, grid, spike.target, spike.step)
        clock.source += 1
    return True


@inlined
def _hear(clock: GridClock, grid: Grid, places: Array, step: int) -> bool:
    """Store the spikes of recorded Poisson cells, if all spikes of the step fit."""
    n_before = clock.n_spikes
    if len(grid.noise) > 0 and call(grid.codes[HEAR_NOISE], (places, step)) == 0:
        clock.n_spikes = n_before
        return False
    room = min(len(grid.spikes) - clock.n_spikes, grid.outbox.shape[1] - clock.n_out)
    if room < len(grid.fired):
        clock.n_spikes = n_before
        return False
    return True


@inlined
def _let_in(clock: GridClock, grid: Grid, lines: Array, places: Array, step: int) -> None:
    """Apply the inputs outside the calendar that are due at the rows of this part."""
    while clock.arrival < clock.n_arrivals and grid.arrivals[clock.arrival].step <= step:
        arrival = grid.arrivals[clock.arrival]
        if grid.runs[0].first <= arrival.target % len(grid.drive) < grid.runs[-1].last:
            if arrival.synapse >= 0:
                call(grid.codes[DELIVER_LATE], (places, clock.arrival, step))
            else:
                lines[arrival.target] += arrival.weight
        clock.arrival += 1


@inlined
def _update(clock: GridClock, grid: Grid, places: Array, when: int, step: int) -> None:
    """Advance the neurons that advance before the arrivals, or those that advance after them."""
    for r in range(len(grid.runs)):
        part = grid.runs[r]
        if (part.kind >= JUMP) == (when == _LATE):
            if part.kind == CURVED:
                call(grid.codes[UPDATE_CURVED], (places, r, step))
            elif part.kind == EQUATIONS:
                call(grid.codes[UPDATE_BLOCKS], (places, r, step))
            else:
                update_run(
                    clock, part, grid.state, grid.drive, grid.scratch,
                    grid.queue, grid.release, grid.fired, step,
                )  # fmt: skip


@inlined
def emit(clock: GridClock, grid: Grid, places: Array, step: int, n_early: int) -> None:
    """Store the spikes of neurons that fire, and queue them to be sent."""
    for k in range(clock.n_fired):
        row = grid.fired[k]
        if len(grid.memories) > 0:
            call(grid.codes[STORE_FOR_PLASTIC], (places, row, step))
        store(clock, grid, grid.ids[row], step)
        grid.outbox[0, clock.n_out], grid.outbox[1, clock.n_out] = 2 * step + (k >= n_early), row
        clock.n_out += 1
