"""Checked values of a network, which cannot change after the check, and their digest."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, fields
from math import inf
from numbers import Integral
from typing import Any, ClassVar, Final, NoReturn, Self, cast

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core._support.checked_arguments import is_number
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.cells import CELLS
from nrp_core.network.synapses import LAWS

_INPUTS: Final = ("gsyn_exc", "gsyn_inh", "isyn_exc", "isyn_inh")
"""The state of cells with synapses of any kind: what is left of earlier input."""


def require_parts(fields: str, kind: type, given: Iterable[object]) -> None:
    """Check that all values of a field of a network are of one class.

    Raises:
        NetworkError: one is not.
    """
    for one in given:
        if not isinstance(one, kind):
            raise NetworkError(f"one of the {fields} of a network is {one!r:.60}, not a {kind.__name__}")


def require_cell_names(
    label: str, cell_type: str, parameters: Collection[str], states: Collection[str]
) -> None:
    """Check the names of the parameters and initial values of a population of standard cells.

    Args:
        label: the population's.
        cell_type: its cells; a backend may have some that are not standard.
        parameters: the names of its parameters.
        states: the names of its initial values.

    Raises:
        NetworkError: the cell type has no such value.
    """
    cell = CELLS.get(cell_type)
    if cell is not None:
        owner = f"population '{label}' ({cell_type})"
        _require_known(owner, "parameter", parameters, cell.parameters)
        _require_known(owner, "state variable", states, {*cell.state, *(_INPUTS if cell.weight_unit else ())})


def require_synapse_names(label: str, synapse_type: str, parameters: Collection[str]) -> None:
    """Check the names of the parameters of the synapses of a projection.

    Raises:
        NetworkError: the synapse law has no such parameter.
    """
    law = LAWS.get(synapse_type)
    if law is not None:
        _require_known(f"projection '{label}' ({synapse_type})", "parameter", parameters, law.parameters)


def require_all_parameters(owner: str, given: Collection[str], known: Iterable[str]) -> None:
    """Check that no parameter is missing.

    Raises:
        NetworkError: one is.
    """
    missing = [name for name in known if name not in given]
    if missing:
        names = ", ".join(f"'{name}'" for name in missing)
        raise NetworkError(f"{owner} needs the parameter{'s' if len(missing) > 1 else ''} {names}")


def _require_known(owner: str, what: str, given: Collection[str], known: Collection[str]) -> None:
    for name in given:
        if name not in known:
            raise NetworkError(f"{owner} has no {what} '{name}'{did_you_mean(name, known)}")


def feed(state: hashlib.blake2b, *values: object) -> None:
    """Add values to a hash; arrays by dtype, shape and bytes, without copying broadcast ones whole."""
    for value in values:
        if isinstance(value, np.ndarray):
            constant = value.ndim == 1 and value.strides == (0,) and value.size > 1
            state.update(f"{value.dtype}{value.shape}{bool(constant)}".encode())
            state.update(np.ascontiguousarray(value[:1] if constant else value).ravel().view(np.uint8).data)
        elif isinstance(value, dict):
            for key in sorted(value):
                feed(state, key, value[key])
        elif isinstance(value, tuple):
            for item in value:
                feed(state, item)
        else:
            state.update(repr(value).encode() + b";")


class Checked(dict[str, Any]):
    """A copy of a mapping that refuses changes, because these would bypass checks and digests."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise NetworkError("a network is not changed once it is made; dataclasses.replace makes another one")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type, tuple[dict[str, Any]]]:
        return type(self), (dict(self),)  # by default the items would be set one by one


def copy_mappings(record: object, owner: str, *names: str) -> None:
    """Copy the mappings of a frozen record, so that later changes of the originals do not affect it.

    Their arrays are not copied, since they may be large: they become read-only, so that who still
    changes one gets NumPy's error in that place.

    Args:
        record: an instance of a frozen dataclass.
        owner: the kind of the owner, for the message.
        names: the fields.

    Raises:
        NetworkError: one is not a mapping.
    """
    for name in names:
        given = getattr(record, name)
        if not isinstance(given, Mapping):
            raise NetworkError(f"{owner}: its {name} are {given!r:.60}; they must be values by name")
        object.__setattr__(record, name, Checked((key, freeze_value(value)) for key, value in given.items()))


def freeze_value(value: Any) -> Any:
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
        raise NetworkError(
            f"the size of population '{label}' is {size!r:.60}; it must be a whole number, 0 or more"
        )


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
    """Check that the values are one number for each cell.

    Raises:
        NetworkError: the values do not fit.
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
    return cast("IntArray", freeze_value(ids.astype(np.int64, copy=False)))


def require_timestep(timestep_ms: object) -> None:
    """Check the time step of a network.

    Raises:
        NetworkError: it is not a time above 0.
    """
    if timestep_ms is not None and not (is_number(timestep_ms) and 0 < timestep_ms < inf):
        raise NetworkError(
            f"the time step of a network is {timestep_ms!r:.60}; it must be more than 0, in ms"
        )


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
