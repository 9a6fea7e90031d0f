"""The text of code in messages, and numbers that are written in it."""

from __future__ import annotations

import ast
from typing import Final

_LONGEST: Final = 60
"""Characters of code that a message quotes."""


def excerpt(node: ast.AST, longest: int = _LONGEST) -> str:
    """Return the text of an expression or a statement, which ends with '...' if it is cut."""
    text = ast.unparse(node)
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


def number_of(node: ast.expr) -> float | None:
    """Return a number that is written out; None for anything else."""
    match node:
        case ast.Constant(bool()):
            return None
        case ast.Constant(int() | float() as number):
            return float(number)
        case ast.UnaryOp(ast.USub(), ast.Constant(int() | float() as number)):
            return -float(number)
    return None
