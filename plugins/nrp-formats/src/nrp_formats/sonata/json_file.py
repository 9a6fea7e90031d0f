"""JSON files of a circuit: one object in which every name is given once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrp_core.errors import NetworkError
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
