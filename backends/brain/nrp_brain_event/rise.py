"""The first time at which a smooth function rises to zero; no rise is missed.

Between two neighbouring zeros of its derivative a function is monotone, so it has at most one zero
there, and the signs at both ends tell (Rolle). Both functions that are needed here have a chain of
derivatives that ends in one with at most one zero, which is known in closed form:

- ``RESPONSE``: a leaky membrane under two fading currents ``(x + s t) exp(-t/tau)``. With
  ``D f = f' + f/tau``, which has a zero between any two zeros of f as f' has, the chain is: voltage,
  its derivative, D of that for the membrane, D of that for the first synapse, and once more.
- ``POLYNOMIAL`` of degree 4 and its derivatives.

The functions of a chain are numbered from the simplest, 0, to the one whose rise is sought, 3. The
coefficients stand in ``work.function``; room for zeros is in ``work.zeros``.
"""

from __future__ import annotations

from math import exp, inf
from typing import Final

from nrp_brain_event.records import Work, constant
from nrp_brain_event.synapses import driven
from nrp_core.jit import jit

RESPONSE: Final = constant(0)
POLYNOMIAL: Final = constant(1)
_SOUGHT: Final = constant(3)

# The coefficients of a RESPONSE; those of a POLYNOMIAL are its own, the constant first.
SETTLED, ABOVE, TAU_M, CM, TAU_E, X_E, S_E, TAU_I, X_I, S_I = range(10)

_PRECISION: Final = 4e-16


@jit
def first_rise(kind: int, work: Work, until: float) -> float:
    """Return the first t in 0..until at which the function comes to zero from below, or infinity."""
    n = _seed(kind, work, until)
    for level in range(3):
        n = _zeros(kind, level, work, n, until)
    low, f_low = 0.0, _value(kind, _SOUGHT, work, 0.0)
    for j in range(n + 1):
        high = work.zeros[j] if j < n else until
        f_high = _value(kind, _SOUGHT, work, high)
        if f_low < 0.0 <= f_high:
            return _zero(kind, _SOUGHT, work, low, high)
        low, f_low = high, f_high
    return inf


@jit
def _zeros(kind: int, level: int, work: Work, n: int, until: float) -> int:
    """Replace the n zeros of the function below this level by those of this one; return their number."""
    found = 0
    low, f_low = 0.0, _value(kind, level, work, 0.0)
    for j in range(n + 1):
        high = work.zeros[j] if j < n else until
        f_high = _value(kind, level, work, high)
        if (f_low < 0.0) != (f_high < 0.0):
            work.zeros[found] = _zero(kind, level, work, low, high)
            found += 1
        low, f_low = high, f_high
    return found


@jit
def _seed(kind: int, work: Work, until: float) -> int:
    """Store the zero of the function below level 0, if it has one in 0..until; return 0 or 1."""
    c = work.function
    if kind == POLYNOMIAL:
        slope, offset = 24.0 * c[4], 0.0
    else:
        gap = 1.0 / c[TAU_E] - 1.0 / c[TAU_I]
        p, q = c[S_I] - c[X_I] / c[TAU_I], -c[S_I] / c[TAU_I]
        slope, offset = gap * q, 2.0 * q + gap * p
    zero = -offset / slope if slope != 0.0 else -1.0
    if not 0.0 < zero < until:
        return 0
    work.zeros[0] = zero
    return 1
