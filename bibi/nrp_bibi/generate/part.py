"""A piece of Python, and where each of its lines comes from."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path
from types import CodeType

from nrp_core.errors import TransferFunctionError

_PLACED = (ast.stmt, ast.expr, ast.arg, ast.keyword, ast.alias, ast.excepthandler, ast.pattern)


@dataclass(frozen=True, slots=True)
class Part:
    """Generated or written code.

    Args:
        text: the code, without a line end at the end.
        path: the file that it comes from.
        lines: for each line of the code, its line in that file.
    """

    text: str
    path: Path
    lines: tuple[int, ...]

    def compiled(self) -> CodeType:
        """Return the code as if each line stood where it comes from: errors name that file and line.

        Raises:
            TransferFunctionError: it is not Python.
        """
        try:
            tree = ast.parse(self.text)
        except SyntaxError as error:
            raise self._refusal(error, self._source(error.lineno or 1)) from None
        for node in ast.walk(tree):
            if isinstance(node, _PLACED):
                node.lineno = node.end_lineno = self._source(node.lineno)
                node.col_offset = node.end_col_offset = 0
        try:
            return compile(tree, str(self.path), "exec", dont_inherit=True)
        except SyntaxError as error:
            raise self._refusal(error, error.lineno) from None

    def _refusal(self, error: SyntaxError, line: int | None) -> TransferFunctionError:
        return TransferFunctionError(f"this is not Python: {error.msg}", path=self.path, line=line)

    def _source(self, line: int) -> int:
        return self.lines[min(line, len(self.lines)) - 1]
