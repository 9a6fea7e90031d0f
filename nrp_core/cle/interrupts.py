"""Ctrl-C between steps, never within one."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any, Self


class DeferredInterrupt:
    """Delays Ctrl-C until the end of the block.

    So brain and world stop at the same time. A second Ctrl-C is not delayed, for code that never returns.
    Outside the main thread, and where Ctrl-C is not handled by a Python function, nothing changes.
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
