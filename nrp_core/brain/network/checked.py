"""Values of a network that stay as they were when they were checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf
from numbers import Integral
from typing import Any, NoReturn, cast

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core._support.numbers import is_number
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


def require_identity(label: object, size: object) -> None:
    """Check the name and the number of cells of a population.

    Raises:
        NetworkError: one is impossible.
    """
    if not isinstance(label, str) or not label:
        raise NetworkError(f"the label of a population is a text, not {label!r:.60}")
    if not isinstance(size, Integral) or isinstance(size, bool) or size < 0:
        raise NetworkError(f"population '{label}' has a whole number of cells, not {size!r:.60}")


def require_own_labels(labels: Iterable[object]) -> None:
    """Check the labels of projections, by which their weights are read and written.

    Raises:
        NetworkError: one is not a text, or two are the same.
    """
    seen = set()
    for label in labels:
        if not isinstance(label, str) or not label:
            raise NetworkError(f"the label of a projection is a text, not {label!r:.60}")
        if label in seen:
            raise NetworkError(f"two projections have the label '{label}'; each needs its own")
        seen.add(label)


def require_numbers(what: str, values: Any, size: int) -> None:
    """Check that there is a number for each cell.

    Raises:
        NetworkError: there is not.
    """
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "biuf":
        raise NetworkError(f"{what} is {values!r:.60}, not an array of {size} numbers")
    if values.shape != (size,):
        raise NetworkError(f"{what} has shape {values.shape}, not ({size},)")


def require_values(what: str, values: Any) -> Any:
    """Return values of synapses: an array of numbers, or values that are drawn again for each read.

    Raises:
        NetworkError: they are neither.
    """
    is_array = isinstance(values, np.ndarray)
    if (is_array and values.dtype.kind not in "iuf") or not (is_array or hasattr(values, "whole")):
        raise NetworkError(f"{what} must be an array of numbers, one for each synapse, not {values!r:.60}")
    return values


def global_ids(name: str, ids: Any) -> IntArray:
    """Return the neurons of a view, given by their global ids.

    Raises:
        NetworkError: they are not whole numbers.
    """
    is_array = isinstance(ids, np.ndarray) and ids.ndim == 1
    if not is_array or ids.dtype.kind not in "iuf" or (ids != np.floor(ids)).any():
        raise NetworkError(f"view '{name}' must be an array of whole numbers, global ids, not {ids!r:.60}")
    return cast("IntArray", fixed(ids.astype(np.int64, copy=False)))


def require_timestep(timestep_ms: object) -> None:
    """Check the time step of a network.

    Raises:
        NetworkError: it is not a time above 0.
    """
    if timestep_ms is not None and not (is_number(timestep_ms) and 0 < timestep_ms < inf):
        raise NetworkError(f"the time step of a network is a time above 0 in ms, not {timestep_ms!r:.60}")
