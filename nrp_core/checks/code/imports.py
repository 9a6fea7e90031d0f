"""Resolve imports without executing the imported modules; those beside a file are read."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Collection, Iterable, Iterator
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

from nrp_core.checks.code.shapes import MODULES, UNKNOWN, Imported, ImportsOf, Known, Names, Shape, attribute
from nrp_core.checks.code.statements import Statements, changed_in
from nrp_core.dsl.loading import Listing, PythonSource, python_listing
from nrp_core.dsl.messages import message_packages
from nrp_core.errors import ExperimentError, TransferFunctionError, did_you_mean

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


class Imports:
    """The imports of one listing.

    Args:
        listing: the listing.

    Attributes:
        neighbours: the modules beside its files.
    """

    def __init__(self, listing: Listing) -> None:
        self._scope, self._folders = listing.imports, listing.folders
        nodes = [node for source in listing.sources for node in ast.walk(source.tree)]
        self.neighbours = Neighbours(
            node.attr for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
        )
        # names may mean something else in code of another platform
        self._reads = listing.scope is None

    def of(self, node: ast.Import | ast.ImportFrom, path: Path) -> Iterator[Imported]:
        """Yield the names that a statement in a file imports."""
        if isinstance(node, ast.Import):
            for alias in node.names:
                found, wrong = self._module(alias.name, path)
                root = alias.name.partition(".")[0]
                if alias.asname is None and root != alias.name:
                    found = self._module(root, path)[0]
                yield Imported(alias.asname or root, found, wrong)
        elif node.level or not node.module:
            yield from (Imported(alias.asname or alias.name) for alias in node.names)
        else:
            yield from self._from(node.module, node.names, path)

    def _from(self, name: str, aliases: list[ast.alias], path: Path) -> Iterator[Imported]:
        module, wrong = self._module(name, path)
        names = self._names(name, module, path)
        for alias in aliases:
            if alias.name != "*":
                found = _member(module, alias.name)
                is_there = found != UNKNOWN or self._neighbour(f"{name}.{alias.name}", path) is not None
                reason = wrong or ("" if is_there else _lacking(name, alias.name, names))
                yield Imported(alias.asname or alias.name, found, reason)
                continue
            yield from (Imported(one, _member(module, one)) for one in names or () if not one.startswith("_"))
            if wrong:
                yield Imported("*", wrong=wrong)

    def _module(self, name: str, path: Path) -> tuple[Shape, str]:
        """Return a module and the error of its import."""
        root = name.partition(".")[0]
        if (ours := self._scope.substitute(name)) is not None:
            return Known(ours), ""
        if root in MODULES:
            return _imported(name)
        file = self._neighbour(name, path)
        if file is not None and self._reads and file.stem == name:
            return self.neighbours.names_of(file, self.of) or UNKNOWN, ""
        if file is not None or self._is_package(root, path):
            return UNKNOWN, ""
        return UNKNOWN, self._missing(name, path)

    def _missing(self, name: str, path: Path) -> str:
        """Return the message for a module that is not beside a file; empty if it may be elsewhere."""
        root, _, child = name.partition(".")
        if (parent := self._scope.substitute(root)) is not None:
            known = [one for one in dir(parent) if not one.startswith("_")]
            if _member(Known(parent), child.partition(".")[0]) != UNKNOWN:
                return ""
            if _exists(root):
                return _without_child(name)
            return f"there is no module '{name}'{did_you_mean(child, known) if known else ''}"
        if self._neighbour(root, path):
            return ""
        if root in sys.stdlib_module_names or _exists(root):
            return _without_child(name)
        known = [*(found.stem for found in path.parent.glob("*.py")), *message_packages(), *_COMMON]
        hint = did_you_mean(root, known)
        return f"there is no module '{name}'{hint if 'did you mean' in hint else ''}"

    def _neighbour(self, name: str, path: Path) -> Path | None:
        place = name.replace(".", "/")
        files = (
            folder / file
            for folder in (path.parent, *self._folders)
            for file in (f"{place}.py", f"{place}/__init__.py")
        )
        return next((file for file in files if file.is_file()), None)

    def _is_package(self, root: str, path: Path) -> bool:
        """Return whether modules of a package are beside a file."""
        return any(any((folder / root).glob("*.py")) for folder in (path.parent, *self._folders))

    def _names(self, name: str, module: Shape, path: Path) -> list[str] | None:
        """Return the names in a module; None if they are unknown."""
        if isinstance(module, Names):
            return list(module.names)
        if isinstance(module, Known) and isinstance(module.value, ModuleType):
            return [one for one in dir(module.value) if not one.startswith("__")]
        file = self._neighbour(name, path)
        return None if file is None else _defined(file)


_COMMON = ("numpy", "math", "hbp_nrp_client")


def _exists(root: str) -> bool:
    try:
        return find_spec(root) is not None
    except (ImportError, ValueError):
        return False


def _without_child(name: str) -> str:
    """Return the message for a module that an installed package does not have; empty if it may have it."""
    known, *children = name.split(".")
    spec = find_spec(known)
    for child in children:
        if spec is None or spec.submodule_search_locations is None or _may_make(known, child):
            return ""
        places = list(spec.submodule_search_locations)
        known = f"{known}.{child}"
        spec = PathFinder.find_spec(known, places)
        if spec is None:
            there = [one.name for one in iter_modules(places) if not one.name.startswith("_")]
            return f"there is no module '{name}'{did_you_mean(child, there)}"
    return ""


def _may_make(package: str, child: str) -> bool:
    """Return whether a package may have a module without a file: one that it makes when it is imported."""
    made = sys.modules.get(package)
    return f"{package}.{child}" in sys.modules or hasattr(made, "__getattr__")


def _imported(name: str) -> tuple[Shape, str]:
    """Return a module whose names are known, and the error of its import."""
    try:
        return Known(importlib.import_module(name)), ""
    except ImportError as error:
        return UNKNOWN, str(error)


def _lacking(module: str, name: str, names: Collection[str] | None) -> str:
    """Return the message for a name that a module does not have; empty if its names are unknown."""
    if names is None or name in names:
        return ""
    return f"'{module}' has no '{name}'{did_you_mean(name, names)}"


def _member(module: Shape, name: str) -> Shape:
    if isinstance(module, Known) and isinstance(module.value, ModuleType):
        try:
            return Known(getattr(module.value, name))
        except (AttributeError, ImportError):
            return UNKNOWN
    return attribute(module, name) or UNKNOWN if isinstance(module, Names) else UNKNOWN


def _defined(file: Path) -> list[str] | None:
    """Return the names that a file defines; None if they cannot be determined."""
    try:
        tree = ast.parse(file.read_bytes())
    except (SyntaxError, ValueError):
        return None
    names: list[str] = []
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                names.append(name)
            case ast.Name(id=name, ctx=ast.Store()):
                names.append(name)
            case ast.Import(aliases) | ast.ImportFrom(names=aliases):
                if any(alias.name == "*" for alias in aliases):
                    return None
                names += [alias.asname or alias.name.partition(".")[0] for alias in aliases]
    return names
