"""Load transfer functions from a Python file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import CodeType, MappingProxyType, ModuleType
from typing import Any

from nrp_core import dsl
from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.dsl import tf_lib
from nrp_core.dsl.functions.collector import collecting
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.loading.imports import file_scope
from nrp_core.dsl.parameters.messages import message_packages
from nrp_core.errors import TransferFunctionError, did_you_mean
from nrp_core.parameters import GivenParameters
from nrp_core.paths import path_of
from nrp_core.scripts import Scope

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
    with collecting() as functions:
        try:
            scope.run(path, target, code)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - users' files raise anything
            located = scope.located(error, TransferFunctionError, path)
            raise located from (error.__cause__ if located is error else error)
    if not functions and module is None:
        raise TransferFunctionError(DECLARES_NOTHING, path=path)
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
