"""Lines of Python that only name a thing, as a call without its parentheses does."""

from __future__ import annotations

import ast
from collections.abc import Iterator

_LOOKUPS = (ast.Name, ast.Attribute, ast.Subscript)
_ACTIVE = (ast.Call, ast.Await, ast.Yield, ast.YieldFrom, ast.NamedExpr)
"""Expressions with effects."""


def acts(value: ast.expr) -> bool:
    """Return whether an expression may have an effect."""
    return any(isinstance(one, _ACTIVE) for one in ast.walk(value))


def lone_name(value: ast.expr) -> str:
    """Return that an expression which is a statement has no effect; empty if it is more than a name."""
    if not isinstance(value, _LOOKUPS) or acts(value):
        return ""
    return f"'{ast.unparse(value):.60}' alone has no effect: it is not called, assigned or returned"


def lone_names(script: bytes) -> Iterator[str]:
    """Yield a sentence for each line of a script that only names a thing, and is not tried.

    Args:
        script: its text; one that is not Python yields nothing.
    """
    try:
        tree = ast.parse(script)
    except (SyntaxError, ValueError):
        return
    tried = {
        id(one)
        for node in ast.walk(tree)
        if isinstance(node, ast.Try)
        for statement in node.body
        for one in ast.walk(statement)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and id(node) not in tried and (message := lone_name(node.value)):
            yield f"line {node.lineno}: {message}"
