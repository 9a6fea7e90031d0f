"""The numbers in messages, with their dotted paths and units."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from nrp_core.world.messages.base import type_name

_UNITS = {
    "geometry_msgs/msg/Point": {"x": "m", "y": "m", "z": "m"},
    "geometry_msgs/msg/Pose2D": {"x": "m", "y": "m", "theta": "rad"},
    "geometry_msgs/msg/Transform": {"translation": "m"},
    "geometry_msgs/msg/Twist": {"linear": "m/s", "angular": "rad/s"},
    "geometry_msgs/msg/Accel": {"linear": "m/s^2", "angular": "rad/s^2"},
    "geometry_msgs/msg/Wrench": {"force": "N", "torque": "N m"},
    "sensor_msgs/msg/Imu": {"angular_velocity": "rad/s", "linear_acceleration": "m/s^2"},
    "sensor_msgs/msg/MagneticField": {"magnetic_field": "T"},
    "sensor_msgs/msg/FluidPressure": {"fluid_pressure": "Pa"},
    "sensor_msgs/msg/NavSatFix": {"latitude": "deg", "longitude": "deg", "altitude": "m"},
    "sensor_msgs/msg/LaserScan": {
        "angle_min": "rad", "angle_max": "rad", "angle_increment": "rad", "time_increment": "s",
        "scan_time": "s", "range_min": "m", "range_max": "m", "ranges": "m",
    },
    "sensor_msgs/msg/Range": {"field_of_view": "rad", "min_range": "m", "max_range": "m", "range": "m"},
}  # fmt: skip
"""Units of the fields of a type and of everything in them (REP 103 and the definitions of the types)."""


@dataclasses.dataclass(frozen=True, slots=True)
class Value:
    """A value in a message.

    Args:
        path: names of the fields, joined by dots; an item of an array has a number or a name.
        value: a number, a truth value or a text.
        unit: its unit by the type of the message, or the empty string.
    """

    path: str
    value: Any
    unit: str


def numbers_in(message: Any) -> Iterator[tuple[str, float]]:
    """Return every number in a message with its dotted path; headers and arrays are left out."""
    for one in single_values(message):
        if not isinstance(one.value, str):
            yield one.path, float(one.value)


def units_in(message: Any) -> dict[str, str]:
    """Return the units of the numbers from :func:`numbers_in`, as far as its type gives them."""
    return {one.path: one.unit for one in single_values(message) if one.unit}


def single_values(message: Any) -> Iterator[Value]:
    """Return the values in a message; headers and arrays are left out."""
    return _values(message, "", "", arrays=False)


def values_in(message: Any) -> Iterator[Value]:
    """Return the values in a message and its arrays; headers are left out.

    Items of an array are named by the message's list ``name`` if it has the same length, as for joints
    and models; otherwise they are numbered.
    """
    return _values(message, "", "", arrays=True)


def _values(message: Any, path: str, unit: str, *, arrays: bool) -> Iterator[Value]:
    units, names = _UNITS.get(type_name(type(message)), {}), getattr(message, "name", ())
    for spec in dataclasses.fields(message):
        if spec.name == "header" or (arrays and spec.name == "name" and _is_sequence(names)):
            continue
        value, own = getattr(message, spec.name), unit or units.get(spec.name, "")
        if _is_sequence(value):
            for key, item in _items(value, names) if arrays else ():
                yield from _value(item, f"{path}{spec.name}.{key}", own, arrays=True)
        else:
            yield from _value(value, f"{path}{spec.name}", own, arrays=arrays)


def _value(value: Any, path: str, unit: str, *, arrays: bool) -> Iterator[Value]:
    if dataclasses.is_dataclass(value):
        yield from _values(value, f"{path}.", unit, arrays=arrays)
    elif isinstance(value, (bool, int, float, str)):
        yield Value(path, value, unit)


def _items(values: Any, names: Any) -> Iterator[tuple[str, Any]]:
    flat = values.ravel().tolist() if isinstance(values, np.ndarray) else values
    named = _is_sequence(names) and len(names) == len(flat)
    return zip(names if named else map(str, range(len(flat))), flat, strict=True)


def _is_sequence(value: Any) -> bool:
    return isinstance(value, np.ndarray) or (
        isinstance(value, Sequence) and not isinstance(value, (str, bytes))
    )
