"""Numbers in messages as ROS 1 took them: whatever can be written as one."""

from __future__ import annotations

import numbers
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from math import isfinite
from typing import Any

import numpy as np

_NUMBERS = ("float", "int", float, int)


def with_numbers(message: Any, tell: Callable[[str], None] | None = None) -> Any:
    """Return a message, or its only field, with plain numbers for arrays of one number and for decimals.

    Args:
        message: the message or number.
        tell: called with each number that is not finite, for which 0 is returned; None: it stays.
    """
    if isinstance(message, (np.generic, np.ndarray)) and message.size == 1:
        message = message.item()
    if isinstance(message, numbers.Number) and not isinstance(message, (int, float, complex)):
        message = float(message)  # type: ignore[arg-type] # Decimal, Fraction
    if isinstance(message, float) and not isfinite(message) and tell is not None:
        tell(str(message))
        return 0.0
    if not is_dataclass(message) or isinstance(message, type):
        return message
    changes: dict[str, Any] = {}
    for field in fields(message):
        value = getattr(message, field.name)
        if is_dataclass(value) or field.type in _NUMBERS:
            number = with_numbers(value, tell)
            changes |= {} if number is value else {field.name: number}
    return replace(message, **changes) if changes else message
