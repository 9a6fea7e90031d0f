"""Settings of a projection or a population whose values are checked one by one."""

from __future__ import annotations

from math import inf
from typing import Final

from nrp_core._support.numbers import is_number
from nrp_core.brain.network.plain import Plain
from nrp_core.errors import NetworkError

SMALLEST: Final = 5e-324
"""The lowest number above 0."""


class Settings(Plain):
    """The base of frozen data classes of numbers."""

    __slots__ = ()

    def _require(self, name: str, low: float, high: float, rule: str, *, whole: bool = False) -> None:
        """Check a number, and keep it as one of Python: those of NumPy are not written as JSON."""
        value = getattr(self, name)
        if not (
            is_number(value) and low <= value <= high and value < inf and (not whole or value == int(value))
        ):
            raise NetworkError(f"{self.KIND}: {name} is {value!r}; it must be {rule}")
        object.__setattr__(self, name, int(value) if whole else float(value))
