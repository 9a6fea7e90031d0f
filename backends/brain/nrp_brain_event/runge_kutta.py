"""Adaptive integration of one neuron: the method of Dormand & Prince (1980), order 5(4), dense output.

A step is as long as the tolerance allows, regardless of possible arrivals, and kept as a polynomial (Hairer,
Norsett & Wanner 1993, Solving Ordinary Differential Equations I, II.6). An arriving spike cuts it at its
exact time; reading the voltage evaluates it. So the trajectory of a neuron depends only on its events, not on
the division of the run.

The equations of the membranes that are integrated numerically (PyNN's standard cells).

Conductance-based integrate-and-fire; adaptive exponential (Brette & Gerstner 2005, J Neurophysiol
94:3637); Izhikevich (2003, IEEE Trans Neural Netw 14:1569); Hodgkin-Huxley with the rates of Traub &
Miles (1991, Neuronal Networks of the Hippocampus).
"""

from __future__ import annotations

from math import exp, expm1, inf
from typing import Final

import numpy as np

from nrp_brain_event.conductance import INTEGRAL, is_integral, length_below_threshold, voltage_after
from nrp_brain_event.records import (
    ADAPTIVE_EXPONENTIAL,
    CONDUCTANCE,
    HODGKIN_HUXLEY,
    STEP,
    Cell,
    Work,
    constant,
)
from nrp_brain_event.rise import POLYNOMIAL, first_rise, remaining_at, silent
from nrp_core._support.jit import inlined, jit

PER_NA: Final = 1000.0
"""PyNN's factor between nA and the unit of current of Izhikevich's model."""
_STEEPEST: Final = 200.0
"""Maximum exponent in a spike's upstroke: an integration step is refused well below it."""


@inlined
def slopes(cell: Cell, work: Work, s: int) -> None:
    """Store the derivatives of the state variables at stage s of a step, per ms, in ``work.stages``.

    The state is ``work.y``: v in mV, then w in nA, or u in mV/ms, or the gates m, h, n. The conductances of
    the synapses at that stage are in ``work.conductances``.
    """
    y, g, out = work.y, work.conductances, work.stages
    v = y[0]
    current = g[s, 0] * (cell.e_rev_E - v) + g[s, 1] * (cell.e_rev_I - v) + cell.i_offset + cell.current
    if cell.membrane == CONDUCTANCE:
        out[s, 0] = (cell.v_rest - v) * cell.leak + current * cell.per_cm
    elif cell.membrane == ADAPTIVE_EXPONENTIAL:
        _adaptive_exponential(cell, current, work, s)
    elif cell.membrane == HODGKIN_HUXLEY:
        _hodgkin_huxley(cell, current, work, s)
    else:
        out[s, 0] = (0.04 * v + 5.0) * v + 140.0 - y[1] + PER_NA * current
        out[s, 1] = cell.a * (cell.b * v - y[1])
    if cell.t < cell.free_at:
        out[s, 0] = 0.0


@jit
def _adaptive_exponential(cell: Cell, current: float, work: Work, s: int) -> None:
    v, w = work.y[0], work.y[1]
    above_rest = v - cell.v_rest
    upstroke = 0.0
    if cell.delta_T > 0.0:
        upstroke = cell.delta_T * exp(min((v - cell.v_thresh) / cell.delta_T, _STEEPEST))
    work.stages[s, 0] = (upstroke - above_rest) * cell.leak + (current - w) * cell.per_cm
    work.stages[s, 1] = (cell.a * 1e-3 * above_rest - w) / cell.tau_w  # a is in nS


