"""Wall time that is spent working: a clock that stands still while code is compiled for this machine.

Compiling happens once on a machine and takes longer than many a run: counted, it would hide how fast a
simulation is.
"""

from __future__ import annotations

from time import perf_counter_ns


class Stopwatch:
    """A clock that can be stopped; several may stop it, and it goes on when all of them are done."""

    def __init__(self) -> None:
        self._stops = 0
        self._stopped_at_ns = 0
        self._still_ns = 0

    def now_ns(self) -> int:
        """Return the time, from an arbitrary origin."""
        return (self._stopped_at_ns if self._stops else perf_counter_ns()) - self._still_ns

    def stop(self) -> None:
        """Stand still."""
        if not self._stops:
            self._stopped_at_ns = perf_counter_ns()
        self._stops += 1

    def go_on(self) -> None:
        """Go on, unless something else has stopped it too."""
        self._stops -= 1
        if not self._stops:
            self._still_ns += perf_counter_ns() - self._stopped_at_ns


work = Stopwatch()
"""Of this process."""
