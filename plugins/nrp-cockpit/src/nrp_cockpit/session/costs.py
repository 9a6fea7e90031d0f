"""The running time of transfer functions."""

from __future__ import annotations

from collections import defaultdict, deque
from dataclasses import dataclass

from nrp_core.cle.loop import ClosedLoop
from nrp_core.clock import seconds

RECENT = 60
"""Number of calls whose duration is shown."""


@dataclass(frozen=True, slots=True)
class Cost:
    """The running time of a function.

    Args:
        calls: number of calls.
        since_s: the simulated time since which they are counted.
        mean_ms: wall time of a call; 0 before the first.
        recent_ms: wall time of the last calls that were watched.
    """

    calls: int
    since_s: float
    mean_ms: float
    recent_ms: tuple[float, ...]


class Costs:
    """The running times of the functions of a loop since the last change of its time.

    The loop counts all calls. The time of a single call is known only if :meth:`watch` is called after it.

    Args:
        loop: the loop.
    """

    def __init__(self, loop: ClosedLoop) -> None:
        self._loop = loop
        self.reset()

    def reset(self) -> None:
        """Delete the measurements."""
        account, self._since_s = self._loop.account, seconds(self._loop.now_ns)
        self._calls_before, self._before_ns = dict(account.function_calls), dict(account.function_ns)
        self._calls_seen, self._seen_ns = dict(self._calls_before), dict(self._before_ns)
        self._recent_ms: dict[str, deque[float]] = defaultdict(lambda: deque(maxlen=RECENT))

    def watch(self) -> None:
        """Note the time of the calls of a step."""
        account = self._loop.account
        for name, calls in account.function_calls.items():
            added = calls - self._calls_seen.get(name, 0)
            if added:
                spent_ns = account.function_ns[name]
                if added == 1:  # else no client was connected for a while
                    self._recent_ms[name].append((spent_ns - self._seen_ns.get(name, 0)) / 1e6)
                self._calls_seen[name], self._seen_ns[name] = calls, spent_ns

    def of(self, name: str) -> Cost:
        """Return the running time of a function by its name."""
        account = self._loop.account
        calls = account.function_calls.get(name, 0) - self._calls_before.get(name, 0)
        spent_ns = account.function_ns.get(name, 0) - self._before_ns.get(name, 0)
        mean_ms = spent_ns / calls / 1e6 if calls else 0.0
        return Cost(calls, self._since_s, mean_ms, tuple(self._recent_ms[name]))
