"""Flush subnormal numbers to zero while a simulator works.

Conductances of silent cells decay until they are subnormal (below 2.2e-308). Processors compute with such
numbers ten to a hundred times more slowly.
"""

from __future__ import annotations

import ctypes
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple


class _Control(NamedTuple):
    """Where the C library's ``fenv_t`` keeps the control of arithmetic, and the bits that flush."""

    offset: int
    bits: int


_X86 = _Control(28, 0x8040)
"""MXCSR: flush to zero (bit 15), denormals are zero (bit 6); behind 28 bytes of the x87 unit's state."""
_FLUSH_ON_ARM = 1 << 24
"""FPCR: flush to zero. It stands first on Linux, and behind 8 bytes of FPSR on macOS."""
_CONTROLS = {
    ("linux", "x86_64"): _X86,
    ("darwin", "x86_64"): _Control(4, _X86.bits),
    ("linux", "aarch64"): _Control(0, _FLUSH_ON_ARM),
    ("darwin", "arm64"): _Control(8, _FLUSH_ON_ARM),
}
_LARGEST_ENVIRONMENT = 64


@contextmanager
def flushing_subnormals() -> Iterator[None]:
    """Flush subnormal numbers to zero in this thread, and in threads that it starts, until the block ends.

    Results differ by less than 1e-307. On unknown processors it has no effect.
    """
    control, library = _controls()
    if control is None:
        yield
        return
    before = ctypes.create_string_buffer(_LARGEST_ENVIRONMENT)
    library.fegetenv(before)
    now = ctypes.create_string_buffer(before.raw, _LARGEST_ENVIRONMENT)
    word = ctypes.c_uint32.from_buffer(now, control.offset)
    word.value |= control.bits
    library.fesetenv(now)
    try:
        yield
    finally:
        library.fesetenv(before)


@cache
def _controls() -> tuple[_Control | None, Any]:
    """Return the control of this processor and the C library with ``fesetenv``; None: not known."""
    control = _CONTROLS.get((sys.platform, platform.machine()))
    if control is None:
        return None, None
    try:
        library = ctypes.CDLL("libm.so.6" if sys.platform == "linux" else None)
    except OSError:  # another C library, whose layout is another
        return None, None
    return control, library
