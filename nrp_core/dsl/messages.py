"""The message types of transfer function files, and their names."""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module
from types import MappingProxyType, ModuleType
from typing import Any

from nrp_core import messages
from nrp_core.errors import TopicError, did_you_mean
from nrp_core.messages.base import type_name, type_of
from nrp_core.messages.generated import PACKAGES, made
from nrp_core.messages.generated import names as made_names


@cache
def message_packages() -> MappingProxyType[str, ModuleType]:
    """Return every package in the layout of ROS, ``<package>.msg.<Type>`` and ``.srv.<Type>``, by name."""
    own = (name for name in _own_modules() if name.endswith(("_msgs", "_interfaces")))
    return MappingProxyType({name: _package(name) for name in sorted({*own, *PACKAGES})})


@cache
def service_packages() -> MappingProxyType[str, ModuleType]:
    """Return the modules of services, ``<package>.srv``, by the name of the package."""
    services = (name for name in _own_modules() if name.endswith("_srvs"))
    packages = (name.replace("gazebo_srvs", "gazebo_msgs") for name in services)
    return MappingProxyType({package: _Services(package) for package in packages})


@cache
def _own_modules() -> list[str]:
    return [module.name for module in pkgutil.iter_modules(messages.__path__)]


def _own_classes(module: str) -> list[type]:
    """Return the classes in our module of messages, if it exists."""
    names = vars(import_module(f"{messages.__name__}.{module}")) if module in _own_modules() else {}
    return [value for value in names.values() if isinstance(value, type)]


def _package(name: str) -> ModuleType:
    package = ModuleType(name, "Message types.")
    package.__path__ = []
    vars(package)["msg"] = _Types(name)
    if name in service_packages():
        vars(package)["srv"] = service_packages()[name]
    return package


class _OnDemand(ModuleType):
    """A module whose contents are imported when one of its names is used first.

    The classes of all messages would take 0.05 s in every run, which uses few of them.
    """

    def __init__(self, package: str, name: str, doc: str) -> None:
        super().__init__(f"{package}.{name}", doc)
        self._package, self._is_filled = package, False

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":  # as ``from package.msg import *`` asks for
            return [label for label in self._filled() if not label.startswith("_")]
        found = None if name.startswith("_") else self._filled().get(name)
        return self._other(name) if found is None else found

    def __dir__(self) -> list[str]:
        return sorted(self._filled())

    def _filled(self) -> dict[str, Any]:
        if not self._is_filled:
            self._is_filled = True
            vars(self).update(self._contents())
        return vars(self)

    def _contents(self) -> dict[str, type]:
        """Return our classes."""
        raise NotImplementedError

    def _other(self, name: str) -> Any:
        """Return the object for a name that is not one of our classes, or raise an AttributeError."""
        raise AttributeError(f"unknown type '{self.__name__}.{name}'")


class _Types(_OnDemand):
    """``<package>.msg``: our types, and types made from their ROS definitions."""

    def __init__(self, package: str) -> None:
        super().__init__(package, "msg", "Message types.")

    def __dir__(self) -> list[str]:
        made_here = made_names(self._package) if self._package in PACKAGES else []
        return sorted({*super().__dir__(), *made_here})

    def _contents(self) -> dict[str, type]:
        prefix = f"{self._package}/"
        return {
            kind.__name__: kind for kind in _own_classes(self._package) if type_name(kind).startswith(prefix)
        }

    def _other(self, name: str) -> Any:
        kind = None
        if not name.startswith("_") and self._package in PACKAGES:
            kind = made(f"{self._package}/msg/{name}")
        if kind is None:
            names = [] if name.startswith("_") else dir(self)
            raise AttributeError(f"unknown message type '{self.__name__}.{name}'{did_you_mean(name, names)}")
        return kind


class _Services(_OnDemand):
    """``<package>.srv``: the requests, the responses, and for each pair a class that holds both."""

    def __init__(self, package: str) -> None:
        super().__init__(package, "srv", "Services.")

    def _contents(self) -> dict[str, type]:
        kinds = {kind.__name__: kind for kind in _own_classes(self._package.replace("_msgs", "_srvs"))}
        kinds = {name: kind for name, kind in kinds.items() if name.endswith(("Request", "Response"))}
        for label in [name for name in kinds if name.endswith("Request")]:
            name = label.removesuffix("Request")
            if f"{name}Response" in kinds:
                content = {"Request": kinds[label], "Response": kinds[f"{name}Response"]}
                kinds[name] = type(name, (), content | {"__doc__": kinds[label].__doc__})
        return kinds


def message_type(given: Any) -> type:
    """Return our message class for a class or a name.

    Args:
        given: one of our classes, any other dataclass, a class of ROS 1, ROS 2 or rosbags, or a
            name such as ``geometry_msgs/Twist`` or ``geometry_msgs/msg/Twist``.

    Raises:
        TopicError: it is not a message type.
    """
    name = given if isinstance(given, str) else _foreign_name(given)
    if name is not None:
        return _message_class(name)
    if isinstance(given, type):
        return given
    raise TopicError(f"{given!r:.60} is not a message type; name one such as std_msgs.msg.Float64")


def _foreign_name(given: Any) -> str | None:
    """Return the full name of a message class that is not ours, or None."""
    if hasattr(given, "__msgtype__"):
        name = str(given.__msgtype__)
        return None if type_of(name) in (given, None) else name
    if hasattr(given, "get_fields_and_field_types"):
        return f"{given.__module__.partition('.')[0]}/{given.__name__}"
    ros1_name = getattr(given, "_type", None)
    return ros1_name if isinstance(ros1_name, str) else None


def _message_class(name: str) -> type:
    package, _, short = name.replace(".", "/").replace("/msg/", "/").partition("/")
    if package not in message_packages():
        raise TopicError(f"unknown message package '{package}'{did_you_mean(package, message_packages())}")
    types = message_packages()[package].msg
    found = getattr(types, short, None) or type_of(f"{package}/{short}")
    if not isinstance(found, type):
        known = [key for key, value in vars(types).items() if isinstance(value, type)]
        raise TopicError(f"unknown message type '{name}'{did_you_mean(short, known)}")
    return found
