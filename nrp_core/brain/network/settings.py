"""Settings of a projection or a population whose values are checked one by one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from math import inf
from numbers import Real
from typing import Any, ClassVar, Final, Self

from nrp_core.errors import NetworkError, did_you_mean

SMALLEST: Final = 5e-324
"""The lowest number above 0."""


class Settings:
    """The base of frozen data classes."""

    __slots__ = ()
    KIND: ClassVar[str]
    """What the settings are, by its name in messages."""

    def _require(self, name: str, low: float, high: float, rule: str, *, whole: bool = False) -> None:
        """Check a number, and keep it as one of Python: those of NumPy are not written as JSON."""
        value = getattr(self, name)
        number = isinstance(value, Real) and not isinstance(value, bool)
        if not (number and low <= value <= high and value < inf and (not whole or value == int(value))):
            raise NetworkError(f"{self.KIND}: {name} is {value!r}; it must be {rule}")
        object.__setattr__(self, name, int(value) if whole else float(value))

    def data(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)  # type: ignore[call-overload,no-any-return]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Self:
        """Return it from :meth:`data`.

        Raises:
            NetworkError: a name or a value is impossible.
        """
        known = [one.name for one in fields(cls)]  # type: ignore[arg-type]
        for name in data.keys() - set(known):
            raise NetworkError(f"{cls.KIND} has no '{name}'{did_you_mean(name, known)}")
        return cls(**data)
