"""The text of code in messages."""

from __future__ import annotations

import ast
from typing import Final

_LONGEST: Final = 60
"""Characters of code that a message quotes."""


def excerpt(node: ast.AST, longest: int = _LONGEST) -> str:
    """Return the text of an expression or a statement, which ends with '...' if it is cut."""
    text = ast.unparse(node)
    return text if len(text) <= longest else f"{text[: longest - 3]}..."
