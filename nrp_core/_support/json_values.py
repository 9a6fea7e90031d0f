"""Convert dataclasses, models, arrays and other values to JSON data."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from enum import Enum
from typing import Any

from pydantic import BaseModel


def strict_json(text: str) -> Any:
    """Return the data in a text.

    Raises:
        ValueError: it is not JSON, gives a name twice in one object, or has NaN or an infinite number.
    """
    return json.loads(text, parse_constant=_refuse, object_pairs_hook=_distinct)


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a value in JSON")


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"'{name}' is given twice")
    return dict(pairs)


def to_jsonable(data: Any) -> Any:
    """Return dataclasses and models as objects, sets sorted, NaN and infinity as null, the rest as text."""
    match data:
        case Enum():
            return to_jsonable(data.value)
        case None | bool() | int() | str():
            return data
        case float():
            return data if math.isfinite(data) else None
        case set() | frozenset():
            return sorted(map(to_jsonable, data))
        case list() | tuple():
            return [to_jsonable(value) for value in data]
        case type():
            return getattr(data, "__msgtype__", data.__qualname__)
    named = _named_fields(data)
    if named is not None:
        return {str(name): to_jsonable(value) for name, value in named.items()}
    return to_jsonable(data.tolist()) if hasattr(data, "tolist") else str(data)


def _named_fields(data: Any) -> Mapping[Any, Any] | None:
    """Return the named fields of a dataclass or model."""
    if isinstance(data, Mapping):
        return data
    if isinstance(data, BaseModel):
        return {name: getattr(data, name) for name in type(data).model_fields}
    if dataclasses.is_dataclass(data):
        return {field.name: getattr(data, field.name) for field in dataclasses.fields(data)}
    return None
