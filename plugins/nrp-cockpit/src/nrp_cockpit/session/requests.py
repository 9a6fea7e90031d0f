"""Calls that other threads want made by the thread that owns a session."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from nrp_core.errors import LifecycleError

_CLOSED = "the run is being closed"


class Requests:
    """Holds calls until the owner makes them; whoever asked waits for the answer."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._changed = threading.Condition()
        self.is_closed = self._woken = False

    @property
    def wanted(self) -> bool:
        """Whether somebody waits for an answer, or for the end."""
        return bool(self._waiting) or self.is_closed

    def ask(self, call: Callable[[], Any]) -> Any:
        """Let the owner make a call; return its result or raise its error.

        Raises:
            LifecycleError: the owner makes no more calls.
        """
        future: Future[Any] = Future()
        with self._changed:
            if self.is_closed:
                raise LifecycleError(_CLOSED)
            self._waiting.append((call, future))
            self._changed.notify_all()
        return future.result()

    def answer(self) -> None:
        """Make all calls that wait; for the owner."""
        while self._waiting and not self.is_closed:
            call, future = self._waiting.popleft()
            try:
                result = call()
            except Exception as error:  # noqa: BLE001  it belongs to whoever asked
                future.set_exception(error)
            except BaseException:  # Ctrl-C, which belongs to the owner
                future.set_exception(LifecycleError(_CLOSED))
                raise
            else:
                future.set_result(result)

    def wait(self, wall_s: float) -> None:
        """Wait until somebody wants something, at most for a time."""
        with self._changed:
            self._changed.wait_for(lambda: self.wanted, wall_s)

    def idle(self, wall_s: float) -> None:
        """Wait until somebody wants something or wakes the owner, at most for a time."""
        with self._changed:
            self._changed.wait_for(lambda: self.wanted or self._woken, wall_s)
            self._woken = False

    def wake(self) -> None:
        """Let an owner that idles look around, such as for a topic that is newly heard; for any thread."""
        with self._changed:
            self._woken = True
            self._changed.notify_all()

    def close(self) -> None:
        """Take no more calls; any thread may call this, and more than once."""
        with self._changed:
            self.is_closed = True
            self._changed.notify_all()

    def refuse(self) -> None:
        """Tell all who still wait that their calls are not made any more; after :meth:`close`."""
        while self._waiting:
            self._waiting.popleft()[1].set_exception(LifecycleError(_CLOSED))
