"""Compile numeric kernels with Numba where it is installed; without it they run, slower, as Python.

Compiled code is cached on disk; the first call of a kernel after installation compiles it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

try:
    import numba

    COMPILED = True
except ImportError:
    COMPILED = False


def jit(function: F) -> F:
    """Compile a function of scalars and arrays; it releases the GIL while it runs."""
    if not COMPILED:
        return function
    compiled: F = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    return compiled
