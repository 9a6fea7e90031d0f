"""A piece of Python, and the source line of each of its lines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import CodeType

from nrp_core.dsl import PythonSource
from nrp_core.errors import TransferFunctionError


@dataclass(frozen=True, slots=True)
class CodePart:
    """Generated or written code.

    Args:
        text: the code, without a newline at the end.
        path: its source file.
        lines: for each line of the code, its line in that file.
    """

    text: str
    path: Path
    lines: tuple[int, ...]

    def source(self) -> PythonSource:
        """Return the syntax tree, with the line numbers of the source file.

        Raises:
            TransferFunctionError: it is not Python.
        """
        return PythonSource.of(self.text, self.path, self.lines)

    def compiled(self) -> CodeType:
        """Return compiled code whose errors name the source file and line.

        Raises:
            TransferFunctionError: it is not Python.
        """
        tree = self.source().tree
        try:
            return compile(tree, str(self.path), "exec", dont_inherit=True)
        except SyntaxError as error:
            message = f"this is not Python: {error.msg}"
            raise TransferFunctionError(message, path=self.path, line=error.lineno) from None
