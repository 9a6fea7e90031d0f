"""Signals: a request to end this process, remembered until a run has ended, and fast access to handlers.

``signal`` and ``getsignal`` are those of :mod:`_signal`, because every step of the loop calls them: those of
:mod:`signal` also look up each handler in an enum, in Python 3.11 at 4 us a call.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
from _signal import (
    SIG_DFL,
    default_int_handler,
    getsignal,
    signal,
)

TYPE_CHECKING = False  # as in .lazy: every start of the command line imports this
if TYPE_CHECKING:
    from types import FrameType

__all__ = ["INTERRUPTS", "SIG_DFL", "asked", "end_if_asked", "getsignal", "interrupt", "signal"]

INTERRUPTS = tuple(
    getattr(_signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(_signal, name)
)
"""Signals that ask a process to end; SIGHUP is not on Windows."""
asked = False
"""Whether a signal asked this process to end."""


def interrupt(number: int, frame: FrameType | None) -> None:
    """Handle a signal as Ctrl-C is handled, and remember it.

    An exception is lost where C code calls Python, as in destructors and in callbacks of the compiler: the
    next step of the run raises it again.

    Raises:
        KeyboardInterrupt: always.
    """
    global asked
    asked = True
    default_int_handler(number, frame)


def end_if_asked() -> None:
    """End long work on a thread, which signals do not interrupt.

    Raises:
        KeyboardInterrupt: a signal has asked this process to end.
    """
    if asked:
        raise KeyboardInterrupt
