"""Run code that waits beside the loop: it continues only between two steps.

Each such task has its own thread, but only one of them or the loop runs at a time, so that the order is that
of the simulation.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from itertools import count
from math import ceil
from typing import Final

from nrp_core.utilities import time_limit

_TOO_MANY_GLANCES = 1000
"""So many looks at the clock without waiting are a loop that waits by looking."""
_TRIES_TO_STOP: Final = 100
_INTERRUPTS: Final = 8
"""Code that goes on after so many is in a loop that catches everything, and is left alone."""
_LOOK_S: Final = 0.25
"""Looks are counted instead of reading a clock: a program that was stopped spent no time."""


class Stopped(BaseException):
    """The run is over while a task waits."""


class Task:
    """Code that runs until it waits for simulated time.

    Args:
        work: the code.
        now_ns: returns the simulated time.
        limit_s: wall time that the code may take until it waits, s; None: no limit.
    """

    _current = threading.local()

    def __init__(
        self, work: Callable[[], object], now_ns: Callable[[], int], limit_s: float | None = None
    ) -> None:
        self._work, self.now_ns, self._limit_s = work, now_ns, limit_s
        self._go, self._waits = threading.Semaphore(0), threading.Semaphore(0)
        self._until_ns, self._glances, self._stopping, self._runs = 0, 0, False, False
        self.error: Exception | None = None
        self.is_over = False
        self._thread = threading.Thread(target=self._main, daemon=True, name="state machine")
        self._thread.start()

    @classmethod
    def here(cls) -> Task | None:
        """Return the current task, None for the loop itself."""
        return getattr(cls._current, "task", None)

    # -- for the loop

    def advance(self) -> None:
        """Run the code until it waits, unless it is not due yet."""
        if self.is_over or self.now_ns() < self._until_ns:
            return
        if not self._waits_again(self._limit_s):
            self.error = TimeoutError(f"it did not wait within {self._limit_s:g} s, the function_time_limit")
            self.stop()

    def waits_within(self, patience_s: float) -> bool:
        """Let the code run, and return whether it waits, or is over, within some wall time, 0 for at once."""
        if self.is_over or (not self._runs and self.now_ns() < self._until_ns):
            return True
        if patience_s > 0:
            return self._waits_again(patience_s)
        waits = self._waits.acquire(blocking=False)
        self._runs = not waits
        return waits

    def stop(self) -> None:
        """End the code where it is; code that catches this is never resumed."""
        self._stopping = True
        interrupts = 0
        for _ in range(_TRIES_TO_STOP):
            if self.is_over or interrupts == _INTERRUPTS:
                break
            if self._runs:
                assert self._thread.ident is not None
                time_limit.interrupt(self._thread.ident)
                interrupts += 1
            self._waits_again(_LOOK_S)
        if interrupts:
            time_limit.forget_interrupts()
        self.is_over = True

    def _waits_again(self, limit_s: float | None) -> bool:
        """Let the code run until it waits, and return whether it does within a limit."""
        if not self._runs:
            self._runs = True
            self._go.release()
        for _ in count() if limit_s is None else range(ceil(limit_s / _LOOK_S)):
            if self._waits.acquire(timeout=_LOOK_S):
                self._runs = False
                return True
        return False

    # -- for the code

    def wait_until(self, t_ns: int) -> None:
        """Wait for a time, one step at least.

        Raises:
            Stopped: the run is over.
        """
        self._until_ns, self._glances = t_ns, 0
        self._waits.release()
        self._go.acquire()
        if self._stopping:
            raise Stopped

    def glance(self) -> None:
        """Count a reading of the clock."""
        self._glances += 1
        if self._glances > _TOO_MANY_GLANCES:
            self.wait_until(0)

    def _main(self) -> None:
        type(self)._current.task = self
        self._go.acquire()
        try:
            if not self._stopping:
                self._work()
        except (Stopped, time_limit.TimeLimitExceeded):
            pass
        except Exception as error:  # noqa: BLE001 - code of users may raise anything
            self.error = error
        finally:
            self.is_over = True
            self._waits.release()


def run_together(works: Sequence[Callable[[], object]]) -> None:
    """Run pieces of code to their ends: while one waits for simulated time, the others continue.

    Outside a task they cannot wait and run in sequence. An exception in one ends all.
    """
    here = Task.here()
    if here is None:
        for work in works:
            work()
        return
    tasks = [Task(work, here.now_ns) for work in works]
    try:
        while not all(task.is_over for task in tasks):
            for task in tasks:
                task.advance()
                if task.error is not None:
                    raise task.error
            if not all(task.is_over for task in tasks):
                here.wait_until(0)
    finally:
        for task in tasks:
            task.stop()
