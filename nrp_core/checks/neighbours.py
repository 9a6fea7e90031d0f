"""The modules beside a file of transfer functions, read and not executed."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from pathlib import Path

from nrp_core.checks.imported import ImportsOf
from nrp_core.checks.shapes import UNKNOWN, Names
from nrp_core.checks.statements import Statements, changed_in
from nrp_core.dsl.loading.listing import PythonSource, python_listing
from nrp_core.errors import ExperimentError, TransferFunctionError

_HIDING = frozenset({"globals", "exec", "setattr", "vars", "locals", "__getattr__"})
"""Constructs that give a module names which are not written in it."""


class Neighbours:
    """The modules beside files that they import, each read once.

    Args:
        written: attributes of modules that the files set.

    Attributes:
        sources: the source files.
        errors: the mistakes found.
    """

    def __init__(self, written: Iterable[str]) -> None:
        self.sources: dict[Path, PythonSource] = {}
        self.errors: list[ExperimentError] = []
        self._written = dict.fromkeys(written, UNKNOWN)
        self._found: dict[Path, Names | None] = {}

    def names_of(self, path: Path, imports: ImportsOf) -> Names | None:
        """Return the names of a module; None if they cannot be determined.

        Args:
            path: its file.
            imports: returns the imports of a statement in it.
        """
        if path not in self._found:
            self._found[path] = None  # for modules that import each other
            try:
                source = python_listing(path).sources[0]
            except TransferFunctionError as error:
                self.errors.append(error)
                return None
            self.sources[path] = source
            self._found[path] = self._read(source, imports)
        return self._found[path]

    def _read(self, source: PythonSource, imports: ImportsOf) -> Names | None:
        if any(_hides(node) for node in ast.walk(source.tree)):
            return None
        module = _Module(source, imports)
        self.errors += module.errors
        return Names(source.path.stem, {**module.names, **self._written}) if module.is_whole else None


class _Module(Statements):
    """Reads a module.

    Args:
        source: its source.
        imports: returns the imports of a statement in it.

    Attributes:
        errors: the mistakes found.
        is_whole: whether all its names are known.
    """

    def __init__(self, source: PythonSource, imports: ImportsOf) -> None:
        super().__init__({}, (), source.path, changed_in(source.tree))
        self._imports = imports
        self.errors: list[ExperimentError] = []
        self.is_whole = True
        for node in ast.walk(source.tree):  # names set in branches and functions may exist, too
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                self.names[node.id] = UNKNOWN
        self.follow_file(source.tree.body)
        for written in self.written:
            if _may_declare(written.node):
                self.names[written.node.name] = UNKNOWN

    def _do_import(self, node: ast.Import | ast.ImportFrom) -> None:
        for imported in self._imports(node, self.path):
            self.is_whole &= imported.name != "*"
            self.names[imported.name] = imported.shape
            if imported.wrong:
                error = TransferFunctionError(
                    imported.wrong, path=self.path, line=node.lineno, column=node.col_offset + 1
                )
                self.errors.append(error)

    _do_importfrom = _do_import


def _hides(node: ast.AST) -> bool:
    name = node.id if isinstance(node, ast.Name) else getattr(node, "name", "")
    return name in _HIDING


def _may_declare(function: ast.FunctionDef) -> bool:
    """Return whether a function is used as a decorator, which may create transfer functions."""
    return any(
        isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef)) and one.decorator_list
        for one in ast.walk(function)
    )
