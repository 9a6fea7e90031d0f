"""Random numbers as in brain files for NEST."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import NetworkError, did_you_mean


def is_random(value: Any) -> bool:
    """Return whether a value describes random numbers."""
    return isinstance(value, Random) or (isinstance(value, Mapping) and "distribution" in value)


@dataclass(frozen=True)
class Random:
    """Numbers from a distribution, such as ``nest.random.uniform``; arithmetic is possible."""

    draw: Callable[[np.random.RandomState, int], FloatArray]

    def __add__(self, other: float) -> Random:
        return Random(lambda random, n: self.draw(random, n) + other)

    def __mul__(self, factor: float) -> Random:
        return Random(lambda random, n: self.draw(random, n) * factor)

    __radd__, __rmul__ = __add__, __mul__

    def __sub__(self, other: float) -> Random:
        return self + -other

    def __neg__(self) -> Random:
        return self * -1.0


def uniform(low: float = 0.0, high: float = 1.0) -> Random:
    """Return a uniform distribution."""
    return Random(lambda random, n: random.uniform(low, high, n))


def normal(mean: float = 0.0, std: float = 1.0) -> Random:
    """Return a normal distribution."""
    return Random(lambda random, n: random.normal(mean, std, n))


def lognormal(mean: float = 0.0, std: float = 1.0) -> Random:
    """Return a lognormal distribution."""
    return Random(lambda random, n: random.lognormal(mean, std, n))


def exponential(beta: float = 1.0) -> Random:
    """Return an exponential distribution."""
    return Random(lambda random, n: random.exponential(beta, n))


def drawn(value: Any, n: int, random: np.random.RandomState) -> FloatArray:
    """Return numbers from a distribution, also in the notation of NEST 2.

    Raises:
        NetworkError: it is unknown.
    """
    if isinstance(value, Mapping):
        kind = str(value["distribution"])
        numbers = {key: float(one) for key, one in value.items() if key != "distribution"}
        known: dict[str, Callable[[], Random]] = {
            "uniform": lambda: uniform(numbers.get("low", 0.0), numbers.get("high", 1.0)),
            "normal": lambda: normal(numbers.get("mu", 0.0), numbers.get("sigma", 1.0)),
            "lognormal": lambda: lognormal(numbers.get("mu", 0.0), numbers.get("sigma", 1.0)),
            "exponential": lambda: exponential(1.0 / numbers.get("lambda", 1.0)),
        }
        root = kind.removesuffix("_clipped").removesuffix("_clipped_to_boundary")
        if root not in known:
            raise NetworkError(f"nest: the distribution '{kind}' is not supported{did_you_mean(root, known)}")
        return np.clip(
            known[root]().draw(random, n), numbers.get("low", -np.inf), numbers.get("high", np.inf)
        )
    numbers_drawn: FloatArray = value.draw(random, n)
    return numbers_drawn
