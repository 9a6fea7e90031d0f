"""Ctrl-C between steps, never within one."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any, Self

from nrp_core._support import handlers, interruption

INTERRUPTS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that ask a process to end."""
_RAISING = (signal.default_int_handler, interruption.interrupt)


class DeferredInterrupt:
    """Delays Ctrl-C until the end of the block, and other signals that raise KeyboardInterrupt as it does.

    So brain and world stop at the same time. A second one is not delayed, for code that never returns.
    Outside the main thread, and where a signal is not handled by a Python function, nothing changes.

    Raises:
        KeyboardInterrupt: the process was asked to end before the block, and the exception was lost.
    """

    def __enter__(self) -> Self:
        self._held: int | None = None
        self._handlers: dict[signal.Signals, Any] = {}
        if threading.current_thread() is threading.main_thread():
            if interruption.asked:
                raise KeyboardInterrupt
            for number in INTERRUPTS:
                handler = handlers.getsignal(number)
                if handler in _RAISING or (number == signal.SIGINT and callable(handler)):
                    self._handlers[number] = handler
                    handlers.signal(number, self._hold)
        return self

    def _hold(self, number: int, frame: FrameType | None) -> None:
        if self._held is not None:
            self._handlers[signal.Signals(number)](number, frame)
        self._held = number

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._handlers.items():
            handlers.signal(number, handler)
        if error is None and self._held is not None:
            self._handlers[signal.Signals(self._held)](self._held, None)
