"""Load transfer functions from a Python file."""

from __future__ import annotations

from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from nrp_core import dsl
from nrp_core._support.scoped_import import Scope
from nrp_core.dsl import tf_lib
from nrp_core.dsl.functions.collector import collecting
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.loading.imports import file_scope
from nrp_core.dsl.parameters.messages import message_packages
from nrp_core.errors import TransferFunctionError, did_you_mean


def load_transfer_functions(
    path: Path | str,
    *,
    module: ModuleType | None = None,
    code: CodeType | None = None,
    scope: Scope | None = None,
) -> list[TransferFunction]:
    """Execute a file and return the transfer functions that it declares, in their order.

    The file sees ``nrp``, ``Topic`` and the message packages without importing them.

    Args:
        path: the file.
        module: what the file's names go into; by default a fresh one for each file.
        code: what the file means, where it is not Python itself.
        scope: what the file can import, where several files share that; see :func:`file_scope`.

    Raises:
        TransferFunctionError: the file cannot be read or executed, or declares nothing.
        ExperimentError: something in it is wrong; it says where.
    """
    path = Path(path)
    if not path.is_file():
        siblings = [found.name for found in path.parent.glob(f"*{path.suffix}")]
        hint = did_you_mean(path.name, siblings) if siblings else ""
        raise TransferFunctionError(f"there is no such file{hint}", path=path)
    names = file_names()
    scope = scope or file_scope(names["nrp"])
    target = ModuleType(path.stem) if module is None else module
    vars(target).update({name: value for name, value in names.items() if name not in vars(target)})
    with collecting() as functions:
        try:
            scope.run(path, target, code)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - users' files raise anything
            located = scope.located(error, TransferFunctionError, path)
            raise located from (error.__cause__ if located is error else error)
    if not functions and module is None:
        raise TransferFunctionError(
            "declares no transfer function; decorate one with @nrp.Neuron2Robot or @nrp.Robot2Neuron",
            path=path,
        )
    return functions


def file_names() -> dict[str, Any]:
    """Return the names that a transfer function file begins with.

    What can be changed, such as ``nrp.tf_lib.cam``, is its own.
    """
    library = _copy(tf_lib, cam=tf_lib.PinholeCamera())
    return {**message_packages(), "nrp": _copy(dsl, tf_lib=library), "Topic": dsl.Topic}


def _copy(package: ModuleType, **changes: Any) -> ModuleType:
    """Return a module with the public names of another one, some of them changed."""
    copy = ModuleType(package.__name__, package.__doc__)
    vars(copy).update({name: getattr(package, name) for name in package.__all__} | changes)
    return copy
