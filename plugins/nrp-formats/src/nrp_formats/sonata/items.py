"""Nodes or edges of a SONATA population, and their attributes.

An attribute is stored in the HDF5 file for each item, in the table of types for all items of a type, or in
a parameter file that the table names; the first of these that has it is used.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_core.network.files.hdf5 import column, group
from nrp_core.utilities import strict_json


def read_object(path: Path, what: str) -> dict[str, Any]:
    """Return the object in a file.

    Args:
        path: the file.
        what: its contents, in messages: 'the configuration'.

    Raises:
        NetworkError: the file cannot be read, is not JSON, gives a name twice, or holds something else.
    """
    try:
        given = strict_json(path.read_text("utf-8"))
    except OSError as error:
        raise NetworkError(f"{what} cannot be read: {error.strerror}", path=path) from error
    except ValueError as error:
        line = getattr(error, "lineno", None)
        raise NetworkError(f"{what} cannot be read: {error}", path=path, line=line) from error
    if not isinstance(given, dict):
        raise NetworkError(f"{what} is not a JSON object", path=path)
    return given


class Attributes(dict[str, Any]):
    """The attributes of a type.

    Attributes:
        parameters: the names of those that its parameter file holds.
    """

    parameters: frozenset[str] = frozenset()


Types = Mapping[int, Attributes]

DYNAMICS = "dynamics_params"
_GROUPS = (DYNAMICS, "indices", "indicies")
"""Groups that populations of nodes and edges have, beside those of attributes."""
_NOTHING = frozenset({"", "null", "none", "nan"})


@dataclass(frozen=True)
class SonataItems:
    """Nodes or edges of one population.

    Args:
        name: the population's name.
        kind: ``node`` or ``edge``.
        type_ids: shape ``(n,)``.
        types: the attributes of each type.
        groups: for each HDF5 group, its items, their places in it, and its attributes.
        unread: names in the HDF5 file of attributes that are not numbers, and of groups that mean nothing.
    """

    name: str
    kind: str
    type_ids: IntArray
    types: Types
    groups: tuple[tuple[IntArray, IntArray, Mapping[str, np.ndarray[Any, Any]]], ...]
    unread: frozenset[str] = frozenset()
    _used: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        used = tuple(np.unique(self.type_ids).tolist())
        for number in used:
            if number not in self.types:
                known = ", ".join(map(str, self.types)) or "none"
                raise NetworkError(
                    f"{self.kind}s '{self.name}' have the type {number}, which no table has; it has {known}"
                )
        object.__setattr__(self, "_used", used)

    def __len__(self) -> int:
        return len(self.type_ids)

    def numbers(self, name: str) -> FloatArray:
        """Return a number for each item, NaN if it has none; a shared number takes constant memory.

        Raises:
            NetworkError: the attribute of a type is not a number.
        """
        shared = {number: self._number(number, name) for number in self._used}
        if len(set(shared.values())) == 1 and not any(name in own for *_, own in self.groups):
            return np.broadcast_to(np.float64(next(iter(shared.values()))), (len(self),))
        values = np.full(len(self), np.nan)
        for number, value in shared.items():
            values[self.type_ids == number] = value
        for items, places, own in self.groups:
            if name in own:
                values[items] = own[name][places]
        return values

    def texts(self, name: str) -> Mapping[int, str]:
        """Return a string for each used type; an empty string if it has none."""
        found = {number: self.types[number].get(name) for number in self._used}
        return {number: "" if value is None else str(value) for number, value in found.items()}

    def used_types(self) -> list[Attributes]:
        """Return the attributes of each type that an item has."""
        return [self.types[number] for number in self._used]

    def names(self) -> set[str]:
        """Return the names of all attributes."""
        named = {name for number in self._used for name in self.types[number]}
        return named.union(*(own for *_, own in self.groups))

    def _number(self, number: int, name: str) -> float:
        value = self.types[number].get(name)
        try:
            if isinstance(value, bool):
                raise TypeError
            return np.nan if value is None else float(value)
        except (TypeError, ValueError):
            parameters = self.types[number].get(DYNAMICS)
            source = "" if parameters is None else f" ({DYNAMICS} '{parameters}')"
            raise NetworkError(
                f"{self.kind} type {number} of '{self.name}'{source}: {name} is {value!r:.60}, not a number"
            ) from None


def read_items(part: Any, name: str, kind: str, types: Types) -> SonataItems:
    """Read the nodes or edges of a population from its HDF5 group.

    Raises:
        NetworkError: the group does not hold valid items.
    """
    type_ids = column(part, f"{kind}_type_id", np.int64)
    n = len(type_ids)
    _require_both(part, name, kind)
    if f"{kind}_group_id" in part:
        group_ids = column(part, f"{kind}_group_id", np.int64)
        places = column(part, f"{kind}_group_index", np.int64)
    else:  # a single group needs no index
        group_ids, places = np.zeros(n, np.int64), np.arange(n)
    if not len(group_ids) == len(places) == n:
        raise NetworkError(f"{kind}s '{name}': {n} types, {len(group_ids)} groups and {len(places)} places")
    groups, numbered = [], sorted(key for key in part if key.isdigit())
    for number in np.unique(group_ids).tolist():
        items = np.flatnonzero(group_ids == number)
        if numbered and str(number) not in numbered:
            raise NetworkError(
                f"{kind}s '{name}': {kind} {items[0]} is in the group {number}, and the groups are "
                f"{', '.join(numbered)}"
            )
        own = _own(group(part, str(number))) if str(number) in part else {}
        _require_rows(f"{kind}s '{name}', group {number}", own, places[items])
        groups.append((items, places[items], own))
    return SonataItems(name, kind, type_ids, types, tuple(groups), frozenset(_unread(part)))


def _unread(part: Any) -> Iterator[str]:
    """Yield the names of attributes that are not numbers, and of groups that are not read."""
    numbered = [part[key] for key in part if key.isdigit()]
    held = [one[DYNAMICS] for one in numbered if DYNAMICS in one]
    for parent in (part, *numbered, *held):
        for name in parent:
            found = parent[name]
            if not hasattr(found, "dtype"):
                if not (name.isdigit() or name.startswith("@") or name in _GROUPS):
                    yield name
            elif found.dtype.kind not in "iuf":
                yield name


def _require_both(part: Any, name: str, kind: str) -> None:
    """Refuse places in groups without the groups, and the reverse.

    Raises:
        NetworkError: one of the two datasets is missing.
    """
    pair = [f"{kind}_group_id", f"{kind}_group_index"]
    missing = [one for one in pair if one not in part]
    if len(missing) == 1:
        (there,) = set(pair) - set(missing)
        raise NetworkError(f"{kind}s '{name}' have '{there}' and no '{missing[0]}'")


def _own(part: Any) -> dict[str, np.ndarray[Any, Any]]:
    """Return the numbers in a group, including its ``dynamics_params``; one for each of its items."""
    found = {}
    for parent in (part, *([part[DYNAMICS]] if DYNAMICS in part else [])):
        for name in parent:
            dataset = parent[name]
            if hasattr(dataset, "dtype") and dataset.dtype.kind in "iuf":
                found[name] = np.asarray(dataset[()], dtype=float)
    if "positions" in found and found["positions"].ndim == 2:
        found |= dict(zip("xyz", found.pop("positions").T, strict=False))
    for name, values in found.items():
        if values.ndim != 1:
            raise NetworkError(
                f"the dataset '{part.name}/{name}' has the shape {values.shape}; it must be a list of numbers"
            )
    return found


def _require_rows(owner: str, own: Mapping[str, np.ndarray[Any, Any]], places: IntArray) -> None:
    if not len(places):
        return
    first, last = int(places.min()), int(places.max())
    for name, values in own.items():
        if first < 0 or last >= len(values):
            raise NetworkError(f"{owner}: '{name}' has {len(values)} values, and place {last} is used")


def read_types(path: Path | None, kind: str, parameters: Path) -> Types:
    """Read a table of types, with the parameter files that it names.

    Args:
        path: the table of space-separated, optionally quoted values; None: all items are of one type, 0.
        kind: ``node`` or ``edge``.
        parameters: the folder of the files in its column ``dynamics_params``.

    Raises:
        NetworkError: a file is missing or not valid.
    """
    if path is None:
        return {0: Attributes()}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            table = csv.DictReader(file, delimiter=" ", quotechar='"', skipinitialspace=True)
            rows = list(table)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise NetworkError(f"the table of types cannot be read: {reason}", path=path) from error
    names = [name for name in table.fieldnames or () if name]
    for name in names:
        if names.count(name) > 1:
            raise NetworkError(f"the column '{name}' is given twice", path=path, line=1)
    found = {}
    for line, row in enumerate(rows, 2):
        number = row.get(f"{kind}_type_id")
        if number is None or not number.isdigit():
            hint = (
                "; columns are separated by spaces, not ','"
                if any("," in name for name in row if name)
                else ""
            )
            raise NetworkError(f"has no number in the column '{kind}_type_id'{hint}", path=path, line=line)
        if surplus := [value for value in row.get(None) or () if value]:
            raise NetworkError(
                f"has {len(surplus)} more values than there are columns, from '{surplus[0]}' on",
                path=path, line=line,
            )  # fmt: skip
        if int(number) in found:
            raise NetworkError(f"the {kind}_type_id {number} is given a second time", path=path, line=line)
        values = {name: value for name, value in row.items() if name and _is_given(value)}
        given = _parameters(values.get(DYNAMICS), parameters, path, line)
        found[int(number)] = Attributes({**given, **values})
        found[int(number)].parameters = frozenset(given)
    return found


def _is_given(value: object) -> bool:
    return isinstance(value, str) and value.lower() not in _NOTHING


def _parameters(name: str | None, folder: Path, table: Path, line: int) -> dict[str, Any]:
    if name is None:
        return {}
    if not (folder / name).is_file():
        message = f"there is no file '{name}' of parameters in {folder}"
        raise NetworkError(message, path=table, line=line)
    given = read_object(folder / name, f"the parameters that {table.name}:{line} names")
    return {
        key: value
        for key, value in given.items()
        if value is not None and (value == "" or _is_given(str(value)))
    }
