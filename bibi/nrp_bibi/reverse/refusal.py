"""The error for Python that building blocks cannot express."""

from __future__ import annotations

import ast


class NotExpressibleError(Exception):
    """Building blocks cannot express a piece of Python."""

    @classmethod
    def of(cls, node: ast.AST) -> NotExpressibleError:
        """Return the error for a syntax tree."""
        return cls(ast.unparse(node))
