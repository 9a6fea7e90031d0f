"""The contents of an experiment file: data with places, ranges of settings, and the base of all sections.

Sections refuse unknown keys and check names. Merging and overriding keep the place of each value.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from nrp_core._support.plain_numbers import PlainNumbers
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.paths import TextFrom
from nrp_core.quantities import AngleRad, LengthM
from nrp_core.seeds import Seeds

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
        """Return the tree under these keys, or None."""
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


_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
_RANGE = re.compile(rf"(?P<low>{_NUMBER})\s*\.\.\s*(?P<high>{_NUMBER})\s*(?P<unit>[^\d\s].*)?")


@dataclass(frozen=True, slots=True)
class Range:
    """The range from which a setting is drawn, uniformly.

    Args:
        low, high: the ends.
        unit: their unit; may be empty.
    """

    low: float
    high: float
    unit: str

    @classmethod
    def parse(cls, value: object) -> Range:
        """Read ``4..8 s``; return a range unchanged.

        Raises:
            ValueError: it has another form, or its end is not above its beginning.
        """
        if isinstance(value, cls):
            return value
        found = _RANGE.fullmatch(str(value).strip())
        if found is None:
            raise ValueError(f"a range is written LOW..HIGH UNIT, as 4..8 s, not '{value}'")
        low, high = float(found["low"]), float(found["high"])
        if not low < high:
            raise ValueError(f"{low:g}..{high:g} is not a range: its end must be above its beginning")
        return cls(low, high, (found["unit"] or "").strip())

    def __str__(self) -> str:
        return f"{self.low:g}..{self.high:g} {self.unit}".strip()

    def override(self, key: str, seed: int) -> str:
        """Return the setting ``key`` for a seed, the same on every backend, in thousandths of the range."""
        drawn = Seeds(seed).child("vary").stream(key).integers(0, 1000, endpoint=True) / 1000
        return f"{key}={self.low + drawn * (self.high - self.low):.9g} {self.unit}".strip()


def keyed_range(text: str) -> tuple[str, Range]:
    """Read ``events.go.at=4..8 s``: a dotted key, as in an override, and its range.

    Raises:
        ValueError: it has another form.
    """
    key, equals, value = text.partition("=")
    if not (equals and key.strip()):
        raise ValueError(f"a range is written KEY=LOW..HIGH UNIT, as events.go.at=4..8 s, not '{text}'")
    return key.strip(), Range.parse(value)


class Section(PlainNumbers):
    """Base of every section; the docstrings of its fields are their documentation, also in editors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    alternatives: ClassVar[Sequence[str]] = ()  # the fields of which exactly one is given

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler, /
    ) -> JsonSchemaValue:
        """Add the docstrings of the fields.

        Pydantic can do so when a class is made, but reading the sources would delay every command by 0.1 s.
        """
        schema = handler(core_schema)
        fields = handler.resolve_ref_schema(schema)["properties"]
        for name, text in _documented_fields(cls).items():
            fields[cls.model_fields[name].alias or name]["description"] = text
        return schema

    @model_validator(mode="after")
    def _no_item_twice(self) -> Self:
        """Refuse a file, a name or a section that a list gives twice; numbers in points may be equal."""
        for name in type(self).model_fields:
            items = getattr(self, name)
            for place, item in enumerate(items if isinstance(items, tuple) else ()):
                if isinstance(item, (Path, Section)) and item in items[:place]:
                    first = items.index(item)
                    raise ValueError(f"{name}: items {first} and {place} of the list are the same")
        return self

    @model_validator(mode="after")
    def _one_alternative(self) -> Self:
        given = [name for name in self.alternatives if getattr(self, name) is not None]
        if self.alternatives and len(given) != 1:
            found = " and ".join(f"'{name}'" for name in given) or "none"
            raise ValueError(f"needs exactly one of {', '.join(self.alternatives)}; it has {found}")
        return self


def _documented_fields(section: type[BaseModel]) -> dict[str, str]:
    """Return the docstring of each field of a class, its own and those it inherits."""
    documented: dict[str, str] = {}
    for base in reversed(section.__mro__):
        if issubclass(base, Section):
            documented |= _fields_documented_in(base)
    return documented


@cache
def _fields_documented_in(section: type[BaseModel]) -> dict[str, str]:
    """Return the docstring of each field that a class defines itself; its source is read once."""
    documented: dict[str, str] = {}
    (definition,) = ast.parse(dedent(inspect.getsource(section))).body
    assert isinstance(definition, ast.ClassDef)
    for field, text in pairwise(definition.body):
        match field, text:
            case ast.AnnAssign(target=ast.Name(name)), ast.Expr(ast.Constant(str(written))):
                documented[name] = inspect.cleandoc(written)
    return documented


def identifier(name: str) -> str:
    """Return a name; raise a ValueError if it is not an identifier."""
    if not str(name).isidentifier():
        raise ValueError(f"a name has letters, digits and '_', and no digit first: not '{name}'")
    return name


def _absolute(topic: str) -> str:
    if not re.fullmatch(r"(/\w+)+", topic):
        raise ValueError(f"a topic reads like '/husky/camera', not '{topic}'")
    return topic


NAME_PATTERN = r"^[A-Za-z_]\w*$"
Name = Annotated[str, AfterValidator(identifier), Field(json_schema_extra={"pattern": NAME_PATTERN})]
"""Name of a thing of the experiment: a robot, an event, a criterion, a population."""

TopicName = Annotated[str, AfterValidator(_absolute), Field(json_schema_extra={"pattern": r"^(/\w+)+$"})]
"""Absolute name of a topic."""


def _six_values(value: object) -> object:
    if isinstance(value, (list, tuple)) and len(value) != 6:
        raise ValueError(f"a pose is [x, y, z, roll, pitch, yaw], 6 values, not {len(value)}")
    return value


PoseList = Annotated[
    tuple[LengthM, LengthM, LengthM, AngleRad, AngleRad, AngleRad], BeforeValidator(_six_values)
]
"""A pose: x, y, z, roll, pitch, yaw, in m and rad or with units."""
