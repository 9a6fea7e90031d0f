"""The operations on one neuron of the lazy grid: advance it to a step, deliver input, watch it.

The data of the lazy grid; connections, calendar and spikes are those of the :class:`Grid`.

Neurons of the lazy grid as the plain grid would hold them, without moving them.

Changes of the lazy grid between two runs.
"""

from __future__ import annotations

from math import nan
from typing import Annotated, Final, NamedTuple

import numpy as np

from nrp_brain_event.grid import records as grid_records
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.handles import call, opened
from nrp_brain_event.records import Array, Record, Short, constant
from nrp_core._support.jit import inlined, jit

# Columns of the course of a neuron over some steps.
LEAK: Final = 0
KEPT: Final = 1
X_EFFECT: Final = 2
S_EFFECT: Final = 3
SECOND: Final = 3
"""Distance to the columns of the inhibitory receptor."""
N_COURSE: Final = 7
DEPTH: Final = 1024
"""Number of steps for which courses are tabulated; longer ones are put together."""
NONE: Final = -1
IN_LIST: Final = 1 << 20
"""What is subtracted from the number of a block while a neuron is in its list."""
# Purposes for which cells with equations are advanced.
LOOK: Final = constant(0)
"""Spikes arrive, and cells fire; rows that cannot reach the threshold are marked as ``-1 - row``."""
SHOW: Final = constant(1)
"""Only what the plain grid would hold is written."""
MOVE: Final = constant(2)
"""Cells only advance, before their current changes."""


class Neuron(Record):
    """A neuron at its last event: 64 bytes, of which an arrival needs the first 48."""

    v: float
    """Voltage above rest, mV."""
    step: int
    """The step at which this held."""
    free: int
    """The last step of its refractory period."""
    kind: Short
    listed: Short
    """Whether it is in a list of those that may reach the threshold."""
    x: Annotated[Array, (2,)]
    """Input of both receptors as in the grid, one if they decay alike; for jumps, the input of this step."""
    s: Annotated[Array, (2,)]


class Kind(Record):
    """Neurons with equal parameters, see :class:`~nrp_brain_event.grid.records.Run`."""

    jump: int
    alpha: int
    frozen: int
    single: int
    """Whether the inputs of both receptors decay alike and are one."""
    simple: int
    """Whether the input is one, and exponential."""
    refractory: int
    reset: float
    threshold: float
    resistance: float
    """MOhm."""
    grown: Annotated[Array, (2,)]
    x_peak: Annotated[Array, (2,)]
    s_peak: Annotated[Array, (2,)]
    """The highest voltage to which a unit of x or s alone leads."""
    course: int
    """First row of its courses."""


class LazyBlock(Record):
    """A :class:`~nrp_brain_event.grid.records.Block`; see :mod:`nrp_brain_event.grid.lazy_blocks`."""

    code: int
    """Its kernel, see :func:`~nrp_brain_event.handles.call`."""
    state: int
    """The first of its ``states``."""
    width: int
    """Length of the state of a cell, which begins with what arrives at each receptor."""
    first: int
    n_listed: int
    """Its first row, from which on its list is in ``listed``, and the length of this list."""


class LazyClock(Record):
    """Counts of the lazy grid."""

    n_early: int
    n_late: int
    """Neurons without equations in the lists of those that may reach the threshold."""
    driven: int
    """Whether any neuron has a constant current."""
    n_arrived: int
    n_checked: int
    """Arrivals, and steps of single neurons, since the last judgement of the costs."""
    costly: int
    """How many judgements in succession found the plain grid cheaper."""


