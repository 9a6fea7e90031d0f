"""The other message types of ROS, made from their definitions on demand.

The definitions come with the ``rosbags`` library. The classes are like those written by hand: dataclasses
with defaults for all fields and with NumPy arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, make_dataclass
from functools import cache
from types import GenericAlias
from typing import Any

import numpy.typing as npt

from nrp_core.messages.base import array_field, message, type_of

PACKAGES = (
    "actionlib_msgs", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rosgraph_msgs", "sensor_msgs",
    "shape_msgs", "std_msgs", "stereo_msgs", "tf2_msgs", "trajectory_msgs", "visualization_msgs",
)  # fmt: skip
"""The packages whose definitions are known."""

_PLAIN: dict[str, type] = {"bool": bool, "string": str, "wstring": str}


def made(name: str) -> type | None:
    """Return the class of a message type by its full name, ``package/msg/Type``, or None."""
    known = type_of(name)
    if known is not None:
        return known
    definition = _store().fielddefs.get(name)
    return None if definition is None else _class(name, *definition)


def required(name: str) -> type:
    """Return the class of a message type whose definition is known; others are a mistake of the caller."""
    kind = made(name)
    assert kind is not None, name
    return kind


def names(package: str) -> list[str]:
    """Return the names of all message types of a package."""
    return sorted(name.rpartition("/")[2] for name in _store().types if name.startswith(f"{package}/msg/"))


@cache
def _store() -> Any:
    from rosbags.typesys import Stores, get_typestore  # reading the definitions takes time

    return get_typestore(Stores.ROS2_JAZZY)


def _class(name: str, constants: Any, fields: Any) -> type:
    specs = [
        (label, *_spec(*kind)) for label, kind in fields if label != "structure_needs_at_least_one_member"
    ]
    text = f"ROS's message {name}, made from its definition."
    content = {"__doc__": text, **{label: value for label, _, value in constants}}
    kind = make_dataclass(name.rpartition("/")[2], specs, namespace=content)
    kind.__module__, kind.__qualname__ = __name__, name
    return message(name)(kind)


def __getattr__(name: str) -> Any:
    """Return a class by the full name that pickles use for it."""
    if name.count("/") != 2:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return required(name)


def _spec(node: Any, what: Any) -> tuple[Any, Any]:
    """Return the type of a field and the factory of its default."""
    from rosbags.interfaces import Nodetype

    if node == Nodetype.BASE:
        base = what[0]
        plain = _PLAIN.get(base) or (float if base.startswith("float") else int)
        return plain, field(default=plain())
    if node == Nodetype.NAME:
        kind = made(str(what))
        assert kind is not None
        return kind, field(default_factory=kind)
    inner, length = what
    n = length if node == Nodetype.ARRAY else 0
    return _many(inner, n)


def _many(inner: Any, n: int) -> tuple[Any, Any]:
    item, _ = _spec(*inner)
    base = inner[1][0] if isinstance(inner[1], tuple) else ""
    if base and item is not str:
        dtype = {"byte": "uint8", "char": "uint8"}.get(base, base)
        return npt.NDArray[Any], array_field(dtype, n)
    make: Callable[[], Any] = item
    return GenericAlias(list, (item,)), field(default_factory=lambda: [make() for _ in range(n)])
