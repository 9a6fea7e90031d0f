"""The wall time spent by each part of a step."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field


@dataclass(slots=True)
class TimeAccount:
    """Wall time spent since the last reset, ns; pacing and compilation are not counted.

    Attributes:
        brain_ns: advancing the brain.
        world_ns: advancing the world.
        both_ns: advancing both; less than the sum of the two where they ran at once.
        function_ns: running each transfer function, by name.
        function_calls: how often each transfer function ran, by name.
        total_ns: all steps as a whole; a step is added when it ends.
    """

    brain_ns: int = 0
    world_ns: int = 0
    both_ns: int = 0
    function_ns: defaultdict[str, int] = field(default_factory=lambda: defaultdict(int))
    function_calls: defaultdict[str, int] = field(default_factory=lambda: defaultdict(int))
    total_ns: int = 0

    @property
    def functions_ns(self) -> int:
        """All transfer functions together."""
        return sum(self.function_ns.values())

    @property
    def engine_ns(self) -> int:
        """The loop itself, hooks included; 0 while the first step is under way."""
        return max(0, self.total_ns - self.both_ns - self.functions_ns)

    def shares(self) -> dict[str, float]:
        """Return the share of each part; the shares add up to 1 (all are 0 before the first step)."""
        work = {
            "brain": self.brain_ns,
            "world": self.world_ns,
            "transfer_functions": self.functions_ns,
            "engine": self.engine_ns,
        }
        total = sum(work.values()) or 1
        return {name: spent / total for name, spent in work.items()}
