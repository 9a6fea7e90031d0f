"""Values by name, whose errors list the valid names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NoReturn, TypeVar

from nrp_core.errors import UnknownNameError, did_you_mean

V = TypeVar("V")


class Named(dict[str, V]):
    """A dictionary whose error about a name that it lacks is one of the platform.

    Args:
        values: the values by name.
        kind: the kind of the named objects, for the message.
        owner: the object that they belong to, for the message.
    """

    def __init__(
        self,
        values: Mapping[str, V] | Iterable[tuple[str, V]] = (),
        kind: str = "value",
        owner: str = "the run",
    ) -> None:
        super().__init__(values)
        self._kind, self._owner = kind, owner

    def __missing__(self, name: object) -> NoReturn:
        known = ", ".join(map(repr, self)) or "none"
        hint = did_you_mean(name, self)
        raise UnknownNameError(f"{self._owner} has no {self._kind} {name!r}{hint}; there are: {known}")
