"""The first time at which a smooth function rises to zero; no rise is missed.

Between two neighbouring zeros of its derivative a function is monotone, so it has at most one zero there,
which the signs at both ends show (Rolle). Both kinds of functions here have a chain of derivatives that ends
in one with at most one zero, which has a closed form:

- ``RESPONSE``: a leaky membrane under two fading currents ``(x + s t) exp(-t/tau)``. With
  ``D f = f' + f/tau``, which has a zero between any two zeros of f as f' has, the chain is: voltage,
  its derivative, D of that for the membrane, D of that for the first synapse, and once more.
- ``POLYNOMIAL`` of degree 4 and its derivatives.

The functions of a chain are numbered from the simplest, 0, to the one whose rise is sought, 3; only their
signs matter. The coefficients are in ``work.function``, the zeros in ``work.zeros``.

The two synapses of a neuron: their input decays as ``(x + s dt) exp(-dt / tau_syn)``.

An exponential synapse has only x, an alpha synapse starts with only s; for delta synapses both stay zero. The
excitatory synapse is number 0, the inhibitory one number 1.
"""

from __future__ import annotations

from math import e, exp, inf
from typing import Final

from nrp_brain_event.records import ALPHA, EXPONENTIAL, Cell, Work, constant
from nrp_core._support.jit import inlined, jit
from nrp_core.network import filters

_NEGLIGIBLE: Final = 1e-20
"""Conductance (uS) or current (nA) below which a synapse counts as silent."""

driven = inlined(filters.driven)


@inlined
def left_of(cell: Cell, k: int, dt: float) -> float:
    """Return the remaining share of synapse k ``dt`` ms after the last event; 1 if it is silent."""
    return exp(-dt * cell.fading[k]) if cell.x[k] != 0.0 or cell.s[k] != 0.0 else 1.0


@inlined
def fade(cell: Cell, k: int, dt: float, left: float) -> None:
    """Decay synapse k by ``dt`` ms to the remaining share."""
    x, s = (cell.x[k] + cell.s[k] * dt) * left, cell.s[k] * left
    if abs(x) < _NEGLIGIBLE and abs(s) < _NEGLIGIBLE:
        x = s = 0.0
    cell.x[k], cell.s[k] = x, s


@inlined
def charge(cell: Cell, k: int, dt: float, leak: float, left: float) -> float:
    """Return the charge (pC) of synapse k on a membrane after ``dt`` ms, given ``leak`` and ``left``."""
    if cell.x[k] == 0.0 and cell.s[k] == 0.0:
        return 0.0
    return driven(dt, leak, left, cell.fading[k] - cell.leak, cell.x[k], cell.s[k])


@inlined
def arrive(cell: Cell, k: int, weight: float) -> None:
    """Deliver a spike to synapse k; an alpha function peaks at the weight after one time constant."""
    if cell.synapse == EXPONENTIAL:
        cell.x[k] += weight
    elif cell.synapse == ALPHA:
        cell.s[k] += weight * e / cell.tau_syn[k]


@inlined
def remaining_at(cell: Cell, k: int, dt: float) -> float:
    """Return conductance (uS) or current (nA) of synapse k ``dt`` ms after the last event."""
    return float((cell.x[k] + cell.s[k] * dt) * left_of(cell, k, dt))


@inlined
def silent(cell: Cell) -> bool:
    """Return whether both synapses are silent."""
    return bool(cell.x[0] == 0.0 and cell.s[0] == 0.0 and cell.x[1] == 0.0 and cell.s[1] == 0.0)


RESPONSE: Final = constant(0)
POLYNOMIAL: Final = constant(1)
_SOUGHT: Final = constant(3)

# The coefficients of a RESPONSE (a synapse without current has the time constant of the other, or of the
# membrane); those of a POLYNOMIAL are its coefficients, the constant first.
SETTLED, ABOVE, TAU_M, CM, TAU_E, X_E, S_E, TAU_I, X_I, S_I = range(10)

_PRECISION: Final = 4e-16


@jit
def first_rise(kind: int, work: Work, until: float) -> float:
    """Return the first t in 0..until at which the function rises to zero, or infinity."""
    n = _seed(kind, work, until)
    for level in range(3):
        n = _zeros(kind, level, work, n, until)
    low, f_low = 0.0, _value(kind, _SOUGHT, work, 0.0)
    for j in range(n + 1):
        high = work.zeros[j] if j < n else until
        f_high = _value(kind, _SOUGHT, work, high)
        if f_low < 0.0 <= f_high:
            return _zero(kind, _SOUGHT, work, low, f_low, high, f_high)
        low, f_low = high, f_high
    return inf


@jit
def only_rise(kind: int, work: Work, low: float, high: float) -> float:
    """Return the zero in low..high of the function, which increases there, or infinity."""
    f_low, f_high = _value(kind, _SOUGHT, work, low), _value(kind, _SOUGHT, work, high)
    if f_high < 0.0:
        return inf
    return _zero(kind, _SOUGHT, work, low, f_low, high, f_high) if f_low < 0.0 else low


