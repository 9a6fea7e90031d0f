"""Run a user's file as a separate module, with imports that we control; the command line of such programs.

Such a file sees substitutes for some modules and may import its neighbours. Nothing of it stays in
``sys.modules``, so two runs never share modules, and the rest of the program sees the real ones.
"""

from __future__ import annotations

import argparse
import ast
import builtins
import importlib
import os
import sys
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from functools import lru_cache
from importlib.util import find_spec, resolve_name
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, NoReturn, TypeAlias

from nrp_core._support.audit_events import LOADS
from nrp_core._support.text import Misfit, decoded_python
from nrp_core.errors import ExperimentError, NrpError


class BuildingEnds(BaseException):
    """Ends a script whose network is complete, as ``run`` does where only the network is read."""


@contextmanager
def intercept_os_exit() -> Iterator[None]:
    """Let ``os._exit`` raise SystemExit within the block, in this thread and this process.

    A process that the block forks, as ``multiprocessing`` does, still ends by it.
    """
    leave, own = os._exit, (os.getpid(), threading.get_ident())

    def refuse(status: int) -> NoReturn:
        if (os.getpid(), threading.get_ident()) != own:
            leave(status)
        raise SystemExit(f"os._exit({status}) would end the whole program")

    os._exit = refuse
    try:
        yield
    finally:
        os._exit = leave


_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
Missing: TypeAlias = Callable[[str, Mapping[str, Any]], ModuleType | None]


