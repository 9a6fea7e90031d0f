"""Messages as in ROS 1, with tuples of numbers and bytes instead of arrays."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np


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
