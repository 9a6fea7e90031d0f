"""Make modules that exist for one experiment only: messages of ROS, and stand-ins for missing modules.

Messages accept numbers, tuples and bytes as in ROS 1. A stand-in can be imported, and fails only when it is
used.
"""

from __future__ import annotations

import numbers
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache, partial
from importlib import import_module
from math import isfinite
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, NoReturn

import numpy as np

from nrp_core.dsl import message_packages
from nrp_core.findings import Code
from nrp_core.messages import gazebo_srvs, std_srvs
from nrp_core.messages.cv_bridge import CvBridge as CvBridge
from nrp_core.messages.cv_bridge import CvBridgeError
from nrp_core.messages.gazebo_msgs import ModelState as KnownModelState
from nrp_core.messages.geometry_msgs import Pose, Vector3
from nrp_legacy.code import Notes

_FURTHER_PACKAGES = (
    "actionlib_msgs", "control_msgs", "diagnostic_msgs", "dynamic_reconfigure", "gazebo_ros_muscle_interface",
    "hbp_nrp_cle_msgs", "iba_manager", "rosgraph_msgs", "shape_msgs", "tf2_msgs", "trajectory_msgs",
)  # fmt: skip
_SERVICE_PACKAGES = (
    "cle_ros_msgs", "controller_manager_msgs", "dynamic_reconfigure", "gazebo_msgs", "iba_manager",
    "rosgraph_msgs", "std_srvs",
)  # fmt: skip
_FURTHER_SERVICES = (
    "SpawnEntity", "DeleteEntity", "GetLinkProperties",
    "SetLinkProperties", "SetJointProperties", "SetJointTrajectory", "GetVisualProperties", "ExportWorldSDF",
    "AdvanceSimulation",
)  # fmt: skip
"""Services of Gazebo that no world provides; calling one without a server raises an error that says so."""


def module(name: str, /, **content: Any) -> ModuleType:
    """Return a module with this content."""
    made = ModuleType(name)
    vars(made).update(content)
    return made


def bound(base: type, *first: Any) -> type:
    """Return a class with given first arguments, from which users can derive classes."""

    class Bound(base):  # type: ignore[misc]
        def __init__(self, *values: Any, **fields: Any) -> None:
            super().__init__(*first, *values, **fields)

    Bound.__name__ = Bound.__qualname__ = base.__name__
    return Bound


def open_module(
    name: str,
    make: Callable[[str], Any],
    content: dict[str, Any],
    names: Callable[[], list[str]] | None = None,
) -> ModuleType:
    """Return a module that creates missing names on demand.

    Args:
        name: the name of the module.
        make: returns the object for a name.
        content: the existing objects.
        names: returns the names for ``import *``, in addition to the existing ones.
    """
    made = module(name, **content)

    def attribute(missing: str) -> Any:
        if missing == "__all__" and names is not None:
            return names()
        if missing.startswith("_"):
            raise AttributeError(missing)
        setattr(made, missing, make(missing))
        return getattr(made, missing)

    vars(made)["__getattr__"] = attribute
    return made


@dataclass(frozen=True, slots=True)
class ServiceType:
    """The type of a service; calling it creates a request with the keyword arguments as fields."""

    name: str

    def __call__(self, *values: Any, **fields: Any) -> Request:
        return Request(values, fields)


class Request:
    """A request to a service with an unknown name; its fields are attributes.

    Args:
        values: by position.
        fields: by name.
    """

    def __init__(
        self, values: tuple[Any, ...] = (), fields: Mapping[str, Any] = MappingProxyType({})
    ) -> None:
        vars(self).update(fields, _values=values)

    @property
    def values(self) -> tuple[Any, ...]:
        """The positional values."""
        given: tuple[Any, ...] = vars(self)["_values"]
        return given

    @property
    def fields(self) -> dict[str, Any]:
        """The named values."""
        return {name: value for name, value in vars(self).items() if name != "_values"}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return vars(self).setdefault(name, Pose() if name == "initial_pose" else OpenMessage())


class OpenMessage:
    """A message of an unknown type: it accepts any fields."""

    def __init__(self, *values: Any, **fields: Any) -> None:
        data = {"data": values[0]} if len(values) == 1 else {}
        self.__dict__.update(data, **fields)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self.__dict__.setdefault(name, OpenMessage())

    def append(self, item: Any) -> None:
        """Append an item, because a field without a value may be a list."""
        self._items.append(item)

    def extend(self, items: Any) -> None:
        """Append items."""
        self._items.extend(items)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __getitem__(self, place: Any) -> Any:
        return self._items[place]

    def __bool__(self) -> bool:
        return True

    @property
    def _items(self) -> list[Any]:
        items: list[Any] = self.__dict__.setdefault("_kept", [])
        return items


