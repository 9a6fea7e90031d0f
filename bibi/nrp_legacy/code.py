"""Code as documents carry it, turned into what Python runs."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent
from types import CodeType

from nrp_bibi.model.values import dedented

from nrp_core._support.xml import Element
from nrp_legacy.python2 import Converted, converted, executable, refusal

Notes = Callable[[str], None]


@contextmanager
def as_of_old() -> Iterator[None]:
    """Let code in this block use what has been deprecated since, without a warning at each place."""
    with warnings.catch_warnings():
        for outdated in (DeprecationWarning, PendingDeprecationWarning, FutureWarning, SyntaxWarning):
            warnings.simplefilter("ignore", outdated)
        yield


@dataclass(frozen=True, slots=True)
class Source:
    """A piece of Python, of whichever version.

    Args:
        text: the code.
        path: the file that it stands in.
        first_line: where in that file it begins.
    """

    text: str
    path: Path
    first_line: int = 1

    @classmethod
    def of_file(cls, path: Path) -> Source:
        """Read a file, whatever its encoding and line ends are."""
        raw = path.read_bytes()
        try:
            text = raw.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = raw.decode("latin-1")
        return cls(text.replace("\r\n", "\n").replace("\r", "\n"), path)

    @classmethod
    def of_element(cls, element: Element) -> Source:
        """Read code that stands in a document, deeper than it should and its first line maybe apart."""
        raw = element.raw_text.rstrip()
        code = raw.lstrip("\n \t") if "\n" not in raw.strip() else raw
        blank = len(raw) - len(raw.lstrip())
        first = element.end_line - element.raw_text.count("\n") + raw[:blank].count("\n")
        return cls(_least_deep(code), element.path, first)

    def tree(self, notes: Notes) -> ast.Module:
        """Return what it says in Python 3; lines are those of the file in which it stands.

        Args:
            notes: told what was converted.

        Raises:
            TransferFunctionError: it is neither Python 3 nor Python 2.
        """
        return self._converted(notes).tree

    def _converted(self, notes: Notes) -> Converted:
        try:
            with as_of_old():
                result = converted(self.text)
        except SyntaxError as error:
            raise refusal(error, self.path, self.first_line) from None
        if result.changes:
            notes(f"{self.path.name}: leftovers of Python 2 were converted: {', '.join(result.changes)}")
        ast.increment_lineno(result.tree, self.first_line - 1)
        return result

    def compiled(self, notes: Notes) -> CodeType:
        """Return what Python 3 runs; errors in it name the file and line in which it stands.

        Raises:
            TransferFunctionError: as of :meth:`tree`.
        """
        tree = executable(self._converted(notes))
        try:
            with as_of_old():
                return compile(tree, str(self.path), "exec", dont_inherit=True)
        except SyntaxError as error:  # such as two parameters of one name
            raise refusal(error, self.path, 1) from None


def compiled_file(path: Path) -> CodeType:
    """Return what a file of whichever Python means, for files that others import."""
    return Source.of_file(path).compiled(lambda _note: None)


def _least_deep(code: str) -> str:
    """Return code without the depth at which it stands, whichever of its lines have another one.

    What can be read decides which was meant: the first line may stand apart, and comments anywhere.
    """
    meant = dedented(code)
    lines = meant.split("\n")
    apart = "\n".join([lines[0].lstrip(), dedent("\n".join(lines[1:]))])
    uncommented = dedent("\n".join("" if line.lstrip().startswith("#") else line for line in lines))
    return next((one for one in (meant, apart, uncommented) if _can_be_read(one)), meant)


def _can_be_read(code: str) -> bool:
    try:
        with as_of_old():
            converted(code)
    except SyntaxError:
        return False
    return True
