"""The outcome of a replay."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from nrp_core.findings import Findings
from nrp_core.recording.reading.check import Flaw
from nrp_core.recording.reading.steps import Difference


class Verdict(StrEnum):
    """Whether a replay equals its recording."""

    IDENTICAL = "identical"
    """Everything that was recorded was compared, and is equal."""
    SAME = "the same"
    """A part of it was compared, and is equal."""
    DIFFERENT = "differs"
    """Something differs."""
    UNPROVED = "not identical"
    """Nothing was compared, or the recording is damaged."""


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """The result of a replay.

    Args:
        steps: the number of steps that were compared.
        difference: the first one, if any.
        from_ns, until_ns: the period that was compared; the run may have continued.
        flaws: the damaged files of the recording.
        not_compared: the parts of the recording that were not compared, as texts.
        error: the error that ended the run early; it may have ended the recorded run, too.
        warnings: possible reasons for a difference.
    """

    steps: int
    difference: Difference | None
    from_ns: int
    until_ns: int
    flaws: tuple[Flaw, ...] = ()
    not_compared: tuple[str, ...] = ()
    error: str | None = None
    warnings: Findings = field(default_factory=Findings)

    @property
    def verdict(self) -> Verdict:
        """Whether everything is equal."""
        if self.difference is not None:
            return Verdict.DIFFERENT
        if self.flaws or not self.steps:
            return Verdict.UNPROVED
        return Verdict.SAME if self.not_compared else Verdict.IDENTICAL

    @property
    def identical(self) -> bool:
        """Whether everything that was recorded was compared, and is equal."""
        return self.verdict is Verdict.IDENTICAL
