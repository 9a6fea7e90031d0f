"""How fast simulated time passes: as fast as possible, in real time, or by a factor."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from math import isfinite

from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError

SLOWEST = 1e-4
"""The smallest pace: a second of simulated time takes almost three hours."""
_CATCH_UP_S = 0.1


class Pacing(ABC):
    """Decides when the next step may start."""

    @abstractmethod
    def start(self, now_ns: int) -> None:
        """Start pacing at a simulated time; earlier time does not count."""

    @abstractmethod
    def wait(self, now_ns: int) -> None:
        """Wait until this simulated time may be reached."""


class AsFastAsPossible(Pacing):
    """Never waits."""

    def start(self, now_ns: int) -> None: ...

    def wait(self, now_ns: int) -> None: ...


class Paced(Pacing):
    """Keeps simulated time at a factor of wall time, if the machine is fast enough.

    Delays of up to 0.1 s are caught up; longer delays are not.

    Args:
        factor: simulated seconds per second, at least :data:`SLOWEST`; 1 is real time.
        clock: returns the time, s.
        sleep: waits, s.
    """

    def __init__(
        self,
        factor: float = 1.0,
        *,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not (isfinite(factor) and factor >= SLOWEST):
            raise ExperimentError(f"the pace is a factor of at least {SLOWEST:g}, not {factor:g}")
        self.factor = factor
        self._clock, self._sleep = clock, sleep
        self.start(0)

    def start(self, now_ns: int) -> None:
        self._origin_s = self._clock() - seconds(now_ns) / self.factor

    def wait(self, now_ns: int) -> None:
        ahead_s = self._origin_s + seconds(now_ns) / self.factor - self._clock()
        if ahead_s > 0:
            self._sleep(ahead_s)
        elif ahead_s < -_CATCH_UP_S:
            self._origin_s -= ahead_s + _CATCH_UP_S


def pacing_of(text: str | float) -> Pacing:
    """Return the pacing for ``max``, ``realtime`` or a factor.

    Raises:
        ExperimentError: the value is none of these.
    """
    if text == "max":
        return AsFastAsPossible()
    if text == "realtime":
        return Paced()
    try:
        return Paced(float(text))
    except ValueError:
        raise ExperimentError(f"the pace is 'max', 'realtime' or a factor, not {text!r}") from None
