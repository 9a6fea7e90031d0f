"""Functions in equations that Python's ``math`` does not have."""

from __future__ import annotations

from math import expm1

from nrp_core._support.jit import inlined, jit
from nrp_core.brain.network import filters

driven = jit(filters.driven)


@inlined
def sign(x: float) -> float:
    """Return -1, 0 or 1."""
    return float((x > 0.0) - (x < 0.0))


@inlined
def exprel(x: float) -> float:
    """Return ``(exp(x) - 1) / x`` and its limit at 0."""
    return 1.0 if x == 0.0 else expm1(x) / x
