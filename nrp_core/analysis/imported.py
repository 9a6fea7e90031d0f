"""A name that an import binds."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from nrp_core.analysis.shapes import UNKNOWN, Shape


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
