"""Advances the cells of a run that are given as equations."""

from __future__ import annotations

from nrp_brain_event.addresses import call
from nrp_brain_event.grid.equations.layout import length_of_row
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.handles import opened
from nrp_brain_event.records import Array
from nrp_core._support.jit import inlined

_S_PER_MS = 1e-3
_length_of_row = inlined(length_of_row)


def update_blocks(places: Array, number: int, step: int) -> int:
    """Advance a run to a grid point, apply the input there, and add the rows that fire to ``fired``."""
    grid = opened(Grid, places)
    clock, part = grid.clock[0], grid.runs[number]
    for k in range(len(grid.blocks)):
        block = grid.blocks[k]
        first, last = max(part.first, block.first), min(part.last, block.last)
        if first >= last:
            continue
        n_fired = call(
            block.code,
            (
                grid.values, grid.constants, grid.state, grid.drive, grid.fired, block.value, block.constant,
                _length_of_row(block.last - block.first), block.first, first - block.first,
                last - block.first, len(grid.drive), clock.n_fired, step, clock.h * _S_PER_MS,
            ),
        )  # fmt: skip
        if n_fired < 0:
            clock.failed = grid.ids[block.first - 1 - n_fired]
        else:
            clock.n_fired = n_fired
    return 0
