"""JSON files of a circuit: one object in which every name is given once."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from nrp_core.errors import NetworkError


def read_object(path: Path, what: str) -> dict[str, Any]:
    """Return the object in a file.

    Args:
        path: the file.
        what: its contents, in messages: 'the configuration'.

    Raises:
        NetworkError: the file cannot be read, is not JSON, gives a name twice, or holds something else.
    """
    try:
        given = json.loads(path.read_text("utf-8"), parse_constant=_refuse, object_pairs_hook=_distinct)
    except OSError as error:
        raise NetworkError(f"{what} cannot be read: {error.strerror}", path=path) from error
    except ValueError as error:
        line = getattr(error, "lineno", None)
        raise NetworkError(f"{what} cannot be read: {error}", path=path, line=line) from error
    if not isinstance(given, dict):
        raise NetworkError(f"{what} is not a JSON object", path=path)
    return given


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a value in JSON")


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"'{name}' is given twice")
    return dict(pairs)
