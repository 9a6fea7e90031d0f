"""Refuse true and false for numbers in files, which Python and pydantic take for 1 and 0."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator
from pydantic.fields import FieldInfo


class PlainNumbers(BaseModel):
    """Base of models that refuse text and flags as numbers; types with their own validator decide themselves.

    A model is built when it is used first, so that those that are only parts of others are built once.
    """

    model_config = ConfigDict(defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _no_flag_for_a_number(cls, value: object, info: ValidationInfo) -> object:
        if info.field_name is not None:
            _require_no_flag(value, _kind_of(cls.model_fields[info.field_name]))
        return value


def _kind_of(field: FieldInfo) -> Any:
    """Return the annotation of a field, with the validators that pydantic keeps beside it."""
    return Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation


def _require_no_flag(value: object, kind: Any, name: str = "") -> None:
    """Refuse a flag where only a number fits.

    Raises:
        ValueError: one was found; in a mapping the message names its key.
    """
    if isinstance(value, bool) and (number := _number(kind)):
        raise ValueError(f"{name}should be a valid {number}, not {value}")
    arguments = get_args(kind)
    if isinstance(value, Mapping) and get_origin(kind) is dict:
        for key, one in value.items():
            _require_no_flag(one, arguments[1], f"'{key}' ")
    elif isinstance(value, (list, tuple)) and get_origin(kind) in (list, tuple):
        for one in value:
            _require_no_flag(one, arguments[0])


@lru_cache(256)
def _number(kind: Any) -> str:
    """Return the kind of number that an annotation takes; empty if it reads a flag in its own way."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return "" if any(hasattr(one, "func") for one in arguments[1:]) else _number(arguments[0])
    if origin in (Union, UnionType):
        kinds = {_number(one) for one in arguments if one is not type(None)}
        return "" if "" in kinds else "number" if "number" in kinds else "integer"
    return {int: "integer", float: "number"}.get(kind, "")
