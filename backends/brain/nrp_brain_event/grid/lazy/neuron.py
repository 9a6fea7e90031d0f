"""The operations on one neuron of the lazy grid: bring it to a step, deliver to it, watch it."""

from __future__ import annotations

from typing import Final

from nrp_brain_event.grid import records as grid_records
from nrp_brain_event.grid.lazy.records import (
    DEPTH,
    KEPT,
    LEAK,
    S_EFFECT,
    SECOND,
    X_EFFECT,
    Kind,
    Lazy,
    Neuron,
)
from nrp_brain_event.records import Array
from nrp_core._support.jit import inlined, jit

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
    """Put a neuron that may reach the threshold into the list of those that are looked at in each step."""
    if may_fire(neuron, kind, current):
        clock = lazy.clock[0]
        neuron.listed = 1
        if kind.jump:
            lazy.late[clock.n_late] = row
            clock.n_late += 1
        else:
            lazy.early[clock.n_early] = row
            clock.n_early += 1
