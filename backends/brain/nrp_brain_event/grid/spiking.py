"""Advance runs of neurons by one step: end refractory periods, update all, fire those above threshold.

One step of leaky integrate-and-fire neurons, a block of equal ones at a time.

Current-based membranes advance by their exact propagators (Rotter & Diesmann 1999, Biological
Cybernetics 81:381). Conductance-based ones obey ``v' = a(t) v + b(t)`` with known a and b: the fourth-order
Magnus expansion, which needs the mean and the first moment of the conductances in the step (Blanes et
al. 2009, Physics Reports 470:151), with a Pade approximant of the exponential. The loops are simple so that
they are compiled to vector instructions.
"""

from __future__ import annotations

from math import nan
from typing import Final

from nrp_brain_event.grid.records import BLOCK, CONDUCTANCE, CURRENT, JUMP, GridClock, Run, S, V, X
from nrp_brain_event.records import Array
from nrp_core._support.jit import inlined, jit

_TINY: Final = 1e-250
"""Much smaller values become zero, because processors are slow with subnormal numbers."""
_FEW_NEURONS: Final = 16
"""Number of neurons up to which starting a loop costs more than its iterations."""


@inlined
def update_block(run: Run, state: Array, drive: Array, scratch: Array, a: int, b: int) -> int:
    """Advance rows a to b; return how many are at or above threshold."""
    if b - a <= _FEW_NEURONS:
        return _one_by_one(run, state, drive, a, b)
    v, current = state[V, a:b], drive[a:b]
    if run.kind == JUMP:
        return _jump(v, state[X, a:b], current, run.leak, run.gain, run.threshold)
    if run.kind == CURRENT and not run.alpha:
        return _linear_exponential(
            v, state[X, a:b], state[X + 1, a:b], current,
            run.leak, run.gain, run.kept[0], run.kept[1], run.x_effect[0], run.x_effect[1], run.threshold,
        )  # fmt: skip
    n = b - a
    effects = scratch[0, :n], scratch[1, :n]
    moments = scratch[2, :n], scratch[3, :n]
    if run.alpha:
        for k in range(2):
            x, s = state[X + k, a:b], state[S + k, a:b]
            _measure(x, s, effects[k], run.x_effect[k], run.s_effect[k])
            if run.kind == CONDUCTANCE:
                _measure(x, s, moments[k], run.x_moment[k], run.s_moment[k])
            _fade_alpha(x, s, run.kept[k], run.grown[k])
    else:
        for k in range(2):
            x = state[X + k, a:b]
            if run.kind == CONDUCTANCE:
                _scale(x, moments[k], run.x_moment[k])
            _fade(x, effects[k], run.kept[k], run.x_effect[k])
    if run.kind == CONDUCTANCE:
        return _conductance(
            v, effects[0], effects[1], moments[0], moments[1], current,
            run.leak, run.gain, run.reversal[0], run.reversal[1], run.threshold,
        )  # fmt: skip
    return _linear(v, effects[0], effects[1], current, run.leak, run.gain, run.threshold)


@inlined
def _one_by_one(run: Run, state: Array, drive: Array, a: int, b: int) -> int:
    """Compute the same as the loops below, one neuron at a time."""
    n = 0
    for i in range(a, b):
        v, current = state[V, i], drive[i]
        if run.kind == JUMP:
            new = _advanced(v, current, state[X, i], run.leak, run.gain)
            state[X, i] = 0.0
        else:
            x0, s0 = state[X, i], state[S, i]
            x1, s1 = state[X + 1, i], state[S + 1, i]
            effect0, effect1 = x0 * run.x_effect[0], x1 * run.x_effect[1]
            moment0, moment1 = x0 * run.x_moment[0], x1 * run.x_moment[1]
            if run.alpha:
                effect0, effect1 = effect0 + s0 * run.s_effect[0], effect1 + s1 * run.s_effect[1]
                moment0, moment1 = moment0 + s0 * run.s_moment[0], moment1 + s1 * run.s_moment[1]
                x0, x1 = x0 + s0 * run.grown[0], x1 + s1 * run.grown[1]
                state[S, i], state[S + 1, i] = _kept(s0, run.kept[0]), _kept(s1, run.kept[1])
            state[X, i], state[X + 1, i] = _kept(x0, run.kept[0]), _kept(x1, run.kept[1])
            if run.kind == CONDUCTANCE:
                new = _magnus(
                    v, effect0, effect1, moment0, moment1, current,
                    run.leak, run.gain, run.reversal[0], run.reversal[1],
                )  # fmt: skip
            else:
                new = _advanced(v, current, effect0 + effect1, run.leak, run.gain)
        n += new >= run.threshold
        state[V, i] = new
    return n


