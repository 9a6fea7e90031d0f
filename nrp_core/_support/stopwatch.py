"""A clock of the wall time spent working: it pauses while code is compiled for this machine.

Code is compiled once on a machine, which may take longer than the run and would hide the speed of the
simulation.
"""

from __future__ import annotations

from time import perf_counter_ns


class Stopwatch:
    """A clock that can be paused; pauses may nest, and it resumes when all of them have ended."""

    def __init__(self) -> None:
        self._stops = 0
        self._stopped_at_ns = 0
        self._still_ns = 0

    def now_ns(self) -> int:
        """Return the time, from an arbitrary origin."""
        return (self._stopped_at_ns if self._stops else perf_counter_ns()) - self._still_ns

    @property
    def is_stopped(self) -> bool:
        """Whether the clock is paused, so code is being compiled."""
        return self._stops > 0

    def stop(self) -> None:
        """Pause the clock."""
        if not self._stops:
            self._stopped_at_ns = perf_counter_ns()
        self._stops += 1

    def go_on(self) -> None:
        """Resume the clock when all pauses have ended."""
        self._stops -= 1
        if not self._stops:
            self._still_ns += perf_counter_ns() - self._stopped_at_ns


work = Stopwatch()
"""The clock of this process."""
