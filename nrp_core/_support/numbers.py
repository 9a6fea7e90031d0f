"""What counts as a number among values that users give."""

from __future__ import annotations

from numbers import Real
from typing import TypeGuard


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a real number, of Python or NumPy; a truth value is none."""
    return isinstance(value, Real) and not isinstance(value, bool)
