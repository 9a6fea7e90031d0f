"""What building blocks cannot say."""

from __future__ import annotations

import ast


class NotExpressibleError(Exception):
    """A piece of Python that has no counterpart in the model."""

    @classmethod
    def of(cls, node: ast.AST) -> NotExpressibleError:
        """Return the error about a syntax tree."""
        return cls(ast.unparse(node))
