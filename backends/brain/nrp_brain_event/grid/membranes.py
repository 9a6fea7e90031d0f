"""One step of leaky integrate-and-fire neurons, a block of equal ones at a time.

Current-based membranes advance by their exact propagators (Rotter & Diesmann 1999, Biological
Cybernetics 81:381). Conductance-based ones obey ``v' = a(t) v + b(t)`` with known a and b: the fourth-order
Magnus expansion, which needs the mean and the first moment of the conductances in the step (Blanes et
al. 2009, Physics Reports 470:151), with a Pade approximant of the exponential. The loops are simple so that
they are compiled to vector instructions.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_event.grid.records import CONDUCTANCE, CURRENT, JUMP, Run, S, V, X
from nrp_brain_event.records import Array
from nrp_core.jit import jit

_TINY: Final = 1e-250
"""What is far smaller becomes zero: processors are slow with the smallest numbers there are."""


@jit
def update_block(run: Run, state: Array, drive: Array, scratch: Array, a: int, b: int) -> int:
    """Advance rows a to b; return how many are at or above threshold."""
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


@jit
def _linear_exponential(
    v: Array, x0: Array, x1: Array, drive: Array,
    leak: float, gain: float, kept0: float, kept1: float, effect0: float, effect1: float, threshold: float,
) -> int:  # fmt: skip
    """Do in one loop what :func:`_fade` and :func:`_linear` do."""
    n = 0
    for i in range(len(v)):
        new = (v[i] * leak + _TINY) - _TINY + drive[i] * gain + (x0[i] * effect0 + x1[i] * effect1)
        n += new >= threshold
        v[i] = new
        x0[i] = (x0[i] * kept0 + _TINY) - _TINY
        x1[i] = (x1[i] * kept1 + _TINY) - _TINY
    return n


@jit
def _linear(
    v: Array, plus: Array, minus: Array, drive: Array, leak: float, gain: float, threshold: float
) -> int:
    n = 0
    for i in range(len(v)):
        new = (v[i] * leak + _TINY) - _TINY + drive[i] * gain + (plus[i] + minus[i])
        n += new >= threshold
        v[i] = new
    return n


@jit
def _jump(v: Array, arrived: Array, drive: Array, leak: float, gain: float, threshold: float) -> int:
    n = 0
    for i in range(len(v)):
        new = (v[i] * leak + _TINY) - _TINY + drive[i] * gain + arrived[i]
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
        a = -(leak + g0[i] + g1[i])
        b = drive[i] * gain + g0[i] * e0 + g1[i] * e1
        b -= (m0[i] + m1[i]) * b + a * (m0[i] * e0 + m1[i] * e1)
        change = (a * v[i] + b) / (1.0 + a * (a * (1.0 / 12.0) - 0.5))
        new = (v[i] + change + _TINY) - _TINY
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
        x[i] = (x[i] * kept + _TINY) - _TINY


@jit
def _fade_alpha(x: Array, s: Array, kept: float, grown: float) -> None:
    for i in range(len(x)):
        x[i] = ((x[i] + s[i] * grown) * kept + _TINY) - _TINY
        s[i] = (s[i] * kept + _TINY) - _TINY
