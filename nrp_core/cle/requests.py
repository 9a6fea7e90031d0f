"""Calls that other threads want made between two steps of a loop."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")


class Requests:
    """While a thread runs or attends the loop, it makes the calls of others; otherwise each makes its own."""

    def __init__(self) -> None:
        self._changed = threading.Condition(threading.RLock())  # calls may be nested
        self._waiting: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._runner: int | None = None

    def make(self, call: Callable[[], T]) -> T:
        """Make a call between two steps; return its result or raise its exception."""
        if self._runner == threading.get_ident():
            return call()
        with self._changed:
            if self._runner is None:
                return call()
            future: Future[T] = Future()
            self._waiting.append((call, future))
            self._changed.notify_all()
        return future.result()

    @contextmanager
    def running(self) -> Iterator[None]:
        """Mark this thread as the one that makes the calls; those that wait are made at the end."""
        with self._changed:
            before, self._runner = self._runner, threading.get_ident()
        try:
            yield
        finally:
            with self._changed:
                self.serve()
                self._runner = before

    def wait(self, longest_s: float) -> None:
        """Make the pending calls; wait for one if there is none."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting, longest_s)
        self.serve()

    def serve(self) -> None:
        """Make the pending calls."""
        while self._waiting:
            call, future = self._waiting.popleft()
            try:
                future.set_result(call())
            except BaseException as error:  # noqa: BLE001 - it belongs to whoever waits for the result
                future.set_exception(error)
