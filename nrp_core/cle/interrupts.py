"""Ctrl-C between steps, never within one."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any, Self


class DeferredInterrupt:
    """Holds Ctrl-C back until the end of the block.

    Brain and world so stop at the same time. A second Ctrl-C is not held back, for code that never
    returns. In other threads than the main one, and where a program handles Ctrl-C in no Python function,
    nothing is changed.
    """

    def __enter__(self) -> Self:
        self._held = False
        self._handler: Any = None
        if threading.current_thread() is threading.main_thread():
            handler = signal.getsignal(signal.SIGINT)
            if callable(handler):
                self._handler = handler
                signal.signal(signal.SIGINT, self._hold)
        return self

    def _hold(self, number: int, frame: FrameType | None) -> None:
        if self._held:
            self._handler(number, frame)
        self._held = True

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._handler is not None:
            signal.signal(signal.SIGINT, self._handler)
            if error is None and self._held:
                self._handler(signal.SIGINT, None)
