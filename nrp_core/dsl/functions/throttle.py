"""The maximum rate of a transfer function."""

from __future__ import annotations

from nrp_core.clock import SampleSchedule


class Throttle:
    """Admits one run in each period of a rate; the first run is immediate.

    Periods are counted from time 0 in rational arithmetic, so the mean rate is exact even if
    steps do not divide it: 30 Hz at steps of 20 ms gives gaps of 40, 40 and 20 ms.

    Args:
        rate_hz: runs per second, positive; None: no limit.
    """

    def __init__(self, rate_hz: float | None) -> None:
        self.rate_hz = rate_hz
        self._schedule = None if rate_hz is None else SampleSchedule.of(rate_hz, 1)
        self._last = -1

    def admits(self, t_ns: int) -> bool:
        """Return whether a run is admitted now; if so, count it."""
        if self._schedule is None:
            return True
        period = self._schedule.index_at(t_ns)
        if period <= self._last:
            return False
        self._last = period
        return True

    def save(self) -> int:
        """Return the state."""
        return self._last

    def restore(self, saved: int) -> None:
        """Restore a state from :meth:`save`."""
        self._last = saved

    def reset(self) -> None:
        """Return to time 0."""
        self._last = -1