class Scope:
    """A file and its neighbours, under one set of substitutes.

    Args:
        roots: top-level packages that contain substitutes.
        substitute: returns the module for a dotted name, or None for the real one; the substitute for
            ``builtins`` is used without an import.
        folders: folders whose files also count as neighbours; iterated at each import, as it may grow.
        missing: returns a substitute for a module that does not exist, given its name and the names in the
            importing module; None for none.
        compiled: compiles a file; by default as Python.
    """

    def __init__(
        self,
        roots: Iterable[str],
        substitute: Callable[[str], ModuleType | None],
        folders: Iterable[Path] = (),
        missing: Missing | None = None,
        compiled: Callable[[Path], CodeType] | None = None,
    ) -> None:
        self._missing, self._compiled = missing, compiled or compile_file
        self._homes: dict[Path, None] = {}
        self._roots = frozenset(roots)
        self._packages: dict[str, ModuleType] = {}
        self._stands_for = substitute
        self._folders = folders
        self._importlib = ModuleType("importlib", importlib.__doc__)
        self._importlib.__dict__.update(vars(importlib), import_module=self._import_module)
        lent = vars(substitute("builtins") or ModuleType("builtins"))
        lent = {name: value for name, value in lent.items() if name[:2] != "__"}
        self._builtins = {**vars(builtins), **lent, "__import__": self._import}
        self._files: set[str] = set()
        self._neighbours: dict[Path, ModuleType] = {}
        self._places: dict[str, ModuleType] = {}

    def run(
        self,
        path: Path,
        module: ModuleType | None = None,
        code: CodeType | None = None,
        name: str | None = None,
    ) -> ModuleType:
        """Execute a file and return its module; exceptions of the file propagate, ``os._exit`` as SystemExit.

        Args:
            path: the file.
            module: the module to execute it in; by default a new one.
            code: the compiled file, if it is not plain Python.
            name: the module's ``__name__``, by default one that no other module has.
        """
        module = ModuleType(path.stem, None) if module is None else module
        module.__dict__.update(__file__=str(path), __builtins__=self._builtins)
        self._files.add(str(path))
        self._homes[path.parent] = None
        # Dataclasses look up their module by name while the file is executed.
        module.__name__ = name or f"{path.stem}@{id(module):x}"
        before = sys.modules.get(module.__name__)
        sys.modules[module.__name__] = module
        try:
            with intercept_os_exit():
                exec(code or self._compiled(path), module.__dict__)
        finally:
            del sys.modules[module.__name__]
            if before is not None:
                sys.modules[module.__name__] = before
        return module

    def place_of(self, error: BaseException) -> tuple[Path, int | None] | None:
        """Return the file and line in this scope that an error came from; None if from elsewhere."""
        if isinstance(error, SyntaxError) and error.filename in self._files:
            return Path(error.filename), error.lineno
        for frame in reversed(traceback.extract_tb(error.__traceback__)):
            if frame.filename in self._files:
                return Path(frame.filename), frame.lineno
        return None

    def located(self, error: BaseException, kind: type[ExperimentError], file: Path) -> NrpError:
        """Convert an error that a file of this scope raised to one of ours, with file and line.

        Args:
            error: the exception; one of ours keeps its class.
            kind: the class for all others.
            file: the file that was run, for an error that has no line in it.
        """
        path, line = self.place_of(error) or (file, None)
        if isinstance(error, ExperimentError):
            placed = copy(error)
            if error.path is None:
                placed.path, placed.line = path, line
            return placed
        if isinstance(error, NrpError):
            return type(error)(f"{ExperimentError('', path=path, line=line).location}: {error}")
        if isinstance(error, SyntaxError):
            return kind(f"this is not Python: {error.msg}", path=path, line=line, column=error.offset)
        text = str(error)
        return kind(f"{type(error).__name__}{': ' if text else ''}{text}", path=path, line=line)

    def substitute(self, name: str) -> ModuleType | None:
        """Return the module that a dotted name imports in this scope, None for the real module."""
        return self._ours(name)

    # -- `__import__` and `importlib.import_module` as files of this scope see them

    def _import(
        self,
        name: str,
        globals: Mapping[str, Any] | None = None,  # noqa: A002
        locals: Mapping[str, Any] | None = None,  # noqa: A002
        fromlist: Sequence[str] = (),
        level: int = 0,
    ) -> ModuleType:
        if level:
            package = (globals or {}).get("__package__")
            if not package or (globals or {}).get("__file__") not in self._files:
                return builtins.__import__(name, globals, locals, fromlist, level)
            name, level = resolve_name("." * level + name, package), 0
        root = name.partition(".")[0]
        module = self._ours(name) or self._neighbour_with(fromlist or (), name, globals)
        if module is not None:
            if fromlist:
                return self._with_submodules(module, name, fromlist, globals or {})
            return self._ours(root) or self._places.get(root, module)
        try:
            real = builtins.__import__(name, globals, locals, fromlist, level)
        except ModuleNotFoundError as error:
            stand_in = self._stand_in(name, globals or {}, error)
            if stand_in is None:
                raise
            if fromlist:
                return self._with_submodules(stand_in, name, fromlist, globals or {})
            self._places[name] = stand_in
            return self._ours(root) or self._stand_in(root, globals or {}, error) or stand_in
        sys.audit(LOADS, root)
        return real if fromlist else self._stands_for(root) or real

    def _with_submodules(
        self, module: ModuleType, name: str, children: Iterable[str], importer: Mapping[str, Any]
    ) -> ModuleType:
        """Return a substitute, with those of the names to import from it that are its submodules."""
        found: dict[str, ModuleType] = {}
        if "*" in children:  # a package answers for each name, and lists none
            module = self._stands_for(name) or module
        for child in children:
            if child != "*" and not hasattr(module, child):
                submodule = self._submodule(f"{name}.{child}", importer)
                if submodule is not None and submodule is not module:  # a simulator answers for all below it
                    found[child] = submodule
        if not found:
            return module
        whole = ModuleType(name, module.__doc__)
        vars(whole).update(vars(module), **found)
        return whole

    def _submodule(self, name: str, importer: Mapping[str, Any]) -> ModuleType | None:
        try:
            return self._import_module(name)
        except NrpError:  # no equivalent exists
            raise
        except ModuleNotFoundError as error:
            return self._stand_in(name, importer, error)

    def _stand_in(
        self, name: str, importer: Mapping[str, Any], error: ModuleNotFoundError
    ) -> ModuleType | None:
        """Return the substitute for a missing module; None if a module that it imports is missing instead."""
        if self._missing is None or error.name is None or not f"{name}.".startswith(f"{error.name}."):
            return None
        return self._missing(name, importer)

    def _import_module(self, name: str, package: str | None = None) -> ModuleType:
        ours = self._ours(name)
        if ours is None and not package:
            sys.audit(LOADS, name.partition(".")[0])
        return ours or importlib.import_module(name, package)

    def _ours(self, name: str) -> ModuleType | None:
        """Return the substitute for a name, or the package through which substitutes are reached."""
        if name == "importlib":
            return self._importlib
        own = self._stands_for(name)
        is_package = own is not None and "__path__" in vars(own)
        return self._package(name) if name in self._roots and not is_package else own

    def _package(self, name: str) -> ModuleType:
        if name in self._packages:
            return self._packages[name]
        package = self._packages[name] = ModuleType(name)

        def attribute(child: str) -> object:
            substitute = self._stands_for(f"{name}.{child}") or self._places.get(f"{name}.{child}")
            if substitute is not None:
                return substitute
            own = self._stands_for(name)
            if own is not None:
                return getattr(own, child)
            try:
                real = importlib.import_module(name)
            except ModuleNotFoundError as error:
                stand_in = self._stand_in(f"{name}.{child}", {}, error)
                if stand_in is None:
                    raise
                return stand_in
            if not hasattr(real, child) and find_spec(f"{name}.{child}"):
                return importlib.import_module(f"{name}.{child}")
            return getattr(real, child)

        package.__dict__["__getattr__"] = attribute
        return package

    def _neighbour(self, name: str, importer: Mapping[str, Any] | None) -> ModuleType | None:
        """Return the module in a file beside the importing one, or in a folder; it is executed once."""
        root, *rest = name.split(".")
        if root in sys.stdlib_module_names or not (importer or {}).get("__file__"):
            return None
        folders = (Path(importer["__file__"]).parent, *self._folders, *self._homes)  # type: ignore[index]
        files = (f"{'/'.join([root, *rest])}.py", "/".join([root, *rest, "__init__.py"]))
        paths = [folder / file for folder in folders for file in files]
        path = next((path for path in paths if path in self._neighbours or path.is_file()), None)
        if path is None:
            return None
        module = self._execute(path, name)
        parent, _, child = name.rpartition(".")
        if parent:
            package = self._neighbour(parent, importer) or self._places.setdefault(parent, ModuleType(parent))
            setattr(package, child, module)
        return self._places.setdefault(name, module)

    def _neighbour_with(
        self, children: Iterable[str], name: str, importer: Mapping[str, Any] | None
    ) -> ModuleType | None:
        """Return the module in a file after executing those of its children that are files."""
        module = self._neighbour(name, importer)
        for child in children if module is not None else ():
            if child not in vars(module):
                self._neighbour(f"{name}.{child}", importer)
        return module

    def _execute(self, path: Path, name: str) -> ModuleType:
        if path not in self._neighbours:
            self._neighbours[path] = ModuleType(name)  # registered first, for modules that import each other
            self._neighbours[path].__package__ = name if path.stem == "__init__" else name.rpartition(".")[0]
            try:
                self.run(path, self._neighbours[path])
            except BaseException:
                del self._neighbours[path]
                raise
        return self._neighbours[path]


