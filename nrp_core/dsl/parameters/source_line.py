"""Lines of users' files."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from types import CodeType, TracebackType
from typing import TypeVar

from nrp_core.errors import ExperimentError, Instead, TransferFunctionError

E = TypeVar("E", bound=ExperimentError)


@dataclass(frozen=True, slots=True)
class SourceLine:
    """A line of a file.

    Args:
        path: the file name that Python reports; ``<stdin>`` and the like if there is no file.
        line: 1-based.
    """

    path: str
    line: int

    @classmethod
    def of_caller(cls) -> SourceLine:
        """Return the line that called into this package, or into a module that extends it.

        Such a module defines the variable ``__extends_dsl__``.
        """
        frame = sys._getframe(1)
        while frame.f_back is not None and _is_language(frame.f_globals):
            frame = frame.f_back
        return cls(frame.f_code.co_filename, frame.f_lineno)

    @classmethod
    def of_code(cls, code: CodeType) -> SourceLine:
        """Return the first line of a function, including its decorators."""
        return cls(code.co_filename, code.co_firstlineno)

    def __str__(self) -> str:
        return f"{self.path}:{self.line}"

    def error(self, message: str, instead: Instead | None = None) -> TransferFunctionError:
        """Return an error at this line."""
        return TransferFunctionError(message, path=self.path, line=self.line, instead=instead)

    def located(self, error: E, context: str) -> E:
        """Return an error of the same class with its place; an error that has a place is unchanged."""
        if error.path is not None:
            return error
        message = f"{context}: {error.message}"
        return type(error)(message, path=self.path, line=self.line, instead=error.instead)


def line_in(trace: TracebackType | None, path: str) -> int | None:
    """Return the innermost line of a file in a traceback, or None."""
    line = None
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == path:
            line = trace.tb_lineno
        trace = trace.tb_next
    return line


def _is_language(names: Mapping[str, object]) -> bool:
    return str(names.get("__name__", "")).startswith(_PACKAGE) or "__extends_dsl__" in names


_PACKAGE = __name__.rsplit(".", 2)[0] + "."
