"""The base of all sections of an experiment file: unknown keys are refused, names are checked."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from typing import Annotated, Self

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
from nrp_core.quantities import AngleRad, LengthM


class Section(PlainNumbers):
    """Base of every section; the docstrings of its fields are their documentation, also in editors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

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
            fields[name]["description"] = text
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

    def _require_one_of(self, names: Iterable[str]) -> None:
        """Refuse a section without exactly one of its alternatives.

        Raises:
            ValueError: there are none or several.
        """
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(f"'{name}'" for name in given) or "none"
            raise ValueError(f"needs exactly one of {', '.join(names)}; it has {found}")


def _documented_fields(section: type[BaseModel]) -> dict[str, str]:
    """Return the docstring of each field of a class, its own and those it inherits."""
    documented: dict[str, str] = {}
    for base in reversed(section.__mro__):
        if issubclass(base, Section):
            (definition,) = ast.parse(dedent(inspect.getsource(base))).body
            assert isinstance(definition, ast.ClassDef)
            for field, text in pairwise(definition.body):
                match field, text:
                    case ast.AnnAssign(target=ast.Name(name)), ast.Expr(ast.Constant(str(written))):
                        documented[name] = inspect.cleandoc(written)
    return documented


def _identifier(name: str) -> str:
    if not name.isidentifier():
        raise ValueError(f"a name has letters, digits and '_', and no digit first: not '{name}'")
    return name


def _absolute(topic: str) -> str:
    if not re.fullmatch(r"(/\w+)+", topic):
        raise ValueError(f"a topic reads like '/husky/camera', not '{topic}'")
    return topic


Name = Annotated[str, AfterValidator(_identifier), Field(json_schema_extra={"pattern": r"^[A-Za-z_]\w*$"})]
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
