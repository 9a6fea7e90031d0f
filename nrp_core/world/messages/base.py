"""What makes a dataclass a message."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from nrp_core.clock import NS_PER_S

T = TypeVar("T")

_TYPES: dict[str, type] = {}


def message(name: str) -> Callable[[type[T]], type[T]]:
    """Name a dataclass as a message type.

    Args:
        name: ROS's full name, ``package/msg/Type``.
    """

    def register(cls: type[T]) -> type[T]:
        cls.__msgtype__ = name  # type: ignore[attr-defined]
        _TYPES[name] = cls
        return cls

    return register


def type_of(name: str) -> type | None:
    """Return the message class of a full (``a/msg/B``) or short (``a/B``) name, if it is loaded."""
    full = name if name.count("/") == 2 else name.replace("/", "/msg/")
    return _TYPES.get(full)


def type_name(cls: type) -> str:
    """Return the ROS name of a message class; for any other dataclass its own name."""
    return str(getattr(cls, "__msgtype__", cls.__name__))


@message("builtin_interfaces/msg/Time")
@dataclass(slots=True)
class Time:
    """A time stamp."""

    sec: int = 0
    nanosec: int = 0

    @classmethod
    def from_ns(cls, t_ns: int) -> Time:
        """Build a stamp from nanoseconds."""
        return cls(*divmod(t_ns, NS_PER_S))

    def to_ns(self) -> int:
        """Return nanoseconds."""
        return self.sec * NS_PER_S + self.nanosec

    def to_sec(self) -> float:
        """Return seconds."""
        return self.to_ns() / NS_PER_S


TIME_ZERO = Time()


def invalid_field(value: Any, path: str = "") -> str | None:
    """Return what is wrong with the numbers in a message, or None.

    A float field must hold a finite number; nested messages are looked into, arrays are not (a laser's
    range may be infinite).
    """
    for spec in dataclasses.fields(value):
        item, name = getattr(value, spec.name), f"{path}{spec.name}"
        if dataclasses.is_dataclass(item):
            wrong = invalid_field(item, f"{name}.")
            if wrong:
                return wrong
        elif spec.type in (float, "float"):
            if not isinstance(item, (int, float, np.integer, np.floating)):
                return f"{name} must be a number, not {item!r}"
            if not np.isfinite(item):
                return f"{name} is {item}"
    return None
