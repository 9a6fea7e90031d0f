"""The exponential of the machine: two tables and a quadratic, on integers.

``exp(x)`` for ``x = z - f`` is taken from a table at the next integer ``z``, reduced by a table in steps of
1/16 and by a quadratic in the rest, in units of 2**-32. The result differs from the exact floor by some
units, as on the machine.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.machine.fixed_point import FRACTION_LARGEST, LARGEST, ONE
from nrp_core._support.jit import jit

_UPPER = 363408
"""Above this s16.15 argument the result does not fit and the largest number is returned."""
_LOWER = -340695
"""Below this s16.15 argument the result is 0."""
_FIRST = -13


def _rounded(values: list[Decimal]) -> npt.NDArray[np.int64]:
    return np.array([int((value * 2**32).to_integral_value()) for value in values], np.int64)


def _tables() -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    with localcontext(prec=40):
        whole = _rounded([Decimal(k).exp() for k in range(_FIRST, 13)])
        sixteenths = _rounded([1 - (Decimal(-j) / 16).exp() for j in range(16)])
    return whole, sixteenths


_WHOLE, _SIXTEENTHS = _tables()


@jit
def _portion(total: int, fraction: int) -> int:
    """Multiply a number of up to 50 bits by a u0.32 fraction; the low word rounds, in halves of the word."""
    low, high = total & 0xFFFFFFFF, total >> 32
    upper, lower = low * (fraction >> 16), low * (fraction & 0xFFFF)  # both fit 64 bits
    carry = (upper + (lower >> 16)) >> 16
    rest = (((upper & 0xFFFF) << 16) + lower) & 0xFFFFFFFF
    return carry + (1 if rest >= 0x7FFFFFFF else 0) + high * fraction


@jit
def _scaled_exp(n: int) -> int:
    """Return about 2**32 exp(n / 2**15) for ``n`` between the bounds."""
    z = n >> 15
    f = n - (z << 15)
    if f == 0:
        return int(_WHOLE[z - _FIRST])
    f = ONE - f
    total = int(_WHOLE[z + 1 - _FIRST])
    total -= _portion(total, int(_SIXTEENTHS[f >> 11]))
    y = (f & 0x7FF) << 17
    q = 4293434720 - ((2081624032 * y) >> 32)
    q = ((q * y) >> 32) + 5294
    return total - _portion(total, q)


@jit
def exp_accum(n: int) -> int:
    """Return exp of an s16.15 number as s16.15."""
    if n > _UPPER:
        return LARGEST
    if n < _LOWER:
        return 0
    return _scaled_exp(n) >> 17


@jit
def exp_fraction(n: int) -> int:
    """Return exp of an s16.15 number as u0.32; for 0 it is 0, because 1.0 does not fit."""
    if n > _UPPER:
        return LARGEST
    if n < _LOWER:
        return 0
    return _scaled_exp(n) & FRACTION_LARGEST
