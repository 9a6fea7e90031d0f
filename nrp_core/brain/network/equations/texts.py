"""Texts of users, which are data of a network."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, ClassVar, Self

from nrp_core.errors import NetworkError


class Kept:
    """Base of dataclasses of texts, which files keep as plain data."""

    KIND: ClassVar[str]
    """What the texts describe, by its name in scripts."""

    def data(self) -> dict[str, Any]:
        """Return the texts as plain data."""
        return asdict(self)  # type: ignore[call-overload,no-any-return]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Self:
        """Return what plain data describe.

        Raises:
            NetworkError: the texts do not fit together, or are not those of this kind.
        """
        try:
            return cls(**data)
        except TypeError as error:
            raise NetworkError(f"these are not the texts of an {cls.KIND}: {error}") from None
