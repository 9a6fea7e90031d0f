"""The running time of transfer functions."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

RECENT = 60
"""Number of calls whose duration is shown."""


@dataclass(slots=True)
class Cost:
    """The running time of a function since the last change of the run's time.

    Args:
        calls: number of calls.
        total_ms: wall time of all calls.
        recent_ms: wall time of the last calls.
    """

    calls: int = 0
    total_ms: float = 0.0
    recent_ms: deque[float] = field(default_factory=lambda: deque(maxlen=RECENT))

    def add(self, ms: float) -> None:
        """Count a call."""
        self.calls += 1
        self.total_ms += ms
        self.recent_ms.append(ms)

    @property
    def mean_ms(self) -> float:
        """Wall time of a call; 0 before the first."""
        return self.total_ms / self.calls if self.calls else 0.0
