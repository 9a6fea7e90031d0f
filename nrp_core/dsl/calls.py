"""When a transfer function is called: once a step, or once for each message, at most at a rate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final, Literal, NamedTuple

from nrp_core.clock import SampleSchedule
from nrp_core.dsl.parameters import SubscribedTopic

Calls = Literal["once", "each"]
"""Whether the messages of a step trigger one call, or one call for each."""


class Call(NamedTuple):
    """A call of a function that is due in a step.

    Args:
        t_ns: the time of the message for which the function is called; None: the time of the step.
        messages: for each triggering topic, the number of messages that came since the previous call.
    """

    t_ns: int | None = None
    messages: tuple[int, ...] = ()


ONCE: Final = (Call(),)


def calls_for_messages(topics: Sequence[SubscribedTopic], admits: Callable[[int], bool]) -> Iterator[Call]:
    """Yield a call for each message that came on triggering topics, in the order of their times.

    Of messages with equal times, those of the first topic come first. Messages that a throttling rate does
    not admit belong to the next call.

    Args:
        topics: the topics.
        admits: whether a call at a time (ns) is admitted.
    """
    came = sorted((one.t_ns, i) for i, topic in enumerate(topics) for one in topic.untaken)
    counts = [0] * len(topics)
    for t_ns, i in came:
        counts[i] += 1
        if admits(t_ns):
            yield Call(t_ns, tuple(counts))
            counts = [0] * len(topics)


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
        self._last = -1.0

    def admits(self, t_ns: int, t: float | None = None) -> bool:
        """Return whether a run is admitted now; if so, count it.

        Args:
            t_ns: the time, ns.
            t: the time that is passed to the function, s, which subclasses may compare instead.
        """
        if self._schedule is None:
            return True
        period = self._schedule.index_at(t_ns)
        if period <= self._last:
            return False
        self._last = period
        return True

    def save(self) -> float:
        """Return the state."""
        return self._last

    def restore(self, saved: float) -> None:
        """Restore a state from :meth:`save`."""
        self._last = saved

    def reset(self) -> None:
        """Return to time 0."""
        self._last = -1.0
