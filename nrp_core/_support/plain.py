"""What kernels take from :mod:`nrp_core._support.jit`, for those that run as Python."""

from __future__ import annotations

import ctypes
from typing import Any, TypeVar

import numpy as np

F = TypeVar("F")


def jit(function: F) -> F:
    """Return the function."""
    return function


inlined = jit


def array_at(place: int, n: int, like: Any) -> Any:
    """Return the array of ``n`` elements at a place in memory, of the type of another array."""
    memory = (ctypes.c_char * (int(n) * like.itemsize)).from_address(int(place))
    return np.frombuffer(memory, like.dtype)
