"""Resolve imports without executing the imported modules; those beside a file are read."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from nrp_core.checks.code.values import (
    CHECKED_MODULES,
    UNKNOWN_ATTRIBUTE,
    Known,
    Shape,
    attribute,
    has_attribute,
    names_of,
)
from nrp_core.dsl.loading import Listing, PythonSource, python_listing
from nrp_core.dsl.messages import message_packages
from nrp_core.errors import ExperimentError, TransferFunctionError, did_you_mean

_COMMON = ("numpy", "math", "hbp_nrp_client")
_HIDING = frozenset({"globals", "exec", "setattr", "vars", "locals", "__getattr__"})
"""Constructs that give a module names which are not written in it."""


@dataclass(frozen=True, slots=True)
class Imported:
    """A name that an import binds.

    Args:
        name: the name; ``*`` for names that are unknown.
        shape: its shape.
        error: why the import fails; empty if it does not.
    """

    name: str
    shape: Shape = None
    error: str = ""


class Imports:
    """The imports of one listing.

    Args:
        listing: the listing.
        read: returns the names that a module beside its files sets, given its source.

    Attributes:
        sources: the modules beside its files that were read.
        errors: the modules that cannot be read.
    """

    def __init__(self, listing: Listing, read: Callable[[PythonSource], dict[str, Shape]]) -> None:
        self._scope, self._folders, self._read = listing.imports, listing.folders, read
        # names may mean something else in code of another platform
        self._reads = listing.scope is None
        self.sources: dict[Path, PythonSource] = {}
        self.errors: list[ExperimentError] = []
        self._modules: dict[Path, Shape] = {}

    def of(self, node: ast.Import | ast.ImportFrom, path: Path) -> Iterator[Imported]:
        """Yield the names that a statement in a file imports."""
        if isinstance(node, ast.Import):
            for alias in node.names:
                found, error = self._module(alias.name, path)
                root = alias.name.partition(".")[0]
                if alias.asname is None and root != alias.name:
                    found = self._module(root, path)[0]
                yield Imported(alias.asname or root, found, error)
        elif node.level or not node.module:
            yield from (Imported(alias.asname or alias.name) for alias in node.names)
        else:
            yield from self._from(node.module, node.names, path)

    def _from(self, name: str, aliases: list[ast.alias], path: Path) -> Iterator[Imported]:
        module, error = self._module(name, path)
        for alias in aliases:
            if alias.name != "*":
                is_there = has_attribute(module, alias.name) or self._file(f"{name}.{alias.name}", path)
                hint = "" if is_there else did_you_mean(alias.name, names_of(module))
                lacking = "" if is_there else f"'{name}' has no '{alias.name}'{hint}"
                yield Imported(alias.asname or alias.name, attribute(module, alias.name), error or lacking)
            elif module is None:
                yield Imported("*", error=error)
            else:
                yield from (Imported(one, attribute(module, one)) for one in names_of(module))

    def _module(self, name: str, path: Path) -> tuple[Shape, str]:
        """Return a module and the error of its import."""
        root, _, child = name.partition(".")
        if (ours := self._scope.substitute(name)) is not None:
            return Known(ours), ""
        if root in CHECKED_MODULES:
            try:
                return Known(importlib.import_module(name)), ""
            except ImportError as error:
                return None, str(error)
        file = self._file(name, path)
        if file is not None and self._reads and file.stem == name:
            return self._neighbour(file), ""
        places = (path.parent, *self._folders)
        is_beside = file or self._file(root, path) or any(any((one / root).glob("*.py")) for one in places)
        if is_beside or root in sys.stdlib_module_names or _is_installed(name):
            return None, ""
        parent = self._scope.substitute(root)
        if parent is not None and has_attribute(Known(parent), child.partition(".")[0]):
            return None, ""
        files = (found.stem for found in path.parent.glob("*.py"))
        known = [*files, *message_packages(), *_COMMON] if parent is None else names_of(Known(parent))
        hint = did_you_mean(root if parent is None else child, known)
        return None, f"there is no module '{name}'{hint if hint.instead else ''}"

    def _neighbour(self, file: Path) -> Shape:
        """Return a module beside a file; None if its names are unknown."""
        if file not in self._modules:
            self._modules[file] = None  # for modules that import each other
            try:
                source = self.sources[file] = python_listing(file).sources[0]
            except TransferFunctionError as error:
                self.errors.append(error)
                return None
            if any(_hides_names(node) for node in ast.walk(source.tree)):
                return None
            names = self._read(source)
            if "*" not in names:
                module = ModuleType(file.stem)
                values = {
                    name: one.value if isinstance(one, Known) else UNKNOWN_ATTRIBUTE
                    for name, one in names.items()
                }
                vars(module).update(values)
                self._modules[file] = Known(module)
        return self._modules[file]

    def _file(self, name: str, path: Path) -> Path | None:
        place = name.replace(".", "/")
        files = (
            folder / file
            for folder in (path.parent, *self._folders)
            for file in (f"{place}.py", f"{place}/__init__.py")
        )
        return next((file for file in files if file.is_file()), None)


def _hides_names(node: ast.AST) -> bool:
    name = node.id if isinstance(node, ast.Name) else getattr(node, "name", "")
    return name in _HIDING


def _is_installed(name: str) -> bool:
    """Return whether an installed package may have a module; only its first child is looked for."""
    root, child, *_ = [*name.split("."), ""]
    try:
        spec = find_spec(root)
    except (ImportError, ValueError):
        return False
    places = None if spec is None else spec.submodule_search_locations
    may_make = f"{root}.{child}" in sys.modules or hasattr(sys.modules.get(root), "__getattr__")
    if not child or places is None or may_make:
        return spec is not None
    return PathFinder.find_spec(f"{root}.{child}", list(places)) is not None
