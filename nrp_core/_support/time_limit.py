"""A limit to the wall time that one call of a transfer function, or a brain script, may take.

A watching thread checks a few times a second whether the same call is still in progress, and interrupts it
after too many checks. The loop only stores a number, which costs 0.2 us a call. Checks are counted instead
of reading a clock: a program that was stopped, or a machine that was suspended, spent no time.
"""

from __future__ import annotations

import ctypes
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType
from typing import Any, Final, Self, TypeVar

from nrp_core._support import signals

_LONGEST_DELAY_S: Final = 1.0
_CALLS: Final = hasattr(signal, "SIGURG")
"""Whether a thread can send a signal to the main thread: not on Windows."""
_RAISING = (signal.default_int_handler, signals.interrupt)


class DeferredInterrupt:
    """Delays Ctrl-C until the end of the block, and other signals that raise KeyboardInterrupt as it does.

    So brain and world stop at the same time. A second one is not delayed, for code that never returns; nor
    are requests to end the process for longer than 1 s.
    Outside the main thread, and where a signal is not handled by a Python function, nothing changes.

    Raises:
        KeyboardInterrupt: the process was asked to end before the block, and the exception was lost.
    """

    _repeat: threading.Timer | None = None

    def __enter__(self) -> Self:
        self._held: int | None = None
        self._handlers: dict[int, Any] = {}
        if threading.current_thread() is threading.main_thread():
            if signals.asked:
                raise KeyboardInterrupt
            for number in signals.INTERRUPTS:
                handler = signals.getsignal(number)
                if handler in _RAISING or (number == signal.SIGINT and callable(handler)):
                    self._handlers[number] = handler
                    signals.signal(number, self._hold)
        return self

    def _hold(self, number: int, frame: FrameType | None) -> None:
        if self._held is not None:
            self._handlers[number](number, frame)
        elif number != signal.SIGINT:
            main = threading.get_ident()
            self._repeat = threading.Timer(_LONGEST_DELAY_S, signal.pthread_kill, (main, number))
            self._repeat.daemon = True
            self._repeat.start()
        self._held = number

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._repeat is not None:
            self._repeat.cancel()
        for number, handler in self._handlers.items():
            signals.signal(number, handler)
        if error is None and self._held is not None:
            self._handlers[signal.Signals(self._held)](self._held, None)


T = TypeVar("T")

DEFAULT_S: Final = 60.0
"""Generous, because a first call may load models or compile code."""
_LOOK_S: Final = 0.25
_LOOKS: Final = 8
"""A call is interrupted after at least this many checks."""


class TimeLimitExceeded(BaseException):
    """Raised within a call that took too long; not an ``Exception``, so that functions do not catch it."""


class TimeLimit:
    """Interrupts calls that do not return.

    In the main thread, system calls that wait (``sleep``, a socket) are interrupted as well; in another
    thread the interpreter has to return to Python first. Library code that computes forever and never
    returns to Python cannot be interrupted.

    Args:
        limit_s: longest wall time of a call, s; None: no limit.
        name: the key of the experiment that sets it, for messages.
    """

    def __init__(self, limit_s: float | None = DEFAULT_S, name: str = "function_time_limit") -> None:
        self.limit_s, self._name = limit_s, name
        self._look_s = _LOOK_S if limit_s is None else min(_LOOK_S, limit_s / _LOOKS)
        self._lock = threading.Lock()
        self._calls = 0
        self._current = 0  # number of the call in progress
        self._late = 0  # number of the call that took too long
        self._again = False  # whether it was interrupted before and continued
        self._tracer: Any = None
        self._watched = False
        self._before: Any = None
        self._watcher: threading.Thread | None = None

    def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """Call a function and return its result.

        Raises:
            TimeLimitExceeded: it did not return within the limit, in a :meth:`watching` block.
        """
        self._calls = number = self._calls + 1
        self._current = number
        try:
            return function(*arguments)
        except TimeLimitExceeded as error:
            error.args = (f"did not return within {self.limit_s:g} s, its {self._name}",)
            raise
        finally:
            self._current = 0  # first of all: from here on, no new interrupt can hit this call
            if self._late == number:
                sys.settrace(self._tracer)
                with self._lock:  # an interrupt may be in progress
                    forget_interrupts()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Watch the calls of this thread until the end of the block."""
        if self.limit_s is None:
            yield
            return
        self._tracer = sys.gettrace()
        main = _CALLS and threading.current_thread() is threading.main_thread()
        self._before = before = signals.signal(signal.SIGURG, self._on_signal) if main else None
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
                signals.signal(signal.SIGURG, before or signals.SIG_DFL)

    # -- in the thread that watches

    def _watch(self) -> None:
        """Check repeatedly until no thread is watched."""
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
            return  # it has returned in the meantime, before it could see the flag
        if self._in_main:
            # nothing else uses this signal; as a signal it also ends system calls that wait
            signal.pthread_kill(self._thread, signal.SIGURG)
        else:
            interrupt(self._thread)

    # -- in the thread that calls

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self._current and self._current == self._late:
            if self._again:
                _insist(frame)
            raise TimeLimitExceeded
        if callable(self._before):  # the call may be one of another limit that watches as well
            self._before(number, frame)


def _insist(frame: FrameType | None) -> None:
    """Raise the exception again if it was caught: a bare ``except:`` in a loop would continue forever."""

    def trace(_frame: FrameType, event: str, _argument: Any) -> Any:
        if event == "line":
            raise TimeLimitExceeded
        return trace if event == "exception" else None

    while frame is not None and frame.f_code is not TimeLimit.call.__code__:
        frame.f_trace = trace
        frame = frame.f_back
    sys.settrace(trace)


def interrupt(thread: int) -> None:
    """Raise :class:`TimeLimitExceeded` in a thread as soon as it executes Python."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(TimeLimitExceeded))


def forget_interrupts() -> None:
    """Drop what :func:`interrupt` raised too late, in this thread or in one that has ended or waits.

    The interpreter looks for an exception until one is taken, in whichever thread. For one that is withdrawn,
    or whose thread never runs again, it looks for ever: it is slower, and CPython 3.11 never begins another
    call under a profiler or debugger.
    """
    with suppress(TimeLimitExceeded):
        interrupt(threading.get_ident())
        while True:
            pass  # the interpreter looks at each round
