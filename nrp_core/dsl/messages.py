"""The message types that a transfer function file can name, and how they are named."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from types import MappingProxyType, ModuleType
from typing import Any

from nrp_core.errors import TopicError, did_you_mean
from nrp_core.world import messages
from nrp_core.world.messages.base import type_name, type_of


@cache
def message_packages() -> MappingProxyType[str, ModuleType]:
    """Return every package of messages as ROS lays it out, ``<package>.msg.<Type>``, by its name."""
    names = [found.name for found in pkgutil.iter_modules(messages.__path__)]
    return MappingProxyType({name: _package(name) for name in names if name.endswith("_msgs")})


def _package(name: str) -> ModuleType:
    package, types = ModuleType(name, "Message types."), ModuleType(f"{name}.msg", "Message types.")
    package.__path__ = []
    for value in vars(importlib.import_module(f"{messages.__name__}.{name}")).values():
        if isinstance(value, type) and type_name(value).startswith(f"{name}/"):
            setattr(types, value.__name__, value)
    vars(package)["msg"] = types
    return package


def message_type(given: Any) -> type:
    """Return our class of messages for whatever names one.

    Args:
        given: one of our classes, any other dataclass, a class of ROS 1, ROS 2 or rosbags, or a
            name such as ``geometry_msgs/Twist`` or ``geometry_msgs/msg/Twist``.

    Raises:
        TopicError: it names none.
    """
    name = given if isinstance(given, str) else _foreign_name(given)
    if name is not None:
        return _named(name)
    if isinstance(given, type):
        return given
    raise TopicError(f"{given!r:.60} is no message type; name one such as std_msgs.msg.Float64")


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
        raise TopicError(f"no package of messages '{package}'{did_you_mean(package, message_packages())}")
    types = vars(message_packages()[package].msg)
    if not isinstance(types.get(short), type):
        known = [key for key, value in types.items() if isinstance(value, type)]
        raise TopicError(f"no message type '{name}'{did_you_mean(short, known)}")
    return types[short]  # type: ignore[no-any-return]
