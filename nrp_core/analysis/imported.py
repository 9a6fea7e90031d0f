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
        shape: what it is.
        wrong: why the import finds nothing; empty if it does.
    """

    name: str
    shape: Shape = UNKNOWN
    wrong: str = ""


ImportsOf: TypeAlias = Callable[[ast.Import | ast.ImportFrom, Path], Iterable[Imported]]
"""Gives the names that a statement in a file imports."""
