"""Findings collected one by one, each kept once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import overload

from nrp_core.findings.codes import Code
from nrp_core.findings.finding import Finding, Level


class Findings(Sequence[Finding]):
    """Findings in the order in which they were added; equal ones are kept once.

    Args:
        reported: the first findings; a text becomes a finding of ``general``.
        general: the code of texts.
    """

    def __init__(self, reported: Iterable[Finding | str] = (), *, general: Code = Code.NRP278) -> None:
        self._general = general
        self._findings: dict[Finding, None] = {}
        self.extend(reported)

    def add(
        self,
        code: Code,
        message: str,
        *,
        subject: str | None = None,
        path: Path | None = None,
        line: int | None = None,
        level: Level = Level.WARNING,
    ) -> bool:
        """Add a finding.

        Args:
            code: its kind.
            message: the mistake, and the valid alternatives.
            subject: the object concerned, such as a topic or a population.
            path: its file, if any.
            line: the line there (1-based).
            level: how bad it is.

        Returns:
            whether it is new.

        Raises:
            ArgumentError: the code does not exist.
        """
        n_before = len(self)
        self.append(Finding(code, message, level, path, line, subject=subject))
        return len(self) > n_before

    def append(self, reported: Finding | str) -> None:
        """Add a finding, or a text."""
        if isinstance(reported, str):
            reported = Finding(self._general, reported, Level.WARNING)
        self._findings.setdefault(reported)

    def extend(self, reported: Iterable[Finding | str]) -> None:
        """Add several findings or texts."""
        for one in tuple(reported):
            self.append(one)

    def __iadd__(self, reported: Iterable[Finding | str]) -> Findings:
        self.extend(reported)
        return self

    def clear(self) -> None:
        """Remove all findings."""
        self._findings.clear()

    def of(self, code: Code) -> list[Finding]:
        """Return the findings of a code."""
        return [finding for finding in self if finding.code is code]

    @property
    def messages(self) -> list[str]:
        """The messages alone."""
        return [finding.message for finding in self]

    def __eq__(self, other: object) -> bool:
        return list(self) == list(other) if isinstance(other, Sequence) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # findings are added

    def __contains__(self, reported: object) -> bool:
        """Return whether a finding was added, or one with this message."""
        if isinstance(reported, str):
            return any(finding.message == reported for finding in self)
        return reported in self._findings

    @overload
    def __getitem__(self, index: int) -> Finding: ...

    @overload
    def __getitem__(self, index: slice) -> list[Finding]: ...

    def __getitem__(self, index: int | slice) -> Finding | list[Finding]:
        return list(self._findings)[index]

    def __len__(self) -> int:
        return len(self._findings)

    def __repr__(self) -> str:
        return f"Findings({list(self)})"


def merged(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the findings with those that differ only in place merged into the first of them."""
    first: dict[Finding, Finding] = {}
    for finding in findings:
        key = replace(finding, path=None, line=None, column=None, count=1)
        known = first.get(key)
        first[key] = finding if known is None else replace(known, count=known.count + finding.count)
    return tuple(first.values())
