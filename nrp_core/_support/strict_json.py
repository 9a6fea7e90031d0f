"""JSON as its standard has it: every name once, and numbers that are numbers."""

from __future__ import annotations

import json
from typing import Any


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
