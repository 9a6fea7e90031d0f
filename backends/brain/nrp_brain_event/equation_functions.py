"""Functions in equations that Python's ``math`` does not have."""

from __future__ import annotations

from math import expm1, factorial, inf
from typing import Final

import numpy as np

from nrp_core._support.jit import inlined, jit
from nrp_core.network import filters

_PER_OCTAVE: Final = 1.4426950408889634
_OCTAVE: Final = 0.693145751953125, 1.42860682030941723212e-6
"""The logarithm of 2 in two parts, of which the first has few digits."""
_ROUND: Final = 1.5 * 2.0**52
"""A number near which floating-point numbers are integers, which are the low bits of their representation."""
_BIAS: Final = 1023.0
_EXPONENT: Final = np.uint64(52)
_FACTORS: Final = tuple(1.0 / factorial(n) for n in range(13, -1, -1))
"""Of the powers of the argument in the Taylor series, the highest first."""
_SMALLEST, _LARGEST = -708.0, 709.79

driven = jit(filters.driven)


@inlined
def sign(x: float) -> float:
    """Return -1, 0 or 1."""
    return float((x > 0.0) - (x < 0.0))


@inlined
def exprel(x: float) -> float:
    """Return ``(exp(x) - 1) / x`` and its limit at 0."""
    return 1.0 if x == 0.0 else expm1(x) / x


@inlined
def exp(x: float) -> float:
    """Return the exponential function, which is within 1e-15 of the value; 0 below 1e-307.

    A loop with it becomes vector instructions, which a call of the C library prevents. The argument is
    reduced to half an octave as in Cephes (Moshier 1989), for which the Taylor series needs 14 terms.
    """
    octaves = (x * _PER_OCTAVE + _ROUND) - _ROUND
    r = (x - octaves * _OCTAVE[0]) - octaves * _OCTAVE[1]
    series = _FACTORS[0]
    for factor in _FACTORS[1:]:
        series = factor + r * series
    bits = np.float64(octaves + (_ROUND + _BIAS - 1.0)).view(np.uint64)
    half = np.uint64(bits << _EXPONENT).view(np.float64)
    value = 2.0 * (series * half)
    return 0.0 if x < _SMALLEST else inf if x > _LARGEST else value
