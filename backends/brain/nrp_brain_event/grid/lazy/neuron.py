"""The operations on one neuron of the lazy grid: bring it to a step, deliver to it, watch it."""

from __future__ import annotations

from typing import Final

from nrp_brain_event.grid import records as grid_records
from nrp_brain_event.grid.lazy.records import (
    DEPTH,
    FREE,
    KEPT,
    LEAK,
    S_EFFECT,
    SECOND,
    X_EFFECT,
    Kind,
    Lazy,
    S,
    T,
    V,
    X,
)
from nrp_brain_event.records import Array
from nrp_core._support.jit import inlined, jit

_MARGIN_MV: Final = 1e-9
"""Distance from the threshold within which rounding errors could matter."""
_STATE_S: Final = grid_records.S


@inlined
def bring(neurons: Array, courses: Array, kind: Kind, row: int, current: float, step: int) -> None:
    """Bring a neuron to a step that is not before its last one."""
    if neurons[row, T] != step:
        _move(neurons, courses, kind, row, current, step)


@jit
def _move(neurons: Array, courses: Array, kind: Kind, row: int, current: float, step: int) -> None:
    if kind.jump:
        neurons[row, V] += neurons[row, X]
        neurons[row, X] = 0.0
    if neurons[row, T] < neurons[row, FREE]:
        held = min(neurons[row, FREE], step) - neurons[row, T]
        voltage = neurons[row, V]
        _flow(neurons, courses, kind, row, 0.0, int(held))
        neurons[row, V] = voltage
        neurons[row, T] += held
    _flow(neurons, courses, kind, row, current, int(step - neurons[row, T]))
    neurons[row, T] = step


@jit
def _flow(neurons: Array, courses: Array, kind: Kind, row: int, current: float, steps: int) -> None:
    """Let a neuron follow its course for some steps."""
    while steps > 0:
        n = min(steps, DEPTH - 1)
        steps -= n
        at = kind.course + n
        leak = courses[at, LEAK]
        v = neurons[row, V] * leak
        if current != 0.0:
            v += current * kind.resistance * (1.0 - leak)
        if not kind.jump:
            for k in range(2 - kind.single):
                x, j = neurons[row, X + k], k * SECOND
                v += x * courses[at, X_EFFECT + j]
                if kind.alpha:
                    s = neurons[row, S + k]
                    v += s * courses[at, S_EFFECT + j]
                    x += s * kind.grown[k] * n
                    neurons[row, S + k] = s * courses[at, KEPT + j]
                neurons[row, X + k] = x * courses[at, KEPT + j]
        neurons[row, V] = v


@inlined
def receive(lazy: Lazy, drive: Array, row: int, variable: int, weight: float, step: int) -> None:
    """Deliver an input to a variable of the state of the plain grid, now."""
    neurons, kind, current = lazy.neurons, lazy.kinds[lazy.kind_of[row]], 0.0
    if lazy.clock[0].driven:
        current = drive[row]
    bring(neurons, lazy.courses, kind, row, current, step)
    if (kind.jump or kind.frozen) and step <= neurons[row, FREE]:
        return
    if variable >= _STATE_S:
        neurons[row, S + (variable - _STATE_S) * (1 - kind.single)] += weight
    else:
        neurons[row, X + (variable - grid_records.X) * (1 - kind.single)] += weight
    if weight > 0.0 and not lazy.listed[row]:
        watch(lazy, kind, row, current)


@jit
def may_fire(neurons: Array, kind: Kind, row: int, current: float) -> bool:
    """Return whether a neuron may reach the threshold without further input.

    Each input alone can raise the voltage by its peak at most, and the rest moves towards the voltage to
    which the current leads. A voltage that is not a number counts.
    """
    highest = max(neurons[row, V], current * kind.resistance)
    for k in range(2 - kind.single):
        highest += max(neurons[row, X + k], 0.0) * kind.x_peak[k]
        if kind.alpha:
            highest += max(neurons[row, S + k], 0.0) * kind.s_peak[k]
    return not highest < kind.threshold - _MARGIN_MV


@inlined
def watch(lazy: Lazy, kind: Kind, row: int, current: float) -> None:
    """Put a neuron that may reach the threshold into the list of those that are looked at in each step."""
    if may_fire(lazy.neurons, kind, row, current):
        clock = lazy.clock[0]
        lazy.listed[row] = True
        if kind.jump:
            lazy.late[clock.n_late] = row
            clock.n_late += 1
        else:
            lazy.early[clock.n_early] = row
            clock.n_early += 1
