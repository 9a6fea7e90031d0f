"""A limit to the wall time that one call of a transfer function may take.

A thread of its own looks a few times a second whether the same call is still under way, and interrupts it
when it has seen it for too long. The loop only leaves a number, so that a call costs 0.2 us more. Looks are
counted rather than a clock read: a program that was stopped, or a machine that slept, spent no time.
"""

from __future__ import annotations

import ctypes
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, Final, TypeVar

T = TypeVar("T")

DEFAULT_S: Final = 60.0
"""Generous: models that are loaded and code that is compiled at the first call take their time as well."""
_LOOK_S: Final = 0.25
_LOOKS: Final = 8
"""At least so many looks at a call before it is interrupted."""


class TimeLimitExceeded(BaseException):
    """Raised within a call that took too long; no ``Exception``, so that functions do not catch it."""


class TimeLimit:
    """Interrupts calls that do not return.

    In the main thread, what waits for the operating system (``sleep``, a socket) is interrupted as well; in
    another thread the interpreter has to come back to Python first. Library code that computes without an
    end and never comes back to Python cannot be interrupted.

    Args:
        limit_s: how long a call may take, wall time, s; None: for ever.
    """

    def __init__(self, limit_s: float | None = DEFAULT_S) -> None:
        self.limit_s = limit_s
        self._look_s = _LOOK_S if limit_s is None else min(_LOOK_S, limit_s / _LOOKS)
        self._lock = threading.Lock()
        self._calls = 0
        self._current = 0  # number of the call under way
        self._late = 0  # number of the call that took too long
        self._again = False  # whether it was interrupted before and went on
        self._tracer: Any = None
        self._watched = False
        self._watcher: threading.Thread | None = None

    def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """Return what a function returns.

        Raises:
            TimeLimitExceeded: it did not within the limit, in a :meth:`watching` block.
        """
        self._calls = number = self._calls + 1
        self._current = number
        try:
            return function(*arguments)
        except TimeLimitExceeded as error:
            error.args = (f"did not return within {self.limit_s:g} s, its function_time_limit",)
            raise
        finally:
            self._current = 0  # before anything else: from here on nobody new interrupts this call
            if self._late == number:
                sys.settrace(self._tracer)
                with self._lock:  # somebody may be at it
                    _withdraw()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Watch over the calls of this thread until the end of the block."""
        if self.limit_s is None:
            yield
            return
        self._tracer = sys.gettrace()
        main = threading.current_thread() is threading.main_thread()
        before = signal.signal(signal.SIGURG, self._on_signal) if main else None
        with self._lock:
            self._thread, self._watched, self._in_main = threading.get_ident(), True, main
            if self._watcher is None or not self._watcher.is_alive():  # threads do not survive a fork
                self._watcher = threading.Thread(target=self._watch, name="time limit", daemon=True)
                self._watcher.start()
        try:
            yield
        finally:
            with self._lock:
                self._watched = False
            if main:
                signal.signal(signal.SIGURG, before or signal.SIG_DFL)

    # -- in the thread that watches

    def _watch(self) -> None:
        """Look again and again until nobody wants it any more."""
        assert self.limit_s is not None
        seen, looks = 0, 0
        while True:
            time.sleep(self._look_s)
            with self._lock:
                if not self._watched:
                    self._watcher = None
                    return
                looks = looks + 1 if self._current == seen else 0
                seen = self._current
                if seen and looks * self._look_s >= self.limit_s:
                    self._interrupt(seen)

    def _interrupt(self, number: int) -> None:
        self._again = self._late == number
        self._late = number
        if self._current != number:
            return  # it has returned since, without looking at what was set just now
        if self._in_main:
            # nothing else uses this signal; being one, it also ends what waits for the operating system
            signal.pthread_kill(self._thread, signal.SIGURG)
        else:
            _raise_in(self._thread)

    # -- in the thread that calls

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self._current and self._current == self._late:
            if self._again:
                _insist(frame)
            raise TimeLimitExceeded


def _insist(frame: FrameType | None) -> None:
    """Let what catches the exception raise it again: a bare ``except:`` in a loop would go on for ever."""

    def trace(_frame: FrameType, event: str, _argument: Any) -> Any:
        if event == "line":
            raise TimeLimitExceeded
        return trace if event == "exception" else None

    while frame is not None and frame.f_code is not TimeLimit.call.__code__:
        frame.f_trace = trace
        frame = frame.f_back
    sys.settrace(trace)


def _raise_in(thread: int) -> None:
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(TimeLimitExceeded))


def _withdraw() -> None:
    """Drop an exception that was meant for a call of this thread and came too late for it."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(threading.get_ident()), None)
