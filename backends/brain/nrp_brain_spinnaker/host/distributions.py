"""The host's estimates of random weights, delays and connection counts before they are drawn."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from statistics import NormalDist

import numpy as np

from nrp_core._support.arrays import FloatArray

_TEXT = re.compile(r"\s*(\w+)\((.*)\)\s*\Z")


@dataclass(frozen=True, slots=True)
class Distribution:
    """A random distribution.

    Args:
        mean, variance: its moments.
        quantile: the value below which a share of the draws is.
    """

    mean: float
    variance: float
    quantile: Callable[[float], float]

    def most_probable_extreme(self, n: int) -> float:
        """Return the absolute value that the largest of ``n`` draws exceeds with probability 1 %."""
        chance = 0.01 / max(n, 1)
        return abs(self.quantile(chance if self.mean < 0 else 1 - chance))


def parse_distribution(text: object) -> Distribution | None:
    """Read the text of a distribution such as ``normal(mu=0.5, sigma=0.1)``; None for others."""
    match = _TEXT.match(text) if isinstance(text, str) else None
    if match is None or match[1] not in _KNOWN:
        return None
    try:
        pairs = (part.split("=") for part in match[2].split(","))
        parameters = {name.strip(): float(value) for name, value in pairs}
        return _KNOWN[match[1]](parameters)
    except (ValueError, KeyError):
        return None


def _uniform(given: Mapping[str, float]) -> Distribution:
    low, high = given["low"], given["high"]
    return Distribution((low + high) / 2, (high - low) ** 2 / 12, lambda p: low + p * (high - low))


def _normal(given: Mapping[str, float]) -> Distribution:
    normal = NormalDist(given["mu"], given["sigma"])
    return Distribution(normal.mean, normal.variance, normal.inv_cdf)


def _clipped(given: Mapping[str, float], *, redrawn: bool) -> Distribution:
    """Return a truncated normal distribution with moments from a fine grid of quantiles."""
    normal, low, high = NormalDist(given["mu"], given["sigma"]), given["low"], given["high"]
    first, last = (normal.cdf(low), normal.cdf(high)) if redrawn else (0.0, 1.0)

    def quantile(p: float) -> float:
        inside = min(max(first + p * (last - first), 1e-12), 1 - 1e-12)
        return min(max(normal.inv_cdf(inside), low), high)

    values = np.array([quantile((k + 0.5) / 1000) for k in range(1000)])
    return Distribution(float(values.mean()), float(values.var()), quantile)


def _exponential(given: Mapping[str, float]) -> Distribution:
    beta = given["beta"]
    return Distribution(beta, beta**2, lambda p: -beta * math.log1p(-p))


def _lognormal(given: Mapping[str, float]) -> Distribution:
    mu, sigma = given["mu"], given["sigma"]
    mean = math.exp(mu + sigma**2 / 2)
    variance = math.expm1(sigma**2) * mean**2
    return Distribution(mean, variance, lambda p: math.exp(NormalDist(mu, sigma).inv_cdf(p)))


_KNOWN: Mapping[str, Callable[[Mapping[str, float]], Distribution]] = {
    "uniform": _uniform,
    "normal": _normal,
    "normal_clipped": partial(_clipped, redrawn=True),
    "normal_clipped_to_boundary": partial(_clipped, redrawn=False),
    "exponential": _exponential,
    "lognormal": _lognormal,
}


def binomial_quantile(n: int, probability: float, share: float) -> int:
    """Return the quantile ``share`` of a binomial distribution."""
    if n == 0 or probability <= 0:
        return 0
    if probability >= 1 or share >= 1:
        return n
    k = np.arange(n + 1)
    factorials = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, n + 1)))])
    logs = factorials[n] - factorials[k] - factorials[n - k]
    logs += k * math.log(probability) + (n - k) * math.log1p(-probability)
    above: FloatArray = np.cumsum(np.exp(logs)[::-1])[::-1] - np.exp(logs)
    return int(np.argmax(above <= 1 - share))


def poisson_share_below(limit: int, mean: float) -> float:
    """Return the probability that a Poisson variate is below ``limit``."""
    return math.fsum(math.exp(k * math.log(mean) - mean - math.lgamma(k + 1)) for k in range(limit))
