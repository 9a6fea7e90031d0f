"""A finding: a mistake or a remark, its place, and the remedy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from nrp_core.errors import ArgumentError, ExperimentError, Instead
from nrp_core.findings.codes import Code, Weight
from nrp_core.findings.removed_codes import MERGED


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
        message: the mistake, and the valid alternatives.
        level: how bad it is.
        path, line, column: its place (1-based), as far as known.
        subject: the name of the object concerned, such as a link, topic, mesh file or function, if any.
        count: the number of places; ``path`` and ``line`` are the first of them.
        instead: a name in the line, and its replacement, if that corrects the mistake.

    Raises:
        ArgumentError: the code is not a member of :class:`~nrp_core.Code`.
    """

    code: Code
    message: str
    level: Level = Level.ERROR
    path: Path | None = None
    line: int | None = None
    column: int | None = None
    subject: str | None = None
    count: int = 1
    instead: Instead | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.code, Code):
            name = self.code if self.code in Code.__members__ else Code.NRP278.name
            raise ArgumentError(
                f"the code of a finding is a member of nrp_core.Code, not {self.code!r}: use Code.{name}"
            )

    @property
    def weight(self) -> Weight:
        """The effect on a run: an error keeps it from starting, a warning has the weight of its code."""
        if self.level is Level.WARNING:
            return self.code.weight
        return Weight.INCOMPLETE if self.level is Level.ERROR else Weight.REMARK

    @property
    def text(self) -> str:
        """The message, and the number of further places."""
        return self.message if self.count == 1 else f"{self.message} (and {self.count - 1} more)"

    @classmethod
    def of(cls, error: ExperimentError, code: Code) -> Finding:
        """Turn an error into a finding at the same place."""
        where = error.path, error.line, error.column
        return cls(code, error.message, Level.ERROR, *where, error.subject, instead=error.instead)

    def as_error(self) -> ExperimentError:
        """Return the finding as an error."""
        return ExperimentError(
            self.text, path=self.path, line=self.line, column=self.column, subject=self.subject,
            instead=self.instead,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON, with its consequence and the remedy."""
        path = None if self.path is None else str(self.path)
        return {
            **asdict(self), "code": self.code.name, "level": str(self.level), "path": path,
            "weight": str(self.weight), "why": self.code.why, "suggestion": self.code.suggestion,
            "instead": None if self.instead is None else self.instead._asdict(),
        }  # fmt: skip

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Finding:
        """Return the finding that :meth:`to_dict` gave; a code of another version becomes a general one."""
        code = Code.__members__.get(MERGED.get(data["code"], data["code"]), Code.NRP278)
        path, instead = None if data["path"] is None else Path(data["path"]), data.get("instead")
        return cls(
            code, data["message"], Level(data["level"]), path, data["line"], data["column"],
            data.get("subject"), data.get("count", 1), Instead(**instead) if instead else None,
        )  # fmt: skip

    def __str__(self) -> str:
        return f"{self.as_error()} [{self.code.name}]"


def headline(findings: Sequence[Finding]) -> str:
    """Return one line for findings of one code: the message of a single one, else their number and kind."""
    n = sum(finding.count for finding in findings)
    return findings[0].message if n == 1 else findings[0].code.counted(n)


class InvalidExperimentError(ExperimentError):
    """An experiment with one or more mistakes; its text is that of the first.

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
