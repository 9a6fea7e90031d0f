"""Short texts of values, for reports."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

_LIMIT = 300


def brief(value: Any) -> str:
    """Return a value on one line: arrays by type and shape, messages by their fields."""
    text = _text(value)
    return text if len(text) <= _LIMIT else text[: _LIMIT - 3] + "..."


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size > 3:
        return f"{value.dtype} array of shape {value.shape}"
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = (f"{item.name}={_text(getattr(value, item.name))}" for item in dataclasses.fields(value))
        return f"{type(value).__name__}({', '.join(fields)})"
    return repr(value).replace("\n", " ")
