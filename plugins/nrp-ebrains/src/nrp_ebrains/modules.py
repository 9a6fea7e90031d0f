"""The modules ``nrp_core`` and ``nrp_protobuf`` that files of NRP-core 4 import, made for one experiment."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from nrp_core.errors import TransferFunctionError
from nrp_core.scripts import Scope
from nrp_ebrains.datapacks import JsonDataPack, JsonRawData, datapack_class, raw_data_class
from nrp_ebrains.messages import message_classes, message_modules

VERSION = "1.4.1"
"""The version that the program gives itself; 4 is that of the platform."""
_LATER = {
    "nrp_core.data.nrp_ros": "messages of ROS in functions",
}
"""Modules that are not here, with what they are for."""


def module(name: str, names: Mapping[str, Any]) -> ModuleType:
    """Return a module with these names, all of them public."""
    made = ModuleType(name)
    vars(made).update(names, __all__=list(names))
    return made


def data_modules() -> dict[str, ModuleType]:
    """Return the modules of datapacks and messages, by dotted name."""
    names: dict[str, Any] = {}
    for package, classes in message_classes().items():
        for name, message in classes.items():
            names[f"{package}{name}DataPack"] = datapack_class(message)
            names[f"{package}{name}RawData"] = raw_data_class(message)
    raw = message_modules()
    json = {"JsonDataPack": JsonDataPack, "JsonRawData": JsonRawData}
    return {
        "nrp_core.data": module("nrp_core.data", {}),
        "nrp_core.data.nrp_json": module("nrp_core.data.nrp_json", json),
        "nrp_core.data.nrp_protobuf": module("nrp_core.data.nrp_protobuf", {**names, **raw}),
        "nrp_protobuf": module("nrp_protobuf", raw),
        **{f"nrp_protobuf.{name}": one for name, one in raw.items()},
    }


def scope_with(
    names: Mapping[str, Any], modules: Mapping[str, ModuleType], folders: Iterable[Path] = ()
) -> Scope:
    """Return a scope whose files import these modules, and ``nrp_core`` with these names.

    Every name below ``nrp_core`` is that of NRP-core 4, or does not exist.
    """
    known = {**data_modules(), **modules, "nrp_core": module("nrp_core", {**names, "__version__": VERSION})}
    known.setdefault("nrp_core.engines", module("nrp_core.engines", {}))
    for name, one in known.items():
        parent, _, last = name.rpartition(".")
        if parent in known:
            setattr(known[parent], last, one)
    return Scope((), _substitute(known), folders)


T = TypeVar("T")


def registered_by(path: Path, scope: Scope, shared: ModuleType, registered: list[T]) -> list[T]:
    """Execute a file in the module that all of its kind share, and return what its decorators registered.

    Raises:
        TransferFunctionError: it raises.
    """
    before = len(registered)
    try:
        scope.run(path, module=shared)
    except (Exception, SystemExit) as error:
        raise scope.located(error, TransferFunctionError, path) from error
    return registered[before:]


def _substitute(known: Mapping[str, ModuleType]) -> Callable[[str], ModuleType | None]:
    def substitute(name: str) -> ModuleType | None:
        if name not in known and name.partition(".")[0] in ("nrp_core", "nrp_protobuf"):
            missing = _LATER.get(name)
            raise ModuleNotFoundError(
                f"{missing} are not supported here" if missing else f"NRP-core 4 has no module '{name}'",
                name=name,
            )
        return known.get(name)

    return substitute
