"""Call a function repeatedly from a separate thread."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event, Thread

from nrp_core._support.closing import Closing


class Ticker(Closing):
    """Calls a function from a separate thread until it is closed.

    Args:
        call: the function; it must not raise exceptions.
        every_s: wall time between two calls, s.
    """

    def __init__(self, call: Callable[[], None], every_s: float) -> None:
        self._stopped = Event()
        self._thread = Thread(target=self._tick, args=(call, every_s), daemon=True)
        self._thread.start()

    def _tick(self, call: Callable[[], None], every_s: float) -> None:
        while not self._stopped.wait(every_s):
            call()

    def close(self) -> None:
        """Stop after the current call; calling it again does nothing."""
        self._stopped.set()
        self._thread.join()
