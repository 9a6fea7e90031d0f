"""What a check of an experiment finds: one thing wrong, where, and what would be right.

A code never changes its meaning, so that people can look it up and scripts can rely on it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from enum import Enum, StrEnum
from pathlib import Path
from typing import Any

from nrp_core.errors import ExperimentError


class Level(StrEnum):
    """How bad a finding is."""

    ERROR = "error"
    """The experiment cannot run."""
    WARNING = "warning"
    """It runs, but probably not as meant."""
    NOTE = "note"
    """Worth knowing."""


class Code(Enum):
    """Every kind of finding about an experiment file; the value says what it means."""

    NRP200 = "The file is not YAML, or not text."
    NRP201 = "A key that the format does not have."
    NRP202 = "A value of the wrong kind, or out of range."
    NRP203 = "A key that is needed is missing."
    NRP204 = "A file that does not exist."
    NRP205 = "A backend that is not installed or does not load."
    NRP206 = "A backend option that is unknown or wrong."
    NRP207 = "Time steps that do not divide each other."
    NRP208 = "The brain script cannot be turned into a network."
    NRP209 = "A robot or room cannot be read."
    NRP210 = "A transfer function is written wrongly."
    NRP211 = "Neurons that the network does not have."
    NRP212 = "A topic that does not exist, or has another type or direction."
    NRP213 = "An event or criterion refers to something that does not exist."
    NRP214 = "The experiment that this one extends cannot be read."
    NRP215 = "An override that cannot be applied."
    NRP216 = "The backend does not have what the experiment asks."


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
        """Return it as plain data for JSON."""
        path = None if self.path is None else str(self.path)
        return {**asdict(self), "code": self.code.name, "level": str(self.level), "path": path}

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


def has_errors(findings: Iterable[Finding]) -> bool:
    """Return whether any finding keeps the experiment from running."""
    return any(finding.level is Level.ERROR for finding in findings)
