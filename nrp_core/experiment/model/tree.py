"""Data with the place of each value, kept through merging and overriding."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.paths import TextFrom

Key = str | int


@dataclass(frozen=True, slots=True)
class Place:
    """The place of a value.

    Args:
        path: the file; None: given on the command line or in Python.
        line, column: 1-based.
        override: the override ``key=value`` that contains it, if any.
    """

    path: Path | None = None
    line: int | None = None
    column: int | None = None
    override: str | None = None

    def __str__(self) -> str:
        """Return ``file:line``, ``-s key=value``, or ``Python`` for data without a place."""
        if self.override is not None:
            return f"-s {self.override}"
        return "Python" if self.path is None else f"{self.path.name}:{self.line}"

    @property
    def folder(self) -> Path:
        """The folder of relative paths written here."""
        return Path.cwd() if self.path is None else self.path.parent

    def finding(self, code: Code, message: str, level: Level = Level.ERROR) -> Finding:
        """Return a finding with this place."""
        text = f"in the override '{self.override}': {message}" if self.override else message
        return Finding(code, text, level, self.path, self.line, self.column)

    def error(self, message: str) -> ExperimentError:
        """Return an error with this place."""
        return self.finding(Code.NRP202, message).as_error()


@dataclass(frozen=True, slots=True)
class Tree:
    """A value with its place.

    Args:
        value: a scalar, or a dictionary or list of trees.
        place: the place of the value.
        key_place: the place of its key; its own place if it has none.
    """

    value: Any
    place: Place = Place()
    key_place: Place | None = None

    def plain(self) -> Any:
        """Return the plain data; strings have the folder of their file."""
        if isinstance(self.value, dict):
            return {key: child.plain() for key, child in self.value.items()}
        if isinstance(self.value, list):
            return [child.plain() for child in self.value]
        return TextFrom.of(self.value, self.place.folder) if isinstance(self.value, str) else self.value

    def place_of(self, *keys: Key) -> Place:
        """Return the place of the value under these keys, or of the nearest enclosing one."""
        return self.nearest(keys)[0].place

    def nearest(self, keys: Sequence[Key]) -> tuple[Tree, tuple[Key, ...]]:
        """Follow keys as far as possible, skipping those that are not in the data.

        Returns:
            the tree reached and the keys that led to it.
        """
        tree, followed = self, []
        for key in keys:
            child = tree.child(key)
            if child is not None:
                tree = child
                followed.append(key)
        return tree, tuple(followed)

    def child(self, key: Key) -> Tree | None:
        """Return the value under a key or at an index, or None."""
        if isinstance(self.value, dict):
            return self.value.get(key)
        if isinstance(self.value, list) and isinstance(key, int) and 0 <= key < len(self.value):
            return self.value[key]  # type: ignore[no-any-return]
        return None

    def at(self, *keys: str) -> Tree | None:
        """Return the tree under these keys, None if it is not there."""
        tree: Tree | None = self
        for key in keys:
            tree = tree.value.get(key) if tree is not None and isinstance(tree.value, dict) else None
        return tree

    def merged(self, over: Tree) -> Tree:
        """Merge another tree over this one: mappings are merged, ``null`` removes, all else replaces."""
        if not (isinstance(self.value, dict) and isinstance(over.value, dict)):
            return over
        joined = dict(self.value)
        for key, child in over.value.items():
            if child.value is None:
                joined.pop(key, None)
            else:
                joined[key] = joined[key].merged(child) if key in joined else child
        return replace(over, value=joined)

    def overridden(self, keys: Sequence[str], over: Tree) -> Tree:
        """Set a tree under dotted keys, creating mappings.

        Raises:
            ExperimentError: the keys lead into a list with no such item, or through a scalar.
        """
        if not keys:
            return self.merged(over)
        key, rest = keys[0], keys[1:]
        if self.value is None:
            if key.isdecimal():
                raise over.place.error(f"there is no list with an item '{key}': set the whole list")
            return Tree({}, over.place).overridden(keys, over)
        if isinstance(self.value, dict):
            below = self.value.get(key, Tree(None, over.place, over.place)).overridden(rest, over)
            items = {**self.value, key: below}
            if below.value is None:
                del items[key]
            return replace(self, value=items)
        if isinstance(self.value, list):
            index = _index(key, len(self.value), over.place)
            children = list(self.value)
            children[index] = children[index].overridden(rest, over)
            return replace(self, value=children)
        raise over.place.error(f"'{key}' cannot be set: the value above it is {self.value!r}, not a mapping")


def tree_of(data: Any) -> Tree:
    """Return plain data as a tree without places; numbers and arrays may be NumPy's."""
    if isinstance(data, Mapping):
        return Tree({str(key): tree_of(value) for key, value in data.items()})
    if isinstance(data, (list, tuple, range)) or getattr(data, "ndim", 0) > 0:
        return Tree([tree_of(value) for value in data])
    return Tree(data.item() if hasattr(data, "item") else data)


def _index(key: str, length: int, place: Place) -> int:
    if not key.isdecimal() or int(key) >= length:
        valid = did_you_mean(key, map(str, range(length)))
        raise place.error(f"the list has no item '{key}'{valid}")
    return int(key)
