"""The problems of a run: its findings, the weightiest first, and grouped for a summary."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

from nrp_core.findings.codes import Code, Weight
from nrp_core.findings.finding import Finding, Level, headline
from nrp_core.findings.findings import merged

MARKS = {Weight.INCOMPLETE: "✗", Weight.ALTERED: "!", Weight.REMARK: "·"}
"""The sign of each weight in a text."""
MAX_LINES = 5
"""The number of lines in a summary about a run that is complete."""
_OF_MODELS = frozenset(
    {
        Code.NRP258, Code.NRP260, Code.NRP262, Code.NRP264, Code.NRP265, Code.NRP266, Code.NRP383,
        Code.NRP384,
    }
)  # fmt: skip
"""How a robot or room differs from its file."""


@dataclass(frozen=True, slots=True)
class ProblemGroup:
    """The problems of one code.

    Args:
        code: the code.
        findings: at least one.
    """

    code: Code
    findings: tuple[Finding, ...]

    @property
    def headline(self) -> str:
        """One line: the message of a single problem, else their number and kind."""
        return headline(self.findings)

    @property
    def weight(self) -> Weight:
        """The largest weight among the problems."""
        return max(finding.weight for finding in self.findings)

    @property
    def is_counted(self) -> bool:
        """Whether the headline is only a count, so that the findings have the details."""
        return sum(finding.count for finding in self.findings) > 1


def ordered(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings by weight, the weightiest first, then by place; several places of one are merged."""
    return tuple(sorted(merged(findings), key=_rank))


def is_complete(findings: Iterable[Finding]) -> bool:
    """Return whether a run with these findings has all requested parts."""
    return all(finding.weight is not Weight.INCOMPLETE for finding in findings)


def is_warning(finding: Finding) -> bool:
    """Return whether a finding warns about an experiment; notes and converted parts do not."""
    return finding.level is not Level.NOTE and finding.code is not Code.NRP255


def grouped(problems: Sequence[Finding]) -> Iterator[ProblemGroup]:
    """Yield ordered problems by code, in the order of the first problem of each."""
    for code in dict.fromkeys(problem.code for problem in problems):
        yield ProblemGroup(code, tuple(problem for problem in problems if problem.code is code))


def lines_of(
    problems: Sequence[Finding], *, details: bool = False, places: bool = False
) -> Iterator[tuple[Weight, str]]:
    """Yield a line for each code of ordered problems, with its weight; several of one code are counted.

    Without details, the problems that leave nothing out have at most ``MAX_LINES`` lines: if they are of more
    codes, those of models share a line, and then the last ones.

    Args:
        problems: the problems, as :func:`ordered` returns them.
        details: whether to yield each of several problems, and its place, as well.
        places: whether a single problem has its place without details, too.
    """
    groups = list(grouped(problems))
    for bundle in [[group] for group in groups] if details else _bundles(groups):
        group, *others = bundle
        is_placed = not group.is_counted and (details or places)
        text = str(group.findings[0].as_error()) if is_placed else group.headline
        if others:
            n = sum(finding.count for one in bundle for finding in one.findings)
            of_models = all(one.code in _OF_MODELS for one in bundle)
            text = (
                f"{n} parts, values or meshes of models are left out or replaced"
                if of_models
                else (f"{n} others of {len(bundle)} kinds")
            )
        codes = " ".join(one.code.name for one in bundle)
        yield group.weight, f"{MARKS[group.weight]} {text} [{codes}]"
        for finding in group.findings if details and group.is_counted else ():
            yield group.weight, f"    {finding.as_error()}"


def _bundles(groups: Iterable[ProblemGroup]) -> list[list[ProblemGroup]]:
    """Return the groups of each line of a summary."""
    missing: list[list[ProblemGroup]] = []
    lines: list[list[ProblemGroup]] = []
    for group in groups:
        (missing if group.weight is Weight.INCOMPLETE else lines).append([group])
    if len(lines) > MAX_LINES:
        of_models = [group for (group,) in lines if group.code in _OF_MODELS]
        lines = [line for line in lines if line[0].code not in _OF_MODELS]
        n_altered = sum(line[0].weight is Weight.ALTERED for line in lines)
        lines[n_altered:n_altered] = [of_models] if of_models else []
    if len(lines) > MAX_LINES:
        lines[MAX_LINES - 1 :] = [[group for line in lines[MAX_LINES - 1 :] for group in line]]
    return missing + lines


def without(findings: Iterable[Finding], codes: Collection[str]) -> Iterator[Finding]:
    """Yield findings without those of some codes; keep errors and causes of an incomplete run."""
    for finding in findings:
        if finding.code.name not in codes or finding.weight is Weight.INCOMPLETE:
            yield finding


def _rank(finding: Finding) -> tuple[int, str, int]:
    return -finding.weight, str(finding.path or ""), finding.line or 0
