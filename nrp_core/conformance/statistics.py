"""Statistical tests: a failure needs two seeds that agree."""

from __future__ import annotations

from collections.abc import Callable
from math import erfc, sqrt

SEEDS = (11, 29)
UNLIKELY = 1e-3


def require_likely(probability: Callable[[int], float]) -> float:
    """Fail only if the result has a probability below one in a thousand for both of two fixed seeds.

    Args:
        probability: runs an experiment with a seed and returns the two-sided p-value of its result.

    Returns:
        The larger of the two.
    """
    largest = max(probability(seed) for seed in SEEDS)
    assert largest >= UNLIKELY, f"probability below 1 in 1000 for both seeds: p = {largest:.2g}"
    return largest


def of_normal(z: float) -> float:
    """Return the two-sided p-value of a standard normal deviate."""
    return erfc(abs(z) / sqrt(2))


def of_chi_square(x: float, freedom: int) -> float:
    """Return the two-sided p-value of a chi-square value (Wilson & Hilferty 1931, PNAS 17:684)."""
    spread = 2 / (9 * freedom)
    return of_normal(((x / freedom) ** (1 / 3) - (1 - spread)) / sqrt(spread))
