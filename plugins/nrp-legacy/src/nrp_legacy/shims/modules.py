"""Make modules that exist for one experiment only."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType, ModuleType
from typing import Any

from nrp_core.dsl.parameters.messages import message_packages
from nrp_core.world.messages import gazebo_srvs, std_srvs
from nrp_core.world.messages.gazebo_msgs import ModelState as KnownModelState
from nrp_core.world.messages.geometry_msgs import Pose, Vector3

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
        names: returns the names for ``import *``, besides the existing ones.
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
        "gazebo_msgs.msg", **{**vars(known["gazebo_msgs"]), "ModelState": ModelState}
    )
    return {
        f"{package}.msg": open_module(
            f"{package}.msg",
            partial(_open_message, types),
            vars(types) if types else {},
            partial(_public, types) if types else None,
        )
        for package, types in {**dict.fromkeys(_FURTHER_PACKAGES), **known}.items()
    }


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
