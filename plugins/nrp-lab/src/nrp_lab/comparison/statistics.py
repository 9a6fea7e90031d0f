"""Equivalence, difference and effect sizes, from one value per seed.

Every comparison of backends reduces to one number for each of the independent seeds: the difference of the
values that the same seed gave on both, or the pseudo-value of an excess distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import erf, exp, inf, nan, pi, sqrt
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray

ALPHA = 0.05
"""Level of every test; the intervals shown are 90 % intervals, which match two one-sided tests at 5 %."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean with its error.

    Args:
        mean: the estimate.
        error: its standard error; NaN for a single value.
        freedom: degrees of freedom of the error.
    """

    mean: float
    error: float
    freedom: int

    @classmethod
    def of(cls, values: FloatArray) -> Estimate:
        """Return the mean of independent values."""
        n = len(values)
        error = float(np.std(values, ddof=1)) / sqrt(n) if n > 1 else nan
        return cls(float(np.mean(values)), error, n - 1)

    @classmethod
    def of_matched_shares(cls, differences: FloatArray) -> Estimate:
        """Return the mean of differences between yes (1) and no (0) for the same seeds.

        Where all are 0 the usual error would be 0 however few they are. Half an observation is added to
        each of the four cells of the table: Agresti and Min 2005, Statistics in Medicine 24:729.
        """
        n = len(differences) + 2
        mean = float(np.sum(differences)) / n
        variance = (float(np.sum(differences**2)) + 1) / n - mean**2
        return cls(mean, sqrt(variance / n), len(differences) - 1)

    @property
    def interval(self) -> tuple[float, float]:
        """The 90 % confidence interval."""
        if self.freedom < 1:
            return -inf, inf
        reach = self.error * _t().ppf(1 - ALPHA, self.freedom)
        return self.mean - reach, self.mean + reach

    @property
    def p_different(self) -> float:
        """Two-sided p-value of the hypothesis of no difference (Student's t)."""
        if self.freedom < 1:
            return 1.0
        if self.error == 0:
            return float(self.mean == 0)
        return float(2 * _t().sf(abs(self.mean) / self.error, self.freedom))

    def p_equivalent(self, margin: float) -> float:
        """Return the p-value of the hypothesis that the difference is at least the margin.

        Two one-sided tests: Schuirmann 1987, J. Pharmacokinet. Biopharm. 15:657.
        """
        if self.freedom < 1:
            return 1.0
        room = margin - abs(self.mean)
        if self.error == 0:
            return float(room < 0)
        return float(_t().sf(room / self.error, self.freedom))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values corrected for their number: Holm 1979, Scand. J. Stat. 6:65."""
    corrected, largest = [1.0] * len(p_values), 0.0
    for rank, index in enumerate(np.argsort(p_values)):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[index]))
        corrected[index] = largest
    return corrected


def pooled_sd(sds: Sequence[float]) -> float:
    """Return the standard deviation within groups of equal size: the root of the mean variance."""
    return sqrt(sum(sd**2 for sd in sds) / len(sds)) if sds else 0.0


# -- distances

_SHIFTS = np.linspace(0.0, 20.0, 2001)


def excess_of_shift(shift_sd: float) -> float:
    """Return the relative excess of the distance between two normal samples that a shift causes.

    The mean distance of members of one sample is ``2 sd / sqrt(pi)``, that of members of two is the mean of
    a folded normal; this is the excess of the second as a share of the first: 0.24 for a shift of 1 SD.
    """
    return exp(-(shift_sd**2) / 4) + shift_sd * sqrt(pi) / 2 * erf(shift_sd / 2) - 1


def shift_of_excess(excess: float) -> float:
    """Return the shift, SD, that causes an excess; 0 for an excess that is not positive."""
    return float(np.interp(excess, [excess_of_shift(shift) for shift in _SHIFTS], _SHIFTS))


def excess_values(within_a: FloatArray, between: FloatArray, within_b: FloatArray) -> FloatArray:
    """Return the pseudo-values, one for each seed, of the excess distance between two groups.

    Their mean is half the energy distance (Székely and Rizzo 2013, J. Stat. Plan. Inference 143:1249), from
    pairs of different seeds only; they are jackknife pseudo-values (Tukey 1958).

    Args:
        within_a: distances between the seeds of one group, shape ``(n, n)``, n at least 3.
        between: from the seeds of that group to those of the other, shape ``(n, n)``.
        within_b: between the seeds of the other, shape ``(n, n)``.
    """
    n = len(between)
    excess = between - (within_a + within_b) / 2
    excess = (excess + excess.T) / 2
    np.fill_diagonal(excess, 0.0)
    rows = excess.sum(axis=1)
    whole, without = rows.sum() / (n * (n - 1)), (rows.sum() - 2 * rows) / ((n - 1) * (n - 2))
    pseudo: FloatArray = n * whole - (n - 1) * without
    return pseudo


def _t() -> Any:
    """Return Student's distribution; SciPy is slow to import."""
    from scipy.stats import t

    return t
