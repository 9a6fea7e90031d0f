"""Turn the code in documents into code for Python 3, and note converted and omitted parts."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import CodeType
from typing import Protocol

from nrp_bibi.model.values import dedented_variants

from nrp_core.findings import Code
from nrp_core.xml import Element
from nrp_legacy.python2 import Converted, converted, executable, refusal


class Notes(Protocol):
    """Takes a note."""

    def __call__(self, code: Code, message: str, *, subject: str | None = None) -> object:
        """Take a note.

        Args:
            code: its kind.
            message: the note.
            subject: the name of the object concerned, if any.
        """


def ignore_note(code: Code, message: str, *, subject: str | None = None) -> None:
    """Drop a note, which was taken at an earlier reading."""


@contextmanager
def without_deprecation_warnings() -> Iterator[None]:
    """Suppress warnings about deprecated Python in this block."""
    with warnings.catch_warnings():
        for outdated in (DeprecationWarning, PendingDeprecationWarning, FutureWarning, SyntaxWarning):
            warnings.simplefilter("ignore", outdated)
        yield


@dataclass(frozen=True, slots=True)
class Source:
    """A piece of Python 2 or Python 3.

    Args:
        text: the code.
        path: its file.
        first_line: the line of that file on which it begins.
    """

    text: str
    path: Path
    first_line: int = 1

    @classmethod
    def of_file(cls, path: Path) -> Source:
        """Read a file in any encoding, with any line ends."""
        raw = path.read_bytes()
        try:
            text = raw.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = raw.decode("latin-1")
        text = text.replace("\r\n", "\n").replace("\r", "\n")
        # the platform removed common indentation
        return cls(text if _can_be_read(text) else _least_deep(text), path)

    @classmethod
    def of_element(cls, element: Element) -> Source:
        """Read indented code in a document; its first line may have another indentation."""
        raw = element.raw_text.rstrip()
        code = raw.lstrip("\n \t") if "\n" not in raw.strip() else raw
        blank = len(raw) - len(raw.lstrip())
        first = element.end_line - element.raw_text.count("\n") + raw[:blank].count("\n")
        return cls(_least_deep(code), element.path, first)

    def tree(self, notes: Notes) -> ast.Module:
        """Return its syntax tree in Python 3, with the line numbers of its file.

        Args:
            notes: called with a note about each conversion.

        Raises:
            TransferFunctionError: it is neither Python 3 nor Python 2.
        """
        tree = ast.fix_missing_locations(self._converted(notes).tree)
        self._compiled(tree)  # finds errors that the parser accepts
        return tree

    def _converted(self, notes: Notes) -> Converted:
        try:
            with without_deprecation_warnings():
                result = converted(self.text)
        except SyntaxError as error:
            raise refusal(error, self.path, self.first_line) from None
        if result.changes:
            message = f"{self.path.name}: leftovers of Python 2 were converted: {', '.join(result.changes)}"
            notes(Code.NRP255, message, subject=self.path.name)
        ast.increment_lineno(result.tree, self.first_line - 1)
        return result

    def compiled(self, notes: Notes) -> CodeType:
        """Return compiled code whose errors name its file and line.

        Raises:
            TransferFunctionError: as for :meth:`tree`.
        """
        return self._compiled(executable(self._converted(notes)))

    def _compiled(self, tree: ast.Module) -> CodeType:
        try:
            with without_deprecation_warnings():
                return compile(tree, str(self.path), "exec", dont_inherit=True)
        except SyntaxError as error:  # such as two parameters of one name
            raise refusal(error, self.path, 1) from None


def compiled_file(path: Path) -> CodeType:
    """Return the compiled code of a file in Python 2 or 3, for imported files."""
    return Source.of_file(path).compiled(ignore_note)


def _least_deep(code: str) -> str:
    """Return code without its common indentation: the first variant that can be parsed, else the first."""
    variants = list(dedented_variants(code))
    return next((one for one in variants if _can_be_read(one)), variants[0])


def _can_be_read(code: str) -> bool:
    try:
        with without_deprecation_warnings():
            converted(code)
    except SyntaxError:
        return False
    return True


def defined(tree: ast.Module) -> Iterator[str]:
    """Yield the names that code defines for others: at its top level, or by ``global``."""
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.name
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            yield from (
                one.id
                for one in ast.walk(node)
                if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)
            )
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            yield from ((alias.asname or alias.name).partition(".")[0] for alias in node.names)
