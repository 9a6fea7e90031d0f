"""Parts of a network that files keep as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any, ClassVar, Self

from nrp_core.errors import NetworkError, did_you_mean


class Plain:
    """The base of frozen data classes of numbers, texts and mappings."""

    __slots__ = ()
    KIND: ClassVar[str]
    """What they describe, by its name in messages."""

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
        try:
            return cls(**data)
        except TypeError as error:
            raise NetworkError(f"this is not data of {cls.KIND}: {error}") from None
