"""Simulated time for the threads of a script: to sleep there means to wait for the simulation.

One thread works at a time: the simulation goes on when all others sleep or have ended. So what callbacks send
does not depend on the machine. A callback that waits for something other than time goes on beside the
simulation after a short wait. Threads that a callback starts sleep in simulated time too.
"""

from __future__ import annotations

import ast
import threading
import time
from collections.abc import Callable, Iterator
from threading import Event, Thread, current_thread
from types import ModuleType
from typing import Any, Final

from nrp_core.clock import MS_PER_S, from_milliseconds

_STOPS: Final = {"request_stop", "stop_run"}
_BEGINS: Final = {"run_forever"}
_WAITS: Final = {"input", "join", "mainloop", "raw_input", "show", "sleep", "wait", *_STOPS}
"""What a script does while its network runs beside it."""


def stops_elsewhere(source: bytes) -> bool:
    """Return whether other code than that which begins a run stops it, or nothing in the script does."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):  # the script is refused when it runs, or is not in this language
        return False
    functions = [each for each in ast.walk(tree) if isinstance(each, (ast.FunctionDef, ast.Lambda))]
    called = [{*_called(each)} for each in functions]
    if any(_STOPS & names and not _BEGINS & names for names in called):
        return True
    apart = {id(part) for each in functions for part in ast.walk(each)}
    own = {_name(each) for each in ast.walk(tree) if isinstance(each, ast.Call) and id(each) not in apart}
    beginning = [names for names in (own, *called) if _BEGINS & names]
    return bool(beginning) and not any(_WAITS & names for names in (own, *beginning))


def _name(call: ast.Call) -> str:
    return str(getattr(call.func, "attr", getattr(call.func, "id", "")))


def _called(function: ast.AST) -> Iterator[str]:
    for each in ast.walk(function):
        if isinstance(each, ast.Call):
            yield _name(each)


_PATIENCE_S: Final = 1.0


class SimulatedClock:
    """The time of a simulation, and the threads that sleep in it."""

    def __init__(self) -> None:
        self._now_ms = 0.0
        self._threads: list[_Sleeper] = []

    def begin(self, function: Callable[..., Any], *arguments: Any) -> None:
        """Call a function in a thread of its own; return when it sleeps or has ended."""
        name = f"callback {getattr(function, '__name__', '')}"
        thread = _Sleeper(target=function, args=arguments, name=name, daemon=True)
        self._follow(thread)
        self._require_success()

    def advance(self, now_ms: float) -> None:
        """Set the time, and let all threads that wake by then go on until they sleep again or end."""
        self._now_ms = now_ms
        while due := [
            thread
            for thread in self._threads
            if from_milliseconds(thread.wake_ms) <= from_milliseconds(now_ms) and not thread.goes.is_set()
        ]:
            thread = min(due, key=lambda each: each.wake_ms)
            thread.rests.clear()
            thread.goes.set()
            thread.rests.wait(_PATIENCE_S)
        self._require_success()

    def sleep(self, seconds: float) -> None:
        """Wait for simulated time in a thread of this clock, and for real time elsewhere."""
        thread = current_thread()
        if not _sleeps(thread):
            time.sleep(seconds)
            return
        assert isinstance(thread, _Sleeper)
        thread.sleep_until(max(thread.wake_ms, self._now_ms) + seconds * MS_PER_S)

    def modules(self) -> dict[str, ModuleType]:
        """Return the modules ``time`` and ``threading`` for the script."""
        follow = self._follow

        class ScriptThread(_Sleeper):
            def start(self) -> None:
                parent = current_thread()
                if not _sleeps(parent):
                    super().start()
                    return
                assert isinstance(parent, _Sleeper)
                self.wake_ms = parent.wake_ms
                follow(self)

        ScriptThread.__name__ = ScriptThread.__qualname__ = "Thread"
        return {"time": _with(time, sleep=self.sleep), "threading": _with(threading, Thread=ScriptThread)}

    def close(self) -> None:
        """End all threads that sleep, and go back to time 0."""
        for thread in self._threads:
            thread.cancelled = True
            thread.goes.set()
        self._threads, self._now_ms = [], 0.0

    def _follow(self, thread: _Sleeper) -> None:
        """Start a thread; return when it sleeps or has ended."""
        thread.follows = True
        self._threads.append(thread)
        Thread.start(thread)
        thread.rests.wait(_PATIENCE_S)

    def _require_success(self) -> None:
        errors = [thread.error for thread in self._threads if thread.error is not None]
        self._threads = [thread for thread in self._threads if thread.is_alive() and not thread.ended]
        if errors:
            raise errors[0]


class _Sleeper(Thread):
    """A thread that sleeps in simulated time, if it follows the clock.

    Attributes:
        follows: whether it does.
        wake_ms: when its sleep ends, or ended.
        goes: set while the thread works.
        rests: set while it sleeps, and when it has ended.
        error: what its function raised.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.follows = False
        self.wake_ms = 0.0
        self.goes, self.rests = Event(), Event()
        self.goes.set()
        self.cancelled = self.ended = False
        self.error: BaseException | None = None
        body = self.run  # of a subclass of the script, too
        self.run = lambda: self._run(body)  # type: ignore[method-assign]

    def _run(self, body: Callable[[], None]) -> None:
        if not self.follows:
            body()
            return
        try:
            body()
        except SystemExit:
            pass
        except BaseException as error:  # noqa: BLE001 - the simulation raises it
            self.error = error
        self.ended = True
        self.rests.set()

    def sleep_until(self, wake_ms: float) -> None:
        """Sleep; called in this thread.

        Raises:
            SystemExit: the simulation has ended.
        """
        self.wake_ms = wake_ms
        self.goes.clear()
        self.rests.set()
        self.goes.wait()
        if self.cancelled:
            raise SystemExit


def _sleeps(thread: Thread) -> bool:
    return isinstance(thread, _Sleeper) and thread.follows


def _with(module: ModuleType, **names: Any) -> ModuleType:
    """Return a copy of a module with other objects for some names."""
    copy = ModuleType(module.__name__, module.__doc__)
    vars(copy).update({**vars(module), **names})
    return copy