@lru_cache(maxsize=64)
def _compile(data: bytes, path: str) -> CodeType:
    """Compile a file once, because the copies of an experiment execute the same files."""
    return compile(data, path, "exec", dont_inherit=True)


def compile_file(path: Path) -> CodeType:
    """Return the code of a file in Python.

    Raises:
        SyntaxError: it is not Python.
    """
    data = path.read_bytes()
    try:
        return _compile(data, str(path))
    except (SyntaxError, ValueError) as error:
        text = decoded_python(data)
        if isinstance(text, Misfit):
            raise SyntaxError(text.message, (str(path), text.line, text.column, None)) from error
        if isinstance(error, ValueError):  # null characters, before Python 3.11.4
            raise SyntaxError(str(error)) from error
        raise


def script_arguments(
    parser: argparse.ArgumentParser, arguments: Sequence[str]
) -> tuple[argparse.Namespace, Path]:
    """Return the options and the absolute path of the script, which finds its own arguments in ``sys.argv``.

    A script that does not exist ends the program, with the usage.

    Args:
        parser: knows the options.
        arguments: those of the command line.
    """
    parser.add_argument("script", metavar="SCRIPT")
    parser.add_argument("arguments", metavar="ARGUMENTS", nargs=argparse.REMAINDER)
    given = parser.parse_args(arguments)
    script = Path(given.script)
    if not script.is_file():
        parser.error(f"there is no file {given.script}")
    sys.argv = [given.script, *given.arguments]
    return given, script.resolve()


def unbound_names(tree: ast.Module) -> set[str]:
    """Return the names that code loads and binds nowhere, in any scope; those of built-in functions too."""
    used: set[str] = set()
    bound: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            (used if isinstance(node.ctx, ast.Load) else bound).add(node.id)
        elif isinstance(node, _DEFINITIONS):
            bound.add(node.name)
        elif isinstance(node, ast.arg):
            bound.add(node.arg)
        elif isinstance(node, ast.alias):
            bound.add(node.asname or node.name.partition(".")[0])
        elif isinstance(node, ast.ExceptHandler) and node.name:
            bound.add(node.name)
    return used - bound


def last_name(node: ast.expr) -> str:
    """Return ``c`` for the expression ``a.b.c``, and for ``c`` alone."""
    return ast.unparse(node).rpartition(".")[2]
