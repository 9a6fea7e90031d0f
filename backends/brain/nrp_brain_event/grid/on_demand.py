"""The kernels that only some networks need, each compiled when the first network needs it.

Compiled with the loop that all networks run, they would take half of the time of its first use.

Neurons without a closed form on the grid: adaptive exponential, Izhikevich, Hodgkin-Huxley.

Each is integrated as in the exact mode. Arrivals are on the grid. A threshold crossing resets the neuron at
its exact time; the spike gets the time of the next grid point, and there is at most one in a step.

Advances the cells of a run that are given as equations.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np

from nrp_brain_event.grid.couplings import couple, follow
from nrp_brain_event.grid.equations.layout import length_of_row
from nrp_brain_event.grid.lazy_blocks import advance_row, look_at_blocks
from nrp_brain_event.grid.poisson import add_noise, hear_noise
from nrp_brain_event.grid.readout import take_samples
from nrp_brain_event.grid.records import (
    ADD_NOISE,
    ADVANCE_ROW,
    COUPLE,
    CURVED,
    DELIVER,
    DELIVER_LATE,
    FOLLOW,
    HEAR_NOISE,
    LOOK_AT_BLOCKS,
    N_ON_DEMAND,
    PLASTIC,
    SET_CURVED_CURRENT,
    SHORT_TERM,
    STORE_FOR_PLASTIC,
    TAKE_SAMPLES,
    UPDATE_BLOCKS,
    UPDATE_CURVED,
    Grid,
    X,
)
from nrp_brain_event.grid.synapses import (
    deliver_every,
    deliver_late,
    deliver_plastic,
    deliver_short_term,
    deliver_static,
    store_for_plastic,
)
from nrp_brain_event.handles import address_of, call, opened
from nrp_brain_event.neuron import fire, move, plan
from nrp_brain_event.records import FIRE, HODGKIN_HUXLEY, Array, Cell, Work, constant
from nrp_brain_event.records import JUMP as JUMP_SYNAPSE
from nrp_brain_event.rise import arrive
from nrp_core._support.jit import inlined, jit

_QUIET: Final = constant(0)
_FIRED: Final = constant(1)
_DIVERGED: Final = constant(2)


def update_curved(places: Array, number: int, step: int) -> int:
    """Advance the neurons of a run to a grid point, apply their input, and list those that fire."""
    grid = opened(Grid, places)
    clock, run = grid.clock[0], grid.runs[number]
    arrived, arrived_inhibition = grid.state[X], grid.state[X + 1]
    for row in range(run.first, run.last):
        cell = grid.cells[grid.cell_rows[row]]
        what = _update_cell(cell, grid.work[0], arrived[row], arrived_inhibition[row], step * clock.h)
        arrived[row] = arrived_inhibition[row] = 0.0
        if what == _DIVERGED:
            clock.failed = grid.ids[row]
        elif what == _FIRED:
            grid.fired[clock.n_fired] = row
            clock.n_fired += 1
    return 0


def set_curved_current(places: Array, row: int, current: float) -> int:
    """Set the current (nA) into the neuron in a row from now on; 0 if it cannot be integrated."""
    grid = opened(Grid, places)
    clock, cell = grid.clock[0], grid.cells[grid.cell_rows[row]]
    if current == cell.current:
        return 1
    move(cell, clock.step * clock.h)
    cell.current = current
    return int(plan(cell, grid.work[0]))


@jit
def _update_cell(cell: Cell, work: Work, excitation: float, inhibition: float, t: float) -> int:
    """Advance a neuron to the grid point t (ms) and apply its input there; return the result."""
    what = _QUIET
    while cell.wake <= t:
        if cell.on_wake == FIRE:
            if what == _FIRED:
                break
            what = _FIRED
            fire(cell)
            if cell.membrane != HODGKIN_HUXLEY:  # without a reset, the spike itself goes on
                cell.free_at = max(cell.free_at, t)
        else:
            move(cell, cell.wake)
        if not plan(cell, work):
            return _DIVERGED
    if excitation != 0.0 or inhibition != 0.0:
        move(cell, t)
        if cell.synapse != JUMP_SYNAPSE:
            arrive(cell, 0, excitation)
            arrive(cell, 1, inhibition)
        elif t >= cell.free_at:
            cell.path[0, 0] += excitation + inhibition
        if not plan(cell, work):
            return _DIVERGED
    return what


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


Kernel = Callable[..., int]

_KERNELS: Final[dict[int, tuple[Kernel, tuple[str, ...]]]] = {
    UPDATE_BLOCKS: (update_blocks, ("int64", "int64")),
    UPDATE_CURVED: (update_curved, ("int64", "int64")),
    SET_CURVED_CURRENT: (set_curved_current, ("int64", "float64")),
    ADD_NOISE: (add_noise, ("int64",)),
    HEAR_NOISE: (hear_noise, ("int64",)),
    TAKE_SAMPLES: (take_samples, ("int64",)),
    DELIVER_LATE: (deliver_late, ("int64", "int64")),
    STORE_FOR_PLASTIC: (store_for_plastic, ("int64", "int64")),
    COUPLE: (couple, ()),
    FOLLOW: (follow, ("int64",)),
    LOOK_AT_BLOCKS: (look_at_blocks, ("*int64", "int64")),
    ADVANCE_ROW: (advance_row, ("*int64", "int64", "int64", "int64")),
}
"""Each with the types of its arguments after the ``places``."""
_DELIVER: Final = {
    (False, False): deliver_static,
    (True, False): deliver_short_term,
    (False, True): deliver_plastic,
    (True, True): deliver_every,
}
"""By whether there are synapses with short-term plasticity, and plastic ones."""


def codes_for(grid: Grid) -> Array:
    """Return the ``codes`` with which a grid begins."""
    is_plastic, needed = bool((grid.tables["dynamic"] == PLASTIC).any()), []
    if (grid.runs["kind"] == CURVED).any():
        needed += [UPDATE_CURVED, SET_CURVED_CURRENT]
    if len(grid.blocks):
        needed += [UPDATE_BLOCKS]
    if len(grid.noise):
        needed += [ADD_NOISE, HEAR_NOISE]
    if len(grid.coupled):
        needed += [COUPLE, FOLLOW]
    if is_plastic:
        needed += [STORE_FOR_PLASTIC]
    codes = with_kernels(np.zeros(N_ON_DEMAND, np.int64), *needed)
    is_released = bool((grid.tables["dynamic"] == SHORT_TERM).any())
    codes[DELIVER] = _code_of(_DELIVER[is_released, is_plastic], ("int64",))
    return codes


def with_kernels(codes: Array, *kernels: int) -> Array:
    """Return codes with further kernels."""
    codes = codes.copy()
    for kernel in kernels:
        codes[kernel] = _code_of(*_KERNELS[kernel])
    return codes


@cache
def _code_of(kernel: Kernel, arguments: tuple[str, ...]) -> int:
    return address_of(kernel, ("*int64", *arguments))
