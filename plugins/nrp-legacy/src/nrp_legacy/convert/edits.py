"""Edits of program text that leave the rest unchanged."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field


@dataclass
class Edits:
    """Replacements in a text.

    Args:
        text: the program.
    """

    text: str
    _made: list[tuple[int, int, str]] = field(default_factory=list)

    def replace(self, node: ast.AST, new: str) -> None:
        """Replace a node by a text; nodes inside a replaced node are ignored."""
        begin, end = self._span(node)
        if any(a <= begin and end <= b for a, b, _ in self._made):
            return
        self._made = [one for one in self._made if not (begin <= one[0] and one[1] <= end)]
        self._made.append((begin, end, new))

    def drop_argument(self, node: ast.keyword) -> None:
        """Remove an argument of a call, with the comma before it."""
        begin, end = self._span(node)
        comma = self.text.rfind(",", 0, begin)
        self._made.append((comma, end, ""))

    def rename_argument(self, node: ast.keyword, name: str) -> None:
        """Rename a keyword argument of a call."""
        begin, _ = self._span(node)
        self._made.append((begin, begin + len(node.arg or ""), name))

    def done(self) -> str:
        """Return the text with all changes."""
        text = self.text
        for begin, end, new in sorted(self._made, reverse=True):
            text = text[:begin] + new + text[end:]
        return text

    def _span(self, node: ast.AST) -> tuple[int, int]:
        lines = [f"{line}\n" for line in self.text.split("\n")]

        def at(line: int, column: int) -> int:
            before = lines[line - 1].encode()[:column].decode()
            return sum(map(len, lines[: line - 1])) + len(before)

        return at(node.lineno, node.col_offset), at(node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]
