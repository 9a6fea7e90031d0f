"""Values of a network that stay as they were when they were checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np

from nrp_core.errors import NetworkError


class Checked(dict[str, Any]):
    """A copy of a mapping that refuses changes, which nothing would check and no digest would notice."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise NetworkError("a network is not changed once it is made; dataclasses.replace makes another one")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type, tuple[dict[str, Any]]]:
        return type(self), (dict(self),)  # by default the items would be set one by one


def keep_mappings(record: object, owner: str, *names: str) -> None:
    """Let a frozen record keep copies of its mappings, so that a change of those that were given has no part.

    Their arrays are not copied, since they may be large: they become read-only, so that who still
    changes one gets NumPy's error in that place.

    Args:
        record: an instance of a frozen dataclass.
        owner: what it is, for the message.
        names: the fields.

    Raises:
        NetworkError: one is not a mapping.
    """
    for name in names:
        given = getattr(record, name)
        if not isinstance(given, Mapping):
            raise NetworkError(f"{owner}: its {name} are {given!r:.60}; they must be values by name")
        object.__setattr__(record, name, Checked((key, fixed(value)) for key, value in given.items()))


def fixed(value: Any) -> Any:
    """Return a value; lists of numbers become arrays, and arrays read-only."""
    array = np.asarray(value, float) if _are_numbers(value) else value
    if isinstance(array, np.ndarray):
        array.setflags(write=False)
    return array


def _are_numbers(value: Any) -> bool:
    return isinstance(value, list | tuple) and all(isinstance(one, int | float | np.number) for one in value)
