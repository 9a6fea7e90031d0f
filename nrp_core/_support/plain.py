"""What kernels take from :mod:`nrp_core._support.jit`, for those that run as Python.

Imports no compiler.
"""

from __future__ import annotations

import ctypes
from typing import Any, TypeVar

import numpy as np

F = TypeVar("F")
A = TypeVar("A")


def jit(function: F) -> F:
    """Return the function."""
    return function


inlined = jit


def array_at(place: int, n: int, like: Any) -> Any:
    """Return the array of ``n`` elements at a place in memory, of the type of another array."""
    memory = (ctypes.c_char * (int(n) * like.itemsize)).from_address(int(place))
    return np.frombuffer(memory, like.dtype)


def borrowed(arrays: A) -> A:
    """Return the array or arrays."""
    return arrays


def fma(a: float, b: float, c: float) -> float:
    """Return ``a * b + c``."""
    return a * b + c


def prefetch(_array: A, _index: int, _offset: int) -> None:
    """Do nothing."""
