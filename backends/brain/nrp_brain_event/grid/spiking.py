"""Advance runs of neurons by one step: end refractory periods, update all, fire those above threshold."""

from __future__ import annotations

from math import nan
from typing import Final

from nrp_brain_event.grid.membranes import update_block
from nrp_brain_event.grid.records import BLOCK, GridClock, Run, V, X
from nrp_brain_event.records import Array
from nrp_core._support.jit import inlined, jit

_FEW: Final = 32


@inlined
def update_run(
    clock: GridClock, run: Run, state: Array, drive: Array, scratch: Array,
    queue: Array, release: Array, fired: Array, step: int,
) -> None:  # fmt: skip
    """Advance a run and add the rows that fire to ``fired``."""
    v = state[V]
    while run.n_waiting > 0 and release[queue[run.first + run.head]] == step:
        row = queue[run.first + run.head]
        v[row] = run.reset
        if run.frozen:  # what has arrived since the spike is lost
            state[X, row] = state[X + 1, row] = 0.0
        run.n_waiting -= 1
        run.head = run.head + 1 if run.first + run.head + 1 < run.last else 0
    for a in range(run.first, run.last, BLOCK):
        b = min(a + BLOCK, run.last)
        if update_block(run, state, drive, scratch, a, b) > 0:
            for c in range(a, b, _FEW):
                last = min(c + _FEW, b)
                if _n_above(v[c:last], run.threshold) > 0:
                    for row in range(c, last):
                        if v[row] >= run.threshold:
                            fired[clock.n_fired] = row
                            clock.n_fired += 1
                            _reset(run, v, queue, release, row, step)


@jit
def _n_above(v: Array, threshold: float) -> int:
    n = 0
    for i in range(len(v)):
        n |= v[i] >= threshold
    return n


@jit
def _reset(run: Run, v: Array, queue: Array, release: Array, row: int, step: int) -> None:
    """Reset a neuron that has fired; the voltage of a refractory one is NaN until the period ends."""
    if run.refractory == 0 and not run.frozen:
        v[row] = run.reset
        return
    v[row] = nan
    size = run.last - run.first
    place = run.head + run.n_waiting
    place = place if place < size else place - size
    release[row] = step + run.refractory + 1
    for _ in range(run.n_waiting):  # neurons with longer refractory periods at that time stay in the queue
        before = place - 1 if place > 0 else size - 1
        if release[queue[run.first + before]] <= release[row]:
            break
        queue[run.first + place] = queue[run.first + before]
        place = before
    queue[run.first + place] = row
    run.n_waiting += 1
