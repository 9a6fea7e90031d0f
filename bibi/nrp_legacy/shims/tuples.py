"""Messages as ROS 1 gives them: lists of numbers are tuples, which can be searched, joined and empty."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np


def as_in_ros1(message: Any) -> Any:
    """Return a message whose arrays of floats are tuples; pictures and other bytes stay arrays."""
    if not is_dataclass(message) or isinstance(message, type):
        return message
    values = {field.name: getattr(message, field.name) for field in fields(message)}
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    tuples = {
        name: tuple(value.tolist())
        for name, value in arrays.items()
        if value.dtype.kind == "f" and value.ndim == 1
    }
    return replace(message, **tuples) if tuples else message