class Lazy(NamedTuple):
    """All arrays of the lazy grid.

    Args:
        clock: ``LazyClock``, shape ``(1,)``.
        kinds: ``Kind``.
        neurons: ``Neuron`` in each row.
        courses: factors of the state after 0, 1, ... steps, ``DEPTH`` rows for each kind of cell.
        early, late: rows that may reach the threshold: those that advance before the arrivals of a step, and
            those on which they act at once.
        blocks: ``LazyBlock``.
        owners: the block of each row; less :data:`IN_LIST` while it is in the list, -1 for other neurons.
        listed: equation rows to examine, by block.
        states, factors: of these, see :mod:`nrp_brain_event.grid.equations.lazy_source`.
        shown: room for a row.
    """

    clock: Annotated[Array, LazyClock]
    kinds: Annotated[Array, Kind]
    neurons: Annotated[Array, Neuron]
    courses: Annotated[Array, np.float64, 2]
    early: Annotated[Array, np.int32]
    late: Annotated[Array, np.int32]
    blocks: Annotated[Array, LazyBlock]
    owners: Annotated[Array, np.int32]
    listed: Annotated[Array, np.int32]
    states: Annotated[Array, np.float64]
    factors: Annotated[Array, np.float64]
    shown: Annotated[Array, np.int32]


CHANGING: Final = ("clock", "neurons", "early", "late", "blocks", "owners", "listed", "states")
"""The parts that change while running."""


_MARGIN_MV: Final = 1e-9
"""Distance from the threshold within which rounding errors could matter."""
_STATE_S: Final = grid_records.S


@inlined
def bring(neuron: Neuron, courses: Array, kind: Kind, current: float, step: int) -> None:
    """Bring a neuron to a step that is not before its last one."""
    elapsed = step - neuron.step
    if elapsed == 0:
        return
    if kind.simple and current == 0.0 and elapsed < DEPTH and neuron.free <= neuron.step:
        at, x = kind.course + elapsed, neuron.x[0]
        neuron.v = neuron.v * courses[at, LEAK] + x * courses[at, X_EFFECT]
        neuron.x[0] = x * courses[at, KEPT]
        neuron.step = step
    else:
        _move(neuron, courses, kind, current, step)


@jit
def _move(neuron: Neuron, courses: Array, kind: Kind, current: float, step: int) -> None:
    if kind.jump:
        neuron.v += neuron.x[0]
        neuron.x[0] = 0.0
    if neuron.step < neuron.free:
        held = min(neuron.free, step) - neuron.step
        voltage = neuron.v
        _flow(neuron, courses, kind, 0.0, held)
        neuron.v = voltage
        neuron.step += held
    _flow(neuron, courses, kind, current, step - neuron.step)
    neuron.step = step


@jit
def _flow(neuron: Neuron, courses: Array, kind: Kind, current: float, steps: int) -> None:
    """Let a neuron follow its course for some steps."""
    while steps > 0:
        n = min(steps, DEPTH - 1)
        steps -= n
        at = kind.course + n
        leak = courses[at, LEAK]
        v = neuron.v * leak
        if current != 0.0:
            v += current * kind.resistance * (1.0 - leak)
        if not kind.jump:
            for k in range(2 - kind.single):
                x, j = neuron.x[k], k * SECOND
                v += x * courses[at, X_EFFECT + j]
                if kind.alpha:
                    s = neuron.s[k]
                    v += s * courses[at, S_EFFECT + j]
                    x += s * kind.grown[k] * n
                    neuron.s[k] = s * courses[at, KEPT + j]
                neuron.x[k] = x * courses[at, KEPT + j]
        neuron.v = v


@inlined
def receive(lazy: Lazy, current: float, row: int, variable: int, weight: float, step: int) -> None:
    """Deliver an input to a variable of the state of the plain grid, now.

    Args:
        lazy: the lazy grid.
        current: constant current into the neuron, nA.
        row: its row.
        variable: row of the state.
        weight: of the input.
        step: the present one.
    """
    if len(lazy.blocks) > 0 and lazy.owners[row] != NONE:
        block = enlisted(lazy, row)
        lazy.states[block.state + (row - block.first) * block.width + variable - grid_records.X] += weight
        return
    neuron = lazy.neurons[row]
    kind = lazy.kinds[neuron.kind]
    bring(neuron, lazy.courses, kind, current, step)
    if step <= neuron.free and (kind.jump or kind.frozen):
        return
    if kind.simple:
        neuron.x[0] += weight
    elif variable >= _STATE_S:
        neuron.s[(variable - _STATE_S) * (1 - kind.single)] += weight
    else:
        neuron.x[(variable - grid_records.X) * (1 - kind.single)] += weight
    if weight > 0.0 and not neuron.listed:
        watch(lazy, neuron, kind, row, current)