@jit
def _hodgkin_huxley(cell: Cell, current: float, work: Work, s: int) -> None:
    y, out = work.y, work.stages
    v, m, h, n = y[0], y[1], y[2], y[3]
    sodium = cell.gbar_Na * m * m * m * h * (cell.e_rev_Na - v)
    potassium = cell.gbar_K * n * n * n * n * (cell.e_rev_K - v)
    leak = cell.g_leak * (cell.e_rev_leak - v)
    out[s, 0] = (sodium + potassium + leak + current) * cell.per_cm
    for gate in range(1, 4):
        opening, closing = gate_rates(gate, v - cell.v_offset)
        out[s, gate] = opening * (1.0 - y[gate]) - closing * y[gate]


@jit
def gate_rates(gate: int, v: float) -> tuple[float, float]:
    """Return the opening and closing rates, per ms, of gate m (1), h (2) or n (3) at ``v`` mV."""
    if gate == 1:
        return 0.32 * _linear_over_exponential(13.0 - v, 4.0), 0.28 * _linear_over_exponential(v - 40.0, 5.0)
    if gate == 2:
        return 0.128 * exp((17.0 - v) / 18.0), 4.0 / (exp((40.0 - v) / 5.0) + 1.0)
    return 0.032 * _linear_over_exponential(15.0 - v, 5.0), 0.5 * exp((10.0 - v) / 40.0)


@jit
def _linear_over_exponential(x: float, scale: float) -> float:
    """Return ``x / (exp(x / scale) - 1)`` and its limit at 0."""
    if x == 0.0:
        return scale
    return x / expm1(x / scale)


STAGES: Final = 7
"""Number of evaluations of the slopes in a step."""
_START: Final = constant(0)
NODES: Final = np.array([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1])
"""The times of the stages, in steps."""
WEIGHTS: Final = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
"""Weights of the stages before each stage; the last ones are those of order 5."""
ERROR: Final = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
"""Weights of the stages in the difference between the orders 5 and 4."""
_BEND: Final = np.array(
    [
        -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072,
        701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
    ]
)  # fmt: skip
"""Weights of the stages in the fourth-order part of the dense output."""
_VARIABLES: Final = np.array([1, 1, 2, 2, 4])
"""Number of state variables of each kind of membrane."""

_SAFETY: Final = 0.9
_SHRINK: Final = 0.2
_GROW: Final = 5.0
_AT_REST: Final = 1e-12
"""Rate of change, mV per ms, below which a neuron without input is at rest."""


@jit
def state_at(cell: Cell, variable: int, t: float) -> float:
    """Return a state variable at a time within the present step."""
    c = cell.path
    if cell.step == INTEGRAL:
        return float(voltage_after(cell, t - cell.t))
    x = (t - cell.t) / cell.step
    value = c[variable, 3] + x * c[variable, 4]
    for power in range(2, -1, -1):
        value = c[variable, power] + x * value
    return float(value)


@jit
def stand_at(cell: Cell, t: float) -> None:
    """Cut the present step at t; the next step starts from the state at t."""
    for variable in range(_VARIABLES[cell.membrane]):
        cell.path[variable, 0] = state_at(cell, variable, t)
        for power in range(1, 5):
            cell.path[variable, power] = 0.0
    cell.step = inf


@jit
def take_step(cell: Cell, work: Work) -> bool:
    """Take one step from the neuron's time; update next at its end, or never if the neuron is at rest.

    A cell with exponential conductances that stays below its threshold does so without stages.

    Returns:
        False if no step is short enough.
    """
    cell.on_wake, cell.wake, cell.step = STEP, inf, inf
    longest = cell.free_at - cell.t if cell.t < cell.free_at else inf
    if longest < inf and cell.membrane == CONDUCTANCE:  # all variables are clamped
        cell.wake = cell.free_at
        return True
    n = _VARIABLES[cell.membrane]
    for variable in range(n):
        work.y[variable] = cell.path[variable, 0]
    work.conductances[0, 0], work.conductances[0, 1] = cell.x[0], cell.x[1]
    slopes(cell, work, _START)
    if longest == inf and silent(cell) and _at_rest(cell, work, n):
        return True
    if is_integral(cell):
        step = length_below_threshold(cell)
        if step > 0.0:
            cell.step, cell.wake = INTEGRAL, cell.t + step
            return True
    step = min(min(cell.next_step, cell.longest_step), longest)
    while True:
        error = _try_step(cell, work, n, step)
        if error <= 1.0:
            break
        step *= max(_SHRINK, _SAFETY * error**-0.2) if error < inf else _SHRINK
        if step < cell.shortest_step:
            return False
    _keep(cell, work, n, step)
    cell.step = step
    cell.wake = cell.free_at if step == longest else cell.t + step
    if step < longest:
        cell.next_step = step * min(_GROW, _SAFETY * max(error, 1e-10) ** -0.2)
    return True


