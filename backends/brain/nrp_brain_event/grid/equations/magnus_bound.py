"""How large coefficients may be for a whole step of :mod:`nrp_brain_event.grid.equations.magnus_source`.

With A and B the integrals of abs(a) and abs(a x) + abs(b), and r the share by which coefficients change in
the step, the terms of fifth order that the expansion leaves out (Blanes et al. 2009, section 4) are at most
``A r (A + r)**2 B / 90`` together, and the remainder of the approximant is ``A**4 B / 720``: both are less
than ``(A + r)**4 B / 240``. Twice that is compared with the tolerance, for the terms of higher order.

That is too much to compute in each step. So what is due to b is measured in a value of x, the ``reach`` E:
if S is a sum of sizes of which none is smaller than its part of A and of b / E, the bound is
``(S + r)**4 S (abs(x) + E) / 240``. It meets the tolerance ``T (s + abs(x))`` for all S below a function of
abs(x) that is concave, so its chord between 0 and E is below it, and it grows beyond E.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_event.grid.equations.tolerance import TOLERANCE
from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.linear import ONE

SAFETY: Final = 120.0
_HALVINGS: Final = 50


class Bound(NamedTuple):
    """Says that a whole step is right if ``sum(size * abs(column)) < least + slope * min(abs(x), reach)``.

    Args:
        least, slope, reach: by cell.
        size: by column, then by cell; what is constant is in ``least``.
    """

    least: FloatArray
    slope: FloatArray
    reach: FloatArray
    size: Mapping[str, FloatArray]


def bound(
    size_a: Mapping[str, FloatArray], size_b: Mapping[str, FloatArray], change: FloatArray, scale: float
) -> Bound:
    """Return the bound for each cell.

    Args:
        size_a: sizes of :class:`~nrp_core.brain.network.equations.linear.Integrals` of a, by column.
        size_b: those of b.
        change: the share by which coefficients change in a step.
        scale: see :func:`nrp_brain_event.grid.equations.tolerance.scale_of`.
    """
    zero = np.zeros_like(change)
    reach = zero + scale
    for key, of_a in size_a.items():
        ratio = np.divide(size_b.get(key, zero), of_a, out=zero.copy(), where=of_a > 0.0)
        reach = np.maximum(reach, ratio)
    size = {
        key: np.maximum(size_a.get(key, zero), size_b.get(key, zero) / reach)
        for key in dict.fromkeys([*size_a, *size_b])
    }
    constant = size.pop(ONE, zero)
    least = _largest(scale / reach, change)
    slope = (_largest((scale + reach) / (2.0 * reach), change) - least) / reach
    return Bound(least - constant, slope, reach, size)


def _largest(share: FloatArray, change: FloatArray) -> FloatArray:
    """Return the S at which ``(S + change)**4 S`` is a share of the tolerance, or a little less."""
    allowed = SAFETY * TOLERANCE * share
    low, high = np.zeros_like(allowed), allowed**0.2
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_low = (middle + change) ** 4 * middle < allowed
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    return low
