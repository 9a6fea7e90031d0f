"""A signal for viewers, who do not see each of its values."""

from __future__ import annotations

from nrp_core.recording.writing.signals import PERIOD_NS, Add, Signal


class Rarely(Signal):
    """Another signal, taken as often as the poses of links.

    Args:
        signal: the signal.
    """

    def __init__(self, signal: Signal) -> None:
        self._signal, self._due_ns = signal, 0

    def take(self, now_ns: int, add: Add) -> None:
        if now_ns >= self._due_ns:
            self._due_ns = (now_ns // PERIOD_NS + 1) * PERIOD_NS
            self._signal.take(now_ns, add)

    def close(self) -> None:
        self._signal.close()
