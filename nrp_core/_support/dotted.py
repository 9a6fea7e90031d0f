"""Dotted names in code."""

from __future__ import annotations

import ast


def last_name(node: ast.expr) -> str:
    """Return ``c`` for the expression ``a.b.c``, and for ``c`` alone."""
    return ast.unparse(node).rpartition(".")[2]
