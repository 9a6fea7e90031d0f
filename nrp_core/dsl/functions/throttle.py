"""How often a transfer function runs at most."""

from __future__ import annotations

from nrp_core.clock import SampleSchedule


class Throttle:
    """Admits one run for each period of a rate, the first at once.

    The periods are counted from time 0 in rational arithmetic, so the mean rate is exact although
    the steps need not divide it: 30 Hz at steps of 20 ms gives gaps of 40, 40 and 20 ms.

    Args:
        rate_hz: runs a second, positive; None: no limit.
    """

    def __init__(self, rate_hz: float | None) -> None:
        self.rate_hz = rate_hz
        self._schedule = None if rate_hz is None else SampleSchedule.of(rate_hz, 1)
        self._last = -1

    def admits(self, t_ns: int) -> bool:
        """Whether there may be a run now; if so, it counts."""
        if self._schedule is None:
            return True
        period = self._schedule.index_at(t_ns)
        if period <= self._last:
            return False
        self._last = period
        return True

    def save(self) -> int:
        """Return what changes while running."""
        return self._last

    def restore(self, saved: int) -> None:
        """Return to what :meth:`save` gave."""
        self._last = saved

    def reset(self) -> None:
        """Start anew at time 0."""
        self._last = -1