@dataclass(slots=True)
class ModelState(KnownModelState):
    """Pose and velocity of a model, and the size that the platform's Gazebo took; it has no effect."""

    scale: Vector3 = field(default_factory=lambda: Vector3(1.0, 1.0, 1.0))


def message_modules() -> dict[str, ModuleType]:
    """Return ``<package>.msg`` of every package of messages; unknown types accept any fields."""
    known = {name: package.msg for name, package in message_packages().items()}
    known["gazebo_msgs"] = module(
        "gazebo_msgs.msg", **{**_written(known["gazebo_msgs"]), "ModelState": ModelState}
    )
    return {
        f"{package}.msg": open_module(
            f"{package}.msg",
            partial(_open_message, types),
            _written(types) if types else {},
            partial(_public, types) if types else None,
        )
        for package, types in {**dict.fromkeys(_FURTHER_PACKAGES), **known}.items()
    }


def _written(types: ModuleType) -> dict[str, Any]:
    """Return the types of a module that are not created on demand."""
    names = getattr(types, "__all__", vars(types))
    return {name: getattr(types, name) for name in names if not name.startswith("_")}


def _public(known: ModuleType) -> list[str]:
    """Return the types that a module has or creates on demand."""
    return [name for name in dir(known) if not name.startswith("_")]


def service_modules() -> dict[str, ModuleType]:
    """Return ``<package>.srv`` of the packages whose services experiments call."""
    known = {"gazebo_msgs": gazebo_srvs, "std_srvs": std_srvs}
    return {
        f"{package}.srv": open_module(f"{package}.srv", ServiceType, _requests(known.get(package)))
        for package in _SERVICE_PACKAGES
    }


def _requests(known: ModuleType | None) -> dict[str, Any]:
    """Return the requests and answers that a module has."""
    ends = ("Request", "Response")
    found = {name: value for name, value in vars(known).items() if name.endswith(ends)} if known else {}
    services = {name.removesuffix(end) for name in found for end in ends if name.endswith(end)}
    further = {f"{service}{end}" for service in _FURTHER_SERVICES for end in ("", *ends)}
    return {**found, "__all__": sorted({*found, *services, *further})} if found else {}


def _open_message(known: ModuleType | None, name: str) -> type:
    found = getattr(known, name, None)
    return found if isinstance(found, type) else type(name, (OpenMessage,), {})


def overlay(
    name: str,
    own: Mapping[str, Any] | None = None,
    old: Callable[[ModuleType, str], Any] | None = None,
    *,
    real: str | None = None,
) -> ModuleType:
    """Return a module with the names of a real one, which is imported when one of them is used.

    Args:
        name: its name.
        own: names that replace those of the real one.
        old: returns the object for a removed name; raises ``AttributeError`` or ``KeyError`` if there is
            none.
        real: the name of the real one, if it differs.
    """
    made = module(name, **(own or {}))

    def attribute(child: str) -> Any:
        here = import_module(real or name)
        try:
            return getattr(here, child)
        except AttributeError:
            if old is None:
                raise
        try:
            return old(here, child)
        except KeyError:
            raise AttributeError(f"module '{name}' has no attribute '{child}'") from None

    vars(made)["__getattr__"] = attribute
    vars(made)["__dir__"] = lambda: sorted({*vars(made), *dir(import_module(real or name))})
    return made


def renamed(**names: str) -> Callable[[ModuleType, str], Any]:
    """Return a function that finds objects by old names."""
    return lambda here, name: getattr(here, names[name])


def nothing(*_values: Any, **_fields: Any) -> None:
    """Do nothing, because it is not needed here."""


_NUMBERS = ("float", "int", float, int)


def with_numbers(message: Any, tell: Callable[[str], None] | None = None) -> Any:
    """Return a message, or its only field, with plain numbers for arrays of one number and for decimals.

    Args:
        message: the message or number.
        tell: called with each number that is not finite, for which 0 is returned; None: it stays.
    """
    if isinstance(message, (np.generic, np.ndarray)) and message.size == 1:
        message = message.item()
    if isinstance(message, numbers.Number) and not isinstance(message, (int, float, complex)):
        message = float(message)  # type: ignore[arg-type] # Decimal, Fraction
    if isinstance(message, float) and not isfinite(message) and tell is not None:
        tell(str(message))
        return 0.0
    if not is_dataclass(message) or isinstance(message, type):
        return message
    changes: dict[str, Any] = {}
    for one in fields(message):
        value = getattr(message, one.name)
        if is_dataclass(value) or one.type in _NUMBERS:
            number = with_numbers(value, tell)
            changes |= {} if number is value else {one.name: number}
    return replace(message, **changes) if changes else message


