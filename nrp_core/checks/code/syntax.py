"""Nodes and texts of Python code."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
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


SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)
"""Nodes that open a scope."""


def own_nodes(nodes: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Yield nodes and their descendants, last first, without the bodies of functions and classes."""
    waiting = list(nodes)
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, SCOPES):
            waiting += ast.iter_child_nodes(node)
