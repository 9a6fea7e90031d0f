"""The error of this distribution."""

from __future__ import annotations

from typing import Any


class NestmlError(ValueError):
    """A model that cannot be read, or that has something which cells in equations do not have."""


def at(node: Any) -> str:
    """Return the place of a part of a model, for messages."""
    return f"line {node.get_source_position().start_line}"
