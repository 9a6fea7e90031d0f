"""Variables that keep their values between runs of a transfer function."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.dsl.parameters.brief import brief

GLOBAL = "global_scope"
"""The scope of a variable that all transfer functions of an experiment share."""
TRANSFER_FUNCTION_LOCAL = "transfer_function_scope"
"""The scope of a variable of one transfer function."""
SCOPES = (GLOBAL, TRANSFER_FUNCTION_LOCAL)


class Variable(Adapter):
    """A value that persists between runs.

    Args:
        name: for messages.
        initial: the value at time 0; it is copied, so that changes in place are undone by a reset.
            An object that cannot be copied, such as an open file, remains the same object.

    Attributes:
        value: the current value.
    """

    __slots__ = ("_initial", "name", "value")

    def __init__(self, name: str, initial: Any = None) -> None:
        self.name = name
        self._initial = _copied(initial)
        self.reset()

    def begin_with(self, initial: Any) -> None:
        """Set the initial value, unless there already is one."""
        if self._initial is None and initial is not None:
            self._initial = _copied(initial)
            self.reset()

    def reset(self) -> None:
        self.value: Any = _copied(self._initial)

    def save(self) -> Any:
        return self.value

    def restore(self, saved: Any) -> None:
        self.value = saved

    @property
    def is_lost(self) -> bool:
        """Whether a number of the value has become NaN, so that whatever is computed with it is NaN."""
        return _has_nan(self.value) and not _has_nan(self._initial)

    def shown(self) -> str:
        return f"value = {brief(self.value)}"


def _has_nan(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return any(_has_nan(one) for one in value)
    is_real = isinstance(value, float | np.floating | np.ndarray) and np.asarray(value).dtype.kind == "f"
    return is_real and bool(np.isnan(value).any())


def _copied(value: Any) -> Any:
    try:
        return copy.deepcopy(value)
    except (TypeError, copy.Error):
        return value
