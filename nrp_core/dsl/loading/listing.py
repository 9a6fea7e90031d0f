"""The source of transfer functions, parsed but not executed."""

from __future__ import annotations

import ast
import operator
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nrp_core._support.encoding import Misfit, decoded_python
from nrp_core.dsl.loading.imports import file_scope
from nrp_core.dsl.loading.loader import file_names
from nrp_core.errors import TransferFunctionError
from nrp_core.scripts import Scope

_PLACED = (ast.stmt, ast.expr, ast.arg, ast.keyword, ast.alias, ast.excepthandler, ast.pattern)


@dataclass(frozen=True, slots=True)
class PythonSource:
    """A piece of Python.

    Args:
        path: the file that it comes from.
        tree: its syntax tree, with the lines of that file.
        has_columns: whether its columns are those of the file too.
    """

    path: Path
    tree: ast.Module
    has_columns: bool = True

    @classmethod
    def of(cls, text: str, path: Path, lines: Sequence[int] | None = None) -> PythonSource:
        """Read a text.

        Args:
            text: the code.
            path: the file that it comes from.
            lines: the line in the file of each line of the code; None: they are the same.

        Raises:
            TransferFunctionError: the text is not Python.
        """

        def line_of(line: int) -> int:
            return line if lines is None else lines[min(line, len(lines)) - 1]

        try:
            tree = ast.parse(text)
            with warnings.catch_warnings():  # they are shown where it is executed
                warnings.simplefilter("ignore")
                compile(tree, str(path), "exec", dont_inherit=True)  # sees two parameters of one name
        except SyntaxError as error:
            line, column = line_of(error.lineno or 1), error.offset if lines is None else None
            message = f"this is not Python: {error.msg}"
            raise TransferFunctionError(message, path=path, line=line, column=column) from None
        except ValueError as error:  # null characters
            raise TransferFunctionError(f"this is not Python: {error}", path=path) from None
        if lines is not None:
            relocate(tree, line_of)
        return cls(path, tree, lines is None)


def relocate(tree: ast.AST, line_of: Callable[[int], int]) -> None:
    """Map each line of a tree to another line and forget its columns."""
    for node in ast.walk(tree):
        if isinstance(node, _PLACED):
            node.lineno = node.end_lineno = line_of(node.lineno)
            node.col_offset = node.end_col_offset = 0


@dataclass(frozen=True, slots=True)
class Listing:
    """Pieces of Python that share one set of names.

    Args:
        sources: the pieces, in the order in which they would be executed.
        names: their initial names.
        scope: the modules that they can import.
        folders: further folders whose modules they can import.
        divide: the operator ``/`` of their numbers.
    """

    sources: tuple[PythonSource, ...]
    names: Mapping[str, Any] = field(default_factory=file_names)
    scope: Scope | None = None
    folders: tuple[Path, ...] = ()
    divide: Callable[[Any, Any], Any] = operator.truediv

    @property
    def imports(self) -> Scope:
        """The modules that the pieces can import."""
        return self.scope or file_scope(self.names["nrp"])


def python_listing(path: Path) -> Listing:
    """Read a file of transfer functions in Python.

    Raises:
        TransferFunctionError: the file does not exist, or is not Python.
    """
    try:
        text = decoded_python(path.read_bytes())
    except OSError as error:
        raise TransferFunctionError(f"it cannot be read: {error.strerror}", path=path) from None
    if isinstance(text, Misfit):
        raise TransferFunctionError(text.message, path=path, line=text.line, column=text.column)
    return Listing((PythonSource.of(text, path),))