@inlined
def _advanced(v: float, drive: float, effect: float, leak: float, gain: float) -> float:
    """Return the voltage of a current-based membrane after a step."""
    return (v * leak + _TINY) - _TINY + drive * gain + effect


@inlined
def _magnus(
    v: float, g0: float, g1: float, m0: float, m1: float, drive: float,
    leak: float, gain: float, e0: float, e1: float,
) -> float:  # fmt: skip
    """Return the voltage of a conductance-based membrane after a step."""
    a = -(leak + g0 + g1)
    b = drive * gain + g0 * e0 + g1 * e1
    b -= (m0 + m1) * b + a * (m0 * e0 + m1 * e1)
    change = (a * v + b) / (1.0 + a * (a * (1.0 / 12.0) - 0.5))
    return (v + change + _TINY) - _TINY


@inlined
def _kept(x: float, share: float) -> float:
    """Return the remaining share of a synapse after a step."""
    return (x * share + _TINY) - _TINY


@jit
def _linear_exponential(
    v: Array, x0: Array, x1: Array, drive: Array,
    leak: float, gain: float, kept0: float, kept1: float, effect0: float, effect1: float, threshold: float,
) -> int:  # fmt: skip
    """Compute :func:`_fade` and :func:`_linear` in one loop."""
    n = 0
    for i in range(len(v)):
        new = _advanced(v[i], drive[i], x0[i] * effect0 + x1[i] * effect1, leak, gain)
        n += new >= threshold
        v[i] = new
        x0[i] = _kept(x0[i], kept0)
        x1[i] = _kept(x1[i], kept1)
    return n


@jit
def _linear(
    v: Array, plus: Array, minus: Array, drive: Array, leak: float, gain: float, threshold: float
) -> int:
    n = 0
    for i in range(len(v)):
        new = _advanced(v[i], drive[i], plus[i] + minus[i], leak, gain)
        n += new >= threshold
        v[i] = new
    return n


@jit
def _jump(v: Array, arrived: Array, drive: Array, leak: float, gain: float, threshold: float) -> int:
    n = 0
    for i in range(len(v)):
        new = _advanced(v[i], drive[i], arrived[i], leak, gain)
        n += new >= threshold
        v[i] = new
        arrived[i] = 0.0
    return n


@jit
def _conductance(
    v: Array, g0: Array, g1: Array, m0: Array, m1: Array, drive: Array,
    leak: float, gain: float, e0: float, e1: float, threshold: float,
) -> int:  # fmt: skip
    n = 0
    for i in range(len(v)):
        new = _magnus(v[i], g0[i], g1[i], m0[i], m1[i], drive[i], leak, gain, e0, e1)
        n += new >= threshold
        v[i] = new
    return n


@jit
def _measure(x: Array, s: Array, out: Array, of_x: float, of_s: float) -> None:
    for i in range(len(x)):
        out[i] = x[i] * of_x + s[i] * of_s


@jit
def _scale(x: Array, out: Array, by: float) -> None:
    for i in range(len(x)):
        out[i] = x[i] * by


@jit
def _fade(x: Array, out: Array, kept: float, effect: float) -> None:
    for i in range(len(x)):
        out[i] = x[i] * effect
        x[i] = _kept(x[i], kept)


@jit
def _fade_alpha(x: Array, s: Array, kept: float, grown: float) -> None:
    for i in range(len(x)):
        x[i] = _kept(x[i] + s[i] * grown, kept)
        s[i] = _kept(s[i], kept)


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
        if run.frozen:  # input since the spike is lost
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
