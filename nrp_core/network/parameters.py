"""A parameter of a cell or synapse: its unit, its default and its valid values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray

MAX_RATE_HZ: Final = 1e7
"""Spikes a second into one neuron: a hundred thousand afferents at 100 Hz. A higher rate is a mistake, and
drawing its spikes would take forever."""


@dataclass(frozen=True, slots=True)
class Limit:
    """The valid values of a parameter.

    Args:
        rule: completes "it must be ..."
        allows: returns for each value whether it is valid.
    """

    rule: str
    allows: Callable[[FloatArray], npt.NDArray[np.bool_]]


FINITE: Final = Limit("finite", np.isfinite)
NUMBER: Final = Limit("a number", lambda x: ~np.isnan(x))
POSITIVE: Final = Limit("more than 0, and finite", lambda x: (x > 0) & (x < np.inf))
NOT_NEGATIVE: Final = Limit("0 or more, and finite", lambda x: (x >= 0) & (x < np.inf))
NOT_NEGATIVE_OR_INFINITE: Final = Limit("0 or more", lambda x: x >= 0)
WHOLE: Final = Limit("a whole number from 1 on", lambda x: (x >= 1) & (x < np.inf) & (x == np.floor(x)))
FRACTION: Final = Limit("between 0 and 1", lambda x: (x >= 0) & (x <= 1))
RATE: Final = Limit(f"from 0 to {MAX_RATE_HZ:g} Hz", lambda x: (x >= 0) & (x <= MAX_RATE_HZ))
DELAY: Final = Limit("0 ms or more, and finite", lambda x: (x >= 0) & (x < np.inf))


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter or state variable, under PyNN's name.

    Args:
        default: PyNN's default, or the initial value of a state variable.
        unit: PyNN's unit; empty if it has none.
        limit: its valid values.
    """

    default: float
    unit: str = ""
    limit: Limit = FINITE


def limits_of(tables: Iterable[Mapping[str, Parameter]]) -> dict[str, Limit]:
    """Return the limit of each name; a name has the same limit in every table.

    Raises:
        ValueError: two tables disagree.
    """
    limits: dict[str, Limit] = {}
    for table in tables:
        for name, parameter in table.items():
            known = limits.setdefault(name, parameter.limit)
            if known is not parameter.limit:
                raise ValueError(
                    f"'{name}' must be {parameter.limit.rule} here, and {known.rule} elsewhere; "
                    "one name has one limit"
                )
    return limits
