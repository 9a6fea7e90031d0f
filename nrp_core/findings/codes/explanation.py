"""The explanation that every code of a finding carries."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Weight(IntEnum):
    """The effect of a finding on a run, from the smallest to the largest; ordered."""

    REMARK = 1
    """The run is as requested; the finding is worth knowing."""
    ALTERED = 2
    """The run is complete, but something in it differs from the request."""
    INCOMPLETE = 3
    """Something that was requested is missing from the run, or the run ended early."""

    def __str__(self) -> str:
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Explanation:
    """The explanation of a code.

    Args:
        summary: the mistake, in one sentence.
        why: the consequence.
        suggestion: how to fix it.
        counted: the headline of several findings; ``{n}`` stands for their number.
        weight: the effect of a warning on a run; an error keeps the run from starting.
    """

    summary: str
    why: str
    suggestion: str
    counted: str
    weight: Weight
