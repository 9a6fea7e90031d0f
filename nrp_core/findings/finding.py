"""What a check of an experiment finds: one thing wrong, where, and what would be right."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from nrp_core.errors import ExperimentError
from nrp_core.findings.codes import Code as Code  # part of what a finding is


class Level(StrEnum):
    """How bad a finding is."""

    ERROR = "error"
    """The experiment cannot run."""
    WARNING = "warning"
    """It runs, but probably not as meant."""
    NOTE = "note"
    """Worth knowing."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding.

    Args:
        code: its kind.
        message: what is wrong and what would be valid.
        level: how bad it is.
        path, line, column: where it stands (1-based), as far as known.
    """

    code: Code
    message: str
    level: Level = Level.ERROR
    path: Path | None = None
    line: int | None = None
    column: int | None = None

    @classmethod
    def of(cls, error: ExperimentError, code: Code) -> Finding:
        """Turn an error into a finding at the same place."""
        return cls(code, error.message, Level.ERROR, error.path, error.line, error.column)

    def as_error(self) -> ExperimentError:
        """Return the finding as an error."""
        return ExperimentError(self.message, path=self.path, line=self.line, column=self.column)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON, with why it matters and what to do."""
        path = None if self.path is None else str(self.path)
        return {
            **asdict(self), "code": self.code.name, "level": str(self.level), "path": path,
            "why": self.code.why, "suggestion": self.code.suggestion,
        }  # fmt: skip

    def __str__(self) -> str:
        return f"{self.as_error()} [{self.code.name}]"


class InvalidExperimentError(ExperimentError):
    """An experiment in which several things may be wrong; reads as the first of them.

    Args:
        findings: all that was found, in the order of the file; at least one error.
    """

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings = tuple(findings)
        first = next(finding for finding in self.findings if finding.level is Level.ERROR)
        super().__init__(first.message, path=first.path, line=first.line, column=first.column)

    def __reduce__(self) -> tuple[type[InvalidExperimentError], tuple[tuple[Finding, ...]]]:
        """Let it reach whoever waits for it in another process."""
        return type(self), (self.findings,)


def has_errors(findings: Iterable[Finding]) -> bool:
    """Return whether any finding keeps the experiment from running."""
    return any(finding.level is Level.ERROR for finding in findings)
