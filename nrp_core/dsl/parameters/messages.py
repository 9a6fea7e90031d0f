"""The message types of transfer function files, and their names."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache, partial
from types import MappingProxyType, ModuleType
from typing import Any

from nrp_core.errors import TopicError, did_you_mean
from nrp_core.world import messages
from nrp_core.world.messages.base import type_name, type_of
from nrp_core.world.messages.generated import PACKAGES, made
from nrp_core.world.messages.generated import names as made_names


@cache
def message_packages() -> MappingProxyType[str, ModuleType]:
    """Return every package in the layout of ROS, ``<package>.msg.<Type>`` and ``.srv.<Type>``, by name."""
    found = [module.name for module in pkgutil.iter_modules(messages.__path__)]
    names = {name for name in found if name.endswith(("_msgs", "_interfaces"))} | set(PACKAGES)
    return MappingProxyType({name: _package(name, found) for name in sorted(names)})


@cache
def service_packages() -> MappingProxyType[str, ModuleType]:
    """Return the modules of services, ``<package>.srv``, by the name of the package."""
    found = [module.name for module in pkgutil.iter_modules(messages.__path__)]
    services = [name for name in found if name.endswith("_srvs")]
    packages = {name.replace("gazebo_srvs", "gazebo_msgs"): name for name in services}
    return MappingProxyType({package: _services(package, name) for package, name in packages.items()})


def _package(name: str, found: list[str]) -> ModuleType:
    package, types = ModuleType(name, "Message types."), ModuleType(f"{name}.msg", "Message types.")
    package.__path__ = []
    if name in found:
        for value in vars(importlib.import_module(f"{messages.__name__}.{name}")).values():
            if isinstance(value, type) and type_name(value).startswith(f"{name}/"):
                setattr(types, value.__name__, value)
    if name in PACKAGES:
        vars(types)["__getattr__"] = partial(_made, name)
        vars(types)["__dir__"] = lambda: sorted({*vars(types), *made_names(name)})
    vars(package)["msg"] = types
    if name in service_packages():
        vars(package)["srv"] = service_packages()[name]
    return package


def _made(package: str, name: str) -> type:
    """Return a type that is made from its ROS definition."""
    kind = None if name.startswith("_") else made(f"{package}/msg/{name}")
    if kind is None:
        hint = "" if name.startswith("_") else did_you_mean(name, made_names(package))
        raise AttributeError(f"unknown message type '{package}.msg.{name}'{hint}")
    return kind


def _services(package: str, name: str) -> ModuleType:
    """Return ``<package>.srv``: the requests, the responses, and for each pair a class that holds both."""
    module = ModuleType(f"{package}.srv", "Services.")
    for value in list(vars(importlib.import_module(f"{messages.__name__}.{name}")).values()):
        if isinstance(value, type) and value.__name__.endswith(("Request", "Response")):
            setattr(module, value.__name__, value)
    for label, request in list(vars(module).items()):
        if label.endswith("Request") and f"{label[:-7]}Response" in vars(module):
            response = getattr(module, f"{label[:-7]}Response")
            content = {"Request": request, "Response": response, "__doc__": request.__doc__}
            setattr(module, label[:-7], type(label[:-7], (), content))
    return module


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
        return _named(name)
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


def _named(name: str) -> type:
    package, _, short = name.replace(".", "/").replace("/msg/", "/").partition("/")
    if package not in message_packages():
        raise TopicError(f"unknown message package '{package}'{did_you_mean(package, message_packages())}")
    types = message_packages()[package].msg
    found = getattr(types, short, None) or type_of(f"{package}/{short}")
    if not isinstance(found, type):
        known = [key for key, value in vars(types).items() if isinstance(value, type)]
        raise TopicError(f"unknown message type '{name}'{did_you_mean(short, known)}")
    return found