@inlined
def enlisted(lazy: Lazy, row: int) -> LazyBlock:
    """Add an equation neuron to the list of its block unless it is listed; return the block."""
    owner = lazy.owners[row]
    is_listed = owner < NONE
    block: LazyBlock = lazy.blocks[owner + IN_LIST if is_listed else owner]
    if is_listed:
        return block
    lazy.listed[block.first + block.n_listed] = row
    block.n_listed += 1
    lazy.owners[row] = owner - IN_LIST
    return block


@jit
def _highest(neuron: Neuron, kind: Kind, current: float) -> float:
    highest = max(neuron.v, current * kind.resistance)
    for k in range(2 - kind.single):
        highest += max(neuron.x[k], 0.0) * kind.x_peak[k]
        if kind.alpha:
            highest += max(neuron.s[k], 0.0) * kind.s_peak[k]
    return highest


@inlined
def may_fire(neuron: Neuron, kind: Kind, current: float) -> bool:
    """Return whether a neuron may reach the threshold without further input.

    Each input alone can raise the voltage by its peak at most, and the rest moves towards the voltage to
    which the current leads. A voltage that is not a number counts.
    """
    if kind.simple and current == 0.0:
        highest = max(neuron.v, 0.0) + max(neuron.x[0], 0.0) * kind.x_peak[0]
    else:
        highest = _highest(neuron, kind, current)
    return not highest < kind.threshold - _MARGIN_MV


@inlined
def watch(lazy: Lazy, neuron: Neuron, kind: Kind, row: int, current: float) -> None:
    """Add a neuron that may reach the threshold to the list of neurons that each step examines."""
    if may_fire(neuron, kind, current):
        clock = lazy.clock[0]
        neuron.listed = 1
        if kind.jump:
            lazy.late[clock.n_late] = row
            clock.n_late += 1
        else:
            lazy.early[clock.n_early] = row
            clock.n_early += 1


@jit
def show(places: Array, own: Array, row: int, step: int) -> None:
    """Write the present state of a neuron into that of the plain grid."""
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    if lazy.owners[row] != NONE:
        call(grid.codes[grid_records.ADVANCE_ROW], (places, own, row, step, SHOW))
        return
    state, before = grid.state, lazy.neurons[row : row + 1].copy()
    neuron = lazy.neurons[row]
    kind = lazy.kinds[neuron.kind]
    bring(neuron, lazy.courses, kind, grid.drive[row], step)
    is_held = step <= neuron.free and kind.refractory + kind.frozen > 0
    state[grid_records.V, row] = nan if is_held else neuron.v
    if kind.jump:
        state[grid_records.V, row] += neuron.x[0]
    else:
        for k in range(2 - kind.single):
            state[grid_records.X + k, row] = neuron.x[k]
            if kind.alpha:
                state[grid_records.S + k, row] = neuron.s[k]
    lazy.neurons[row : row + 1] = before


@jit
def show_all(places: Array, own: Array, rows: Array) -> None:
    """Write the present state of neurons into that of the plain grid."""
    step = opened(Grid, places).clock[0].step
    for k in range(len(rows)):
        show(places, own, rows[k], step)


@jit
def set_currents(places: Array, own: Array, currents: Array) -> None:
    """Set constant currents (nA, by row)."""
    grid, lazy = opened(Grid, places), opened(Lazy, own)
    step = grid.clock[0].step
    lazy.clock[0].driven = 0
    for row in range(len(currents)):
        if currents[row] != grid.drive[row] and lazy.owners[row] != NONE:
            call(grid.codes[grid_records.ADVANCE_ROW], (places, own, row, step, MOVE))
            enlisted(lazy, row)
            grid.drive[row] = currents[row]
        elif currents[row] != grid.drive[row]:
            neuron = lazy.neurons[row]
            kind = lazy.kinds[neuron.kind]
            bring(neuron, lazy.courses, kind, grid.drive[row], step)
            grid.drive[row] = currents[row]
            if not neuron.listed:
                watch(lazy, neuron, kind, row, currents[row])
        if currents[row] != 0.0:
            lazy.clock[0].driven = 1
