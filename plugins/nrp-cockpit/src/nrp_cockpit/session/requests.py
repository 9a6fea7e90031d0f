"""Calls that other threads leave for the thread that owns a session."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from nrp_core.errors import LifecycleError

_CLOSED = "the run is being closed"


class Requests:
    """Holds calls until the owner makes them; each caller waits for the answer."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._changed = threading.Condition()
        self.is_closed = self._woken = False

    @property
    def wanted(self) -> bool:
        """Whether a caller waits for an answer or for the end."""
        return bool(self._waiting) or self.is_closed

    def ask(self, call: Callable[[], Any]) -> Any:
        """Have the owner make a call; return its result or raise its error.

        Raises:
            LifecycleError: the session is being closed.
        """
        future: Future[Any] = Future()
        with self._changed:
            if self.is_closed:
                raise LifecycleError(_CLOSED)
            self._waiting.append((call, future))
            self._changed.notify_all()
        return future.result()

    def answer(self) -> None:
        """Make all waiting calls; for the owner."""
        while self._waiting and not self.is_closed:
            call, future = self._waiting.popleft()
            try:
                result = call()
            except Exception as error:  # noqa: BLE001  it belongs to the caller
                future.set_exception(error)
            except BaseException:  # Ctrl-C, which belongs to the owner
                future.set_exception(LifecycleError(_CLOSED))
                raise
            else:
                future.set_result(result)

    def wait(self, wall_s: float) -> None:
        """Wait for a call, at most for a time."""
        with self._changed:
            self._changed.wait_for(lambda: self.wanted, wall_s)

    def idle(self, wall_s: float) -> None:
        """Wait for a call or for :meth:`wake`, at most for a time."""
        with self._changed:
            self._changed.wait_for(lambda: self.wanted or self._woken, wall_s)
            self._woken = False

    def wake(self) -> None:
        """Wake an idle owner, for example because a topic has a new subscriber; any thread may call this."""
        with self._changed:
            self._woken = True
            self._changed.notify_all()

    def serve(self, begin: Callable[[], None], rest_s: float, look: Callable[[], None]) -> None:
        """Answer calls until :meth:`close` or Ctrl-C, then refuse those that wait.

        Args:
            begin: called first.
            rest_s: longest wall time between two looks.
            look: called after each answer or rest.
        """
        try:
            begin()
            while not self.is_closed:
                self.wait(rest_s)
                self.answer()
                look()
        except KeyboardInterrupt:
            pass
        finally:
            self.close()
            self.refuse()

    def close(self) -> None:
        """Accept no more calls; any thread may call this, also repeatedly."""
        with self._changed:
            self.is_closed = True
            self._changed.notify_all()

    def refuse(self) -> None:
        """Refuse the calls that still wait; after :meth:`close`."""
        while self._waiting:
            self._waiting.popleft()[1].set_exception(LifecycleError(_CLOSED))
