"""The outcome of a replay."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from nrp_core.findings import Findings
from nrp_core.recording.reading.check import Flaw
from nrp_core.recording.reading.steps import Difference


class Verdict(StrEnum):
    """Whether a run was the same again."""

    IDENTICAL = "identical"
    """All that was recorded was compared, and was the same."""
    SAME = "the same"
    """A part of it was compared, and was the same."""
    DIFFERENT = "differs"
    """Something was not the same."""
    UNPROVED = "not identical"
    """Nothing was compared, or the recording is not as it was written."""


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """The result of a replay.

    Args:
        steps: how many steps were compared.
        difference: the first one, if any.
        from_ns, until_ns: the time that was run and compared.
        flaws: the files of the recording that are not as they were written.
        not_compared: which parts of the recording were not compared, in words.
        error: the error that ended the run early, as it may have ended the recorded one.
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
        """Whether everything was the same."""
        if self.difference is not None:
            return Verdict.DIFFERENT
        if self.flaws or not self.steps:
            return Verdict.UNPROVED
        return Verdict.SAME if self.not_compared else Verdict.IDENTICAL

    @property
    def identical(self) -> bool:
        """Whether all that was recorded was compared, and was the same."""
        return self.verdict is Verdict.IDENTICAL
