"""The names that imports bind."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from nrp_core.checks.shapes import UNKNOWN, Shape


@dataclass(frozen=True, slots=True)
class Imported:
    """A name that an import binds.

    Args:
        name: the name.
        shape: its shape.
        wrong: why the import fails; empty if it does not.
    """

    name: str
    shape: Shape = UNKNOWN
    wrong: str = ""


ImportsOf: TypeAlias = Callable[[ast.Import | ast.ImportFrom, Path], Iterable[Imported]]
"""Returns the names that a statement in a file imports."""


def full_names(tree: ast.Module) -> dict[str, str]:
    """Return the full names of imported modules and of the names imported from them."""
    found: dict[str, str] = {}
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                found |= {alias.asname or alias.name: alias.name for alias in names}
            case ast.ImportFrom(module=str(module), names=names, level=0):
                found |= {alias.asname or alias.name: f"{module}.{alias.name}" for alias in names}
    return found
