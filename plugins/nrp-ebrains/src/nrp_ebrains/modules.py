"""The modules ``nrp_core`` and ``nrp_protobuf`` that files of NRP-core 4 import, made for one experiment."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from google.protobuf.message import Message

from nrp_core.errors import TransferFunctionError
from nrp_core.scripts import Scope
from nrp_ebrains.datapacks import JsonData, JsonDataPack, JsonRawData, datapack_class, raw_data_class
from nrp_ebrains.messages import message_classes, message_modules
from nrp_ebrains.protos import own_messages

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


def data_modules(folder: Path | None = None) -> dict[str, ModuleType]:
    """Return the modules of datapacks and messages, by dotted name.

    Args:
        folder: a folder whose ``.proto`` files add messages.

    Raises:
        ExperimentError: such a file cannot be read.
    """
    names: dict[str, Any] = {}
    for package, classes in message_classes().items():
        names |= _datapacks(package, classes)
    raw = dict(message_modules())
    own: dict[str, ModuleType] = {}
    for package, classes in own_messages(folder).items() if folder else ():
        packs, python = _datapacks(package, classes), f"{package.lower()}_pb2"
        names |= packs
        raw[python] = own[python] = module(python, classes)
        own[package.lower()] = module(package.lower(), packs)
    json = {"JsonDataPack": JsonDataPack, "JsonRawData": JsonRawData, "NlohmannJson": JsonData}
    return {
        **own,
        "nrp_core.data": module("nrp_core.data", {}),
        "nrp_core.data.nrp_json": module("nrp_core.data.nrp_json", json),
        "nrp_core.data.nrp_protobuf": module("nrp_core.data.nrp_protobuf", {**names, **raw}),
        "nrp_protobuf": module("nrp_protobuf", raw),
        **{f"nrp_protobuf.{name}": one for name, one in raw.items()},
    }


def _datapacks(package: str, classes: Mapping[str, type[Message]]) -> dict[str, Any]:
    """Return the messages of a package and their classes of datapacks and of raw data, by name."""
    kinds: dict[str, Callable[[type[Message]], type]] = {
        "DataPack": datapack_class,
        "RawData": raw_data_class,
    }
    made: dict[str, Any] = {
        f"{package}{name}{kind}": make(message)
        for name, message in classes.items()
        for kind, make in kinds.items()
    }
    return made | {f"{package}{name}": message for name, message in classes.items()}


def scope_with(
    names: Mapping[str, Any], modules: Mapping[str, ModuleType], folder: Path | None = None
) -> Scope:
    """Return a scope whose files import these modules, and ``nrp_core`` with these names.

    Every name below ``nrp_core`` is that of NRP-core 4, or does not exist. The ``.proto`` files of a folder
    add messages. ``gym`` is Gymnasium if it is not installed itself.
    """
    known = {
        **data_modules(folder),
        **modules,
        "nrp_core": module("nrp_core", {**names, "__version__": VERSION}),
    }
    known.setdefault("nrp_core.engines", module("nrp_core.engines", {}))
    for name, one in known.items():
        parent, _, last = name.rpartition(".")
        if parent in known:
            setattr(known[parent], last, one)
    return Scope((), _substitute(known))


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
        if name.partition(".")[0] == "gym" and find_spec("gym") is None and find_spec("gymnasium"):
            return import_module(name.replace("gym", "gymnasium", 1))  # the package that continues it
        return known.get(name)

    return substitute
