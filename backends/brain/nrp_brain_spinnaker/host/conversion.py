"""Convert users' numbers to the machine's as the host does: to the nearest, ties to even."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.machine.fixed_point import FRACTION_LARGEST, LARGEST, ONE, SMALLEST
from nrp_core._support.arrays import FloatArray, IntArray


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
