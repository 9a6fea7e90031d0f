"""Files of transfer functions: imports, listing, execution."""

from __future__ import annotations

import ast
import importlib.abc
import importlib.machinery
import importlib.util
import operator
import sys
import warnings
from collections import ChainMap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from types import CodeType, MappingProxyType, ModuleType
from typing import Any

from nrp_core import dsl
from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.text import Misfit, decoded_python
from nrp_core.dsl import tf_lib
from nrp_core.dsl.functions import TransferFunction, collecting
from nrp_core.dsl.messages import message_packages, service_packages
from nrp_core.errors import TransferFunctionError, did_you_mean
from nrp_core.messages import cv_bridge, point_cloud2
from nrp_core.parameters import GivenParameters
from nrp_core.paths import path_of
from nrp_core.scripts import Missing, Scope


def file_scope(
    framework: ModuleType,
    substitutes: Mapping[str, ModuleType] | None = None,
    folders: Iterable[Path] = (),
    missing: Missing | None = None,
    compiled: Callable[[Path], CodeType] | None = None,
) -> Scope:
    """Return the scope of a transfer function file.

    Args:
        framework: the module that ``import hbp_nrp_client.tf_framework`` returns.
        substitutes: further modules by their dotted names.
        folders: where modules are searched for that are not beside the file.
        missing: returns a substitute for a module that is not found.
        compiled: compiles an imported file; by default as Python.
    """
    own = {"hbp_nrp_client.tf_framework": framework, **(substitutes or {})}
    known = ChainMap(own, _messages())
    return Scope(_packages(frozenset(known)), known.get, folders, missing, compiled)


@cache
def _messages() -> dict[str, ModuleType]:
    """Return the modules of messages by their dotted names; all files have the same."""
    known = {f"{name}.msg": package.msg for name, package in message_packages().items()}
    known |= {f"{name}.srv": services for name, services in service_packages().items()}
    known |= {"cv_bridge": cv_bridge}
    return known | dict.fromkeys(("sensor_msgs.point_cloud2", "sensor_msgs_py.point_cloud2"), point_cloud2)


@cache
def _packages(names: frozenset[str]) -> frozenset[str]:
    """Return the top-level packages that exist only as parents of modules with these names."""
    return frozenset(name.partition(".")[0] for name in names if "." in name) - names


class _MessageFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds the message packages if they are not installed."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        package, _, rest = fullname.partition(".")
        if rest not in _parts_of(package):
            return None
        return importlib.util.spec_from_loader(fullname, self, is_package=not rest)

    def exec_module(self, module: ModuleType) -> None:
        package, _, rest = module.__name__.partition(".")
        if rest:
            types = _parts_of(package)[rest]
            vars(module).update({"__getattr__": partial(getattr, types), "__dir__": types.__dir__})


def _parts_of(package: str) -> dict[str, ModuleType]:
    """Return a package under the empty name and its modules under theirs; nothing for another name."""
    parts = {}
    if package in message_packages():
        parts["msg"] = message_packages()[package].msg
    if package in service_packages():
        parts["srv"] = service_packages()[package]
    return {"": ModuleType(package), **parts} if parts else {}


def provide_messages() -> None:
    """Make ``import geometry_msgs.msg`` work in plain scripts and notebooks without ROS."""
    if not any(isinstance(finder, _MessageFinder) for finder in sys.meta_path):
        sys.meta_path.append(_MessageFinder())


DECLARES_NOTHING = "declares no transfer function; decorate one with @nrp.Neuron2Robot or @nrp.Robot2Neuron"


@checks_arguments()
def load_transfer_functions(
    path: Path | str,
    *,
    module: ModuleType | None = None,
    code: CodeType | None = None,
    scope: Scope | None = None,
    parameters: Mapping[str, object] = MappingProxyType({}),
) -> list[TransferFunction]:
    """Execute a file and return the transfer functions that it declares, in their order.

    The file sees ``nrp``, ``Topic`` and the message packages without importing them.

    Args:
        path: the file.
        module: the module that holds the file's names; by default a new one for each file.
        code: the compiled file, if it is not plain Python.
        scope: the modules that the file can import, if several files share them; see :func:`file_scope`.
        parameters: values of the parameters that the file declares; others have their defaults.

    Raises:
        TransferFunctionError: the file cannot be read or executed, or declares no transfer function.
        ExperimentError: the file is invalid; the message names the place.
    """
    path = path_of(path, TransferFunctionError)
    if not path.is_file():
        siblings = [found.name for found in path.parent.glob(f"*{path.suffix}")]
        hint = did_you_mean(path.name, siblings) if siblings else ""
        raise TransferFunctionError(f"there is no such file{hint}", path=path)
    names = file_names(parameters)
    scope = scope or file_scope(names["nrp"])
    target = ModuleType(path.stem) if module is None else module
    vars(target).update({name: value for name, value in names.items() if name not in vars(target)})
    with collecting() as functions, GivenParameters(parameters).answering():
        try:
            scope.run(path, target, code)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - users' files raise anything
            located = scope.located(error, TransferFunctionError, path)
            raise located from (error.__cause__ if located is error else error)
    if not functions and module is None:
        raise TransferFunctionError(DECLARES_NOTHING, path=path, line=1)
    return functions


def file_names(parameters: Mapping[str, object] = MappingProxyType({})) -> dict[str, Any]:
    """Return the initial names of a transfer function file.

    Each file gets its own copy of mutable objects such as ``nrp.tf_lib.cam``.

    Args:
        parameters: the values that ``nrp.parameter`` returns; others have their defaults.
    """
    library = _copy(tf_lib, cam=tf_lib.PinholeCamera())
    framework = _copy(dsl, tf_lib=library, parameter=GivenParameters(parameters).parameter)
    return {**message_packages(), "nrp": framework, "Topic": dsl.Topic}


def _copy(package: ModuleType, **changes: Any) -> ModuleType:
    """Return a module with the public names of another one, some of them changed."""
    copy = ModuleType(package.__name__, package.__doc__)
    vars(copy).update({name: getattr(package, name) for name in package.__all__} | changes)
    return copy


_PLACED = (ast.stmt, ast.expr, ast.arg, ast.keyword, ast.alias, ast.excepthandler, ast.pattern)


@dataclass(frozen=True, slots=True)
class PythonSource:
    """A piece of Python.

    Args:
        path: its file.
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
            path: its file.
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
        sources: the pieces, in their order of execution.
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