@jit
def rise_within_step(cell: Cell, work: Work) -> float:
    """Return the time within the present step at which the voltage rises to the threshold, or infinity."""
    c = cell.path
    if cell.step == INTEGRAL:
        return inf
    # the largest of the Bernstein coefficients is a bound on the polynomial
    bound = max(c[0, 0] + c[0, 1] / 4, c[0, 0] + c[0, 1] / 2 + c[0, 2] / 6)
    bound = max(bound, c[0, 0] + 3 * c[0, 1] / 4 + c[0, 2] / 2 + c[0, 3] / 4)
    bound = max(bound, c[0, 0] + c[0, 1] + c[0, 2] + c[0, 3] + c[0, 4])
    if bound < cell.threshold:
        return inf
    work.function[0] = c[0, 0] - cell.threshold
    for power in range(1, 5):
        work.function[power] = c[0, power]
    return cell.t + cell.step * first_rise(POLYNOMIAL, work, 1.0)


@inlined
def _try_step(cell: Cell, work: Work, n: int, step: float) -> float:
    """Compute the slopes at the later stages of a step; return its error, in units of the tolerance."""
    for k in range(2):
        for s in range(1, STAGES - 1):
            work.conductances[s, k] = remaining_at(cell, k, NODES[s] * step)
        work.conductances[6, k] = work.conductances[5, k]
    for s in range(1, STAGES):
        for variable in range(n):
            change = 0.0
            for j in range(s):
                change += WEIGHTS[s, j] * work.stages[j, variable]
            work.y[variable] = cell.path[variable, 0] + step * change
        slopes(cell, work, s)
    return _error(cell, work, n, step)


@inlined
def _error(cell: Cell, work: Work, n: int, step: float) -> float:
    """Return the largest local error among the state variables, in units of the tolerance."""
    largest = 0.0
    allowed = cell.tolerance
    for variable in range(n):
        error = 0.0
        for s in range(STAGES):
            error += ERROR[s] * work.stages[s, variable]
        error = abs(step * error) / allowed
        if not error <= largest:  # so that NaN counts as too large
            largest = error if error < inf else inf
        allowed = cell.tolerance * cell.scale
    return largest


@inlined
def _keep(cell: Cell, work: Work, n: int, step: float) -> None:
    """Store the step as a polynomial in the fraction of its length."""
    for variable in range(n):
        change = bend = 0.0
        for s in range(STAGES):
            bend += _BEND[s] * work.stages[s, variable]
        for s in range(STAGES - 1):
            change += WEIGHTS[6, s] * work.stages[s, variable]
        start = work.stages[0, variable] - change
        end = change - work.stages[6, variable] - start
        cell.path[variable, 1] = step * (change + start)
        cell.path[variable, 2] = step * (end - start + bend)
        cell.path[variable, 3] = -step * (end + 2.0 * bend)
        cell.path[variable, 4] = step * bend


@jit
def _at_rest(cell: Cell, work: Work, n: int) -> bool:
    """Return whether the state is at rest; the slopes must be in stage 0."""
    allowed = _AT_REST
    for variable in range(n):
        if not abs(work.stages[0, variable]) < allowed:
            return False
        allowed = _AT_REST * cell.scale
    return True