@jit
def _zeros(kind: int, level: int, work: Work, n: int, until: float) -> int:
    """Replace the n zeros of the function one level below by this function's zeros; return their number."""
    found = 0
    low, f_low = 0.0, _value(kind, level, work, 0.0)
    for j in range(n + 1):
        high = work.zeros[j] if j < n else until
        f_high = _value(kind, level, work, high)
        if (f_low < 0.0) != (f_high < 0.0):
            work.zeros[found] = _zero(kind, level, work, low, f_low, high, f_high)
            found += 1
        low, f_low = high, f_high
    return found


@jit
def _seed(kind: int, work: Work, until: float) -> int:
    """Store the zero of the function below level 0, if it has one in 0..until; return 0 or 1."""
    if kind == POLYNOMIAL:
        return 0
    c = work.function
    gap = 1.0 / c[TAU_E] - 1.0 / c[TAU_I]
    p, q = c[S_I] - c[X_I] / c[TAU_I], -c[S_I] / c[TAU_I]
    if gap * q == 0.0:
        return 0
    zero = -(2.0 * q + gap * p) / (gap * q)
    if not 0.0 < zero < until:
        return 0
    work.zeros[0] = zero
    return 1


@jit
def _value(kind: int, level: int, work: Work, t: float) -> float:
    """Return a function of the chain at t."""
    if kind == POLYNOMIAL:
        return _polynomial(level, work, t)
    if level >= 2:
        return _voltage_or_slope(level, work, t)
    return _drive(level, work, t)


@jit
def _polynomial(level: int, work: Work, t: float) -> float:
    c = work.function
    if level == 3:
        value = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4])))
    elif level == 2:
        value = c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * 4.0 * c[4]))
    elif level == 1:
        value = 2.0 * c[2] + t * (6.0 * c[3] + t * 12.0 * c[4])
    else:
        value = 6.0 * c[3] + t * 24.0 * c[4]
    return float(value)


@jit
def _voltage_or_slope(level: int, work: Work, t: float) -> float:
    """Return voltage minus threshold (level 3), or its derivative, times ``exp(t / slowest tau)``."""
    c = work.function
    rate_m, rate_e, rate_i = 1.0 / c[TAU_M], 1.0 / c[TAU_E], 1.0 / c[TAU_I]
    slowest = min(rate_m, min(rate_e, rate_i))
    leak, fade_e, fade_i = _decay(rate_m, slowest, t), _decay(rate_e, slowest, t), _decay(rate_i, slowest, t)
    charge = driven(t, leak, fade_e, rate_e - rate_m, c[X_E], c[S_E])
    charge += driven(t, leak, fade_i, rate_i - rate_m, c[X_I], c[S_I])
    above = c[ABOVE] * leak + charge / c[CM]
    if level == 3:
        return float(c[SETTLED] * exp(t * slowest) + above)
    current = (c[X_E] + c[S_E] * t) * fade_e + (c[X_I] + c[S_I] * t) * fade_i
    return float(current / c[CM] - above * rate_m)


@jit
def _drive(level: int, work: Work, t: float) -> float:
    """Return the derivative of the current (level 1), or D of it for the first synapse, scaled as well."""
    c = work.function
    rate_e, rate_i = 1.0 / c[TAU_E], 1.0 / c[TAU_I]
    p_e, q_e = c[S_E] - c[X_E] * rate_e, -c[S_E] * rate_e
    p_i, q_i = c[S_I] - c[X_I] * rate_i, -c[S_I] * rate_i
    slowest = rate_i if level == 0 and q_e == 0.0 else min(rate_e, rate_i)
    fade_e, fade_i = _decay(rate_e, slowest, t), _decay(rate_i, slowest, t)
    if level == 1:
        return float((p_e + q_e * t) * fade_e + (p_i + q_i * t) * fade_i)
    return float(q_e * fade_e + (q_i + (rate_e - rate_i) * (p_i + q_i * t)) * fade_i)


@jit
def _decay(rate: float, slowest: float, t: float) -> float:
    """Return a decay relative to the slowest one, so that the sign of a sum never underflows."""
    return exp(-(rate - slowest) * t) if rate > slowest else 1.0


@jit
def _zero(kind: int, level: int, work: Work, a: float, f_a: float, b: float, f_b: float) -> float:
    """Return the zero between a and b, where the values have different signs, to machine precision.

    Inverse quadratic interpolation where it surely converges, else bisection
    (Chandrupatla 1997, Advances in Engineering Software 28:145).
    """
    share = 0.5
    while True:
        x = a + share * (b - a)
        f_x = _value(kind, level, work, x)
        if (f_x < 0.0) == (f_a < 0.0):
            older, f_older = a, f_a
        else:
            older, f_older = b, f_b
            b, f_b = a, f_a
        a, f_a = x, f_x
        best = a if abs(f_a) < abs(f_b) else b
        least = _PRECISION * (1.0 + abs(best)) / abs(b - a)
        if least > 0.5 or f_a == 0.0:
            return best
        xi, phi = (a - b) / (older - b), (f_a - f_b) / (f_older - f_b)
        share = 0.5
        if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
            share = f_a / (f_b - f_a) * f_older / (f_b - f_older)
            share += (older - a) / (b - a) * f_a / (f_older - f_a) * f_b / (f_older - f_b)
        share = min(1.0 - least, max(least, share))