def as_in_ros1(message: Any) -> Any:
    """Return a message whose arrays are tuples of numbers, or the bytes that they hold."""
    if not is_dataclass(message) or isinstance(message, type):
        return message
    values = {field.name: getattr(message, field.name) for field in fields(message)}
    changes = {name: _plain(value) for name, value in values.items() if isinstance(value, np.ndarray)}
    return replace(message, **changes) if changes else message


def _plain(array: np.ndarray[Any, Any]) -> Any:
    if array.dtype == np.uint8:
        return array.tobytes()
    return tuple(array.tolist()) if array.ndim == 1 else array


def cv_bridge_module() -> ModuleType:
    """Return the module."""
    return module("cv_bridge", CvBridge=CvBridge, CvBridgeError=CvBridgeError)


_MESSAGES = ("msg", "action")
_SERVICES = "srv"


class Missing:
    """An object of a module that is not installed.

    Args:
        name: its dotted name.
        why: the reason why it is missing.
    """

    def __init__(self, name: str, why: str) -> None:
        self._name, self._why = name, why

    def __getattr__(self, name: str) -> Missing:
        if name.startswith("_"):
            raise AttributeError(name)
        return Missing(f"{self._name}.{name}", self._why)

    def __repr__(self) -> str:
        return f"<{self._name}, which is not here>"

    def _fail(self, *_values: object, **_fields: object) -> NoReturn:
        raise ImportError(f"{self._why}: {self._name} is needed")

    __call__ = __iter__ = __getitem__ = __len__ = __enter__ = __mro_entries__ = __contains__ = _fail
    __add__ = __radd__ = __sub__ = __mul__ = __rmul__ = __truediv__ = __lt__ = __gt__ = _fail


def with_missing_parts(known: ModuleType) -> None:
    """Make all names of a module importable: missing ones fail when they are used."""
    name = known.__name__

    def attribute(child: str) -> Missing:
        if child.startswith("_"):
            raise AttributeError(child)
        return Missing(f"{name}.{child}", f"'{name}' does not have '{child}'")

    vars(known)["__getattr__"] = attribute


class StandIns:
    """The substitutes for missing modules.

    Args:
        notes: receives a note about each, once.
    """

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._told: set[str] = set()
        self._module = cache(self._made)

    def __call__(self, name: str, importer: Mapping[str, Any]) -> ModuleType | None:
        """Return a module, None if the import may fail because the importing file handles this."""
        if _may_fail(name.partition(".")[0], importer.get("__file__")):
            return None
        return self._module(name)

    def _made(self, name: str) -> ModuleType:
        root, _, rest = name.partition(".")
        if rest in _MESSAGES:
            message = f"the message package '{root}' is not known: its messages accept any field"
            self._notes(Code.NRP204, message, subject=root)
            return open_module(name, lambda child: type(child, (OpenMessage,), {}), {})
        if rest == _SERVICES:
            return open_module(name, ServiceType, {})
        if not rest:
            return open_module(name, lambda child: self._part(name, child), {})
        why = self._tell(root)
        return open_module(name, lambda child: Missing(f"{name}.{child}", why), {})

    def _part(self, package: str, child: str) -> Any:
        if child in (*_MESSAGES, _SERVICES):
            return self._module(f"{package}.{child}")
        return Missing(f"{package}.{child}", self._tell(package))

    def _tell(self, root: str) -> str:
        if root not in self._told:
            self._told.add(root)
            message = f"module '{root}' is not installed: code that uses it fails"
            self._notes(Code.NRP204, message, subject=root)
        return f"the module '{root}' is not installed"


def _may_fail(root: str, file: object) -> bool:
    """Whether a file imports a module within ``try``."""
    path = Path(str(file))
    if not path.is_file():
        return False
    guarded = rf"\btry\s*:[^\n]*\n(?:\s*(?:import|from)\s[^\n]*\n)*\s*(?:import|from)\s+{re.escape(root)}\b"
    return re.search(guarded, path.read_text("utf-8", errors="replace")) is not None
