"""Make modules that exist for one experiment only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from types import ModuleType
from typing import Any

from nrp_core.dsl.messages import message_packages

_FURTHER_PACKAGES = (
    "actionlib_msgs", "control_msgs", "diagnostic_msgs", "dynamic_reconfigure", "gazebo_ros_muscle_interface",
    "hbp_nrp_cle_msgs", "iba_manager", "rosgraph_msgs", "shape_msgs", "tf2_msgs", "trajectory_msgs",
)  # fmt: skip
_SERVICE_PACKAGES = ("cle_ros_msgs", "dynamic_reconfigure", "gazebo_msgs", "std_srvs")


def module(name: str, /, **content: Any) -> ModuleType:
    """Return a module with this content."""
    made = ModuleType(name)
    vars(made).update(content)
    return made


def open_module(name: str, make: Callable[[str], Any], content: dict[str, Any]) -> ModuleType:
    """Return a module that makes what it lacks when it is asked for."""
    made = module(name, **content)

    def attribute(missing: str) -> Any:
        if missing.startswith("_"):
            raise AttributeError(missing)
        setattr(made, missing, make(missing))
        return getattr(made, missing)

    vars(made)["__getattr__"] = attribute
    return made


@dataclass(frozen=True, slots=True)
class ServiceType:
    """The type of a service; called, it makes a request, whose fields are the keyword arguments."""

    name: str

    def __call__(self, *values: Any, **fields: Any) -> Request:
        return Request(values, fields)


@dataclass(slots=True)
class Request:
    """What is asked of a service.

    Args:
        values: by position.
        fields: by name; attributes of the request.
    """

    values: tuple[Any, ...] = ()
    fields: dict[str, Any] = field(default_factory=dict)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self.fields:
            raise AttributeError(name)
        return self.fields[name]


class OpenMessage:
    """A message of a type that nobody here reads or writes: it carries whatever it is given."""

    def __init__(self, *values: Any, **fields: Any) -> None:
        data = {"data": values[0]} if len(values) == 1 else {}
        self.__dict__.update(data, **fields)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self.__dict__.setdefault(name, OpenMessage())


def message_modules() -> dict[str, ModuleType]:
    """Return ``<package>.msg`` of every package of messages; types that are not known carry anything."""
    known = {name: package.msg for name, package in message_packages().items()}
    return {
        f"{package}.msg": open_module(
            f"{package}.msg", partial(_open_message, types), dict(vars(types)) if types else {}
        )
        for package, types in {**dict.fromkeys(_FURTHER_PACKAGES), **known}.items()
    }


def service_modules() -> dict[str, ModuleType]:
    """Return ``<package>.srv`` of the packages whose services experiments call."""
    return {f"{package}.srv": open_module(f"{package}.srv", ServiceType, {}) for package in _SERVICE_PACKAGES}


def _open_message(known: ModuleType | None, name: str) -> type:
    found = getattr(known, name, None)
    return found if isinstance(found, type) else type(name, (OpenMessage,), {})
