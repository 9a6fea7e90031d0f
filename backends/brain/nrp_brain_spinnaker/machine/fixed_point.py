"""The arithmetic of the machine: s16.15 numbers as integers, products that floor, sums that wrap.

State and input are s16.15, decays u0.32. Every function takes and returns raw bits as plain integers, and all
intermediates fit 64 bits, so the code is exact as Python and compiled. The operations are those of compiled
fixed-point C (ISO/IEC TR 18037) on the machine's ARM cores: without rounding to nearest and without
saturation (Mikaitis 2020, arXiv:2001.01496).

The exponential of the machine: two tables and a quadratic, on integers.

``exp(x)`` for ``x = z - f`` is taken from a table at the next integer ``z``, reduced by a table in steps of
1/16 and by a quadratic in the rest, in units of 2**-32. The result differs from the exact floor by some
units, as on the machine.

Convert users' numbers to the machine's as the host does: to the nearest, ties to even.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit

ONE = 1 << 15
"""1.0 in s16.15."""
HALF = 1 << 14
"""0.5 in s16.15."""
LARGEST = (1 << 31) - 1
"""The largest s16.15 number, 65535.99997."""
SMALLEST = -(1 << 31)
"""The smallest s16.15 number, -65536."""
FRACTION_LARGEST = (1 << 32) - 1
"""The largest u0.32 number; 1.0 does not fit."""


@jit
def wrap(value: int) -> int:
    """Keep the low 32 bits as a signed number."""
    return ((value + 0x80000000) & 0xFFFFFFFF) - 0x80000000


@jit
def mul(a: int, b: int) -> int:
    """Multiply two s16.15 numbers, toward minus infinity."""
    return wrap((a * b) >> 15)


@jit
def scale(a: int, fraction: int) -> int:
    """Multiply an s16.15 number by a u0.32 fraction, toward minus infinity."""
    return (a * fraction) >> 32


@jit
def div(a: int, b: int) -> int:
    """Divide two s16.15 numbers, ``a >= 0``, truncating.

    The machine divides unsigned, where a negative divisor is larger than any dividend.
    """
    return wrap((a << 15) // b) if b > 0 else 0


@jit
def ceiling(a: int) -> int:
    """Round an s16.15 number up to an integer."""
    return -(-a >> 15)


@jit
def clamp(value: int) -> int:
    """Return the nearest s16.15 number (used only if the machine does not define the rounding)."""
    return min(max(value, SMALLEST), LARGEST)


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


def to_accum(values: npt.ArrayLike, what: str = "value") -> IntArray:
    """Convert to s16.15 raw bits.

    Scaling by a power of two is exact, so this rounds the given number itself. A number half way is rounded
    by its shortest decimal form, which may be slightly to one side.

    Raises:
        ValueError: a value is outside -65536 .. 65535.99997; ``what`` names it.
    """
    given = np.asarray(values, dtype=float)
    raw = np.asarray(np.rint(given * ONE))
    outside = ~((raw >= SMALLEST) & (raw <= LARGEST))
    if outside.any():
        first = given[outside].flat[0]
        raise ValueError(f"{what} is {first:g}; the machine's numbers lie in -65536 .. 65535.99997")
    half_way = np.abs(given * ONE - raw) == 0.5
    raw[half_way] = [round(Decimal(repr(value)) * ONE) for value in given[half_way].tolist()]
    return raw.astype(np.int64)


def from_accum(raw: npt.ArrayLike) -> FloatArray:
    """Convert s16.15 raw bits to numbers, exactly."""
    return np.asarray(raw, dtype=np.int64) / ONE


def to_fraction(value: Decimal) -> int:
    """Convert a number in 0 .. 1 to u0.32 raw bits; 1 becomes the largest fraction."""
    return min(int((value * 2**32).to_integral_value()), FRACTION_LARGEST)


def exact_exp(value: Decimal) -> Decimal:
    """Return exp to 40 digits; it is the same on every machine, unlike that of a mathematical library."""
    with localcontext(prec=40):
        return value.exp()
