"""The report of a run of the kit, as data, as JSON and as text."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

LEVELS = ("contract", "capability", "accuracy", "sequences", "statistical", "cross", "speed")
"""The levels of tests, in the order of the report."""

_CAUSE = re.compile(r"\AE +(?! |assert|AssertionError)(.+)$")
"""pytest's line for an error that is not an assertion: errors with one text count as one fault."""


class Outcome(StrEnum):
    """The outcome of a test."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"
    EXPECTED_TO_FAIL = "expected to fail"


@dataclass(frozen=True, slots=True)
class KitResult:
    """The result of one test.

    Args:
        test: its name, a sentence; parameters in brackets.
        level: its level, such as ``contract``.
        outcome: its outcome.
        reason: the reason for a skip, or the text of the failure.
        seconds: its duration, s.
        measured: its measurements, by names that end in a unit.
    """

    test: str
    level: str
    outcome: Outcome
    reason: str = ""
    seconds: float = 0.0
    measured: Mapping[str, Any] = field(default_factory=dict)

    @property
    def sentence(self) -> str:
        """The name, with spaces, for people."""
        name, bracket, parameters = self.test.partition("[")
        return name.removeprefix("test_").replace("_", " ") + (f" [{parameters}" if bracket else "")


@dataclass(frozen=True, slots=True)
class KitReport:
    """The report of a run.

    Args:
        kind: ``brain`` or ``world``.
        name: entry-point name of the backend.
        provider: distribution, version and target.
        options: the options, as given.
        level: the level of the suite.
        capabilities: the capabilities that the backend declares.
        machine: the machine of the run.
        results: one result for each test.
        scene: the file of the scene, for a world that has its own.
    """

    kind: str
    name: str
    provider: Mapping[str, str]
    options: Mapping[str, Any]
    level: str
    capabilities: Mapping[str, Any]
    machine: Mapping[str, Any]
    results: list[KitResult]
    scene: str = ""

    @property
    def conforms(self) -> bool:
        """Whether at least one test ran and none failed."""
        return bool(self.results) and not any(result.outcome is Outcome.FAILED for result in self.results)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, with counts."""
        from nrp_core.utilities import to_jsonable

        counts = Counter(str(result.outcome) for result in self.results)
        data = to_jsonable({**asdict(self), "conforms": self.conforms, "counts": dict(counts)})
        assert isinstance(data, dict)
        return data


def lines(report: Mapping[str, Any]) -> Iterator[str]:
    """Return a report from :meth:`Report.to_dict` as text for people."""
    results = [KitResult(**{**result, "outcome": Outcome(result["outcome"])}) for result in report["results"]]
    seen: set[str] = set()
    for level in LEVELS:
        chosen = [result for result in results if result.level == level]
        yield from [level] if chosen else []
        for result in chosen:
            yield from _about(result, again=_cause(result) in seen)
            seen |= {_cause(result)} - {""}
    yield from _shared_causes(results)
    detail = ", ".join(f"{count} {outcome}" for outcome, count in report["counts"].items())
    verdict = "conforms" if report["conforms"] else "does not conform"
    seconds = sum(result.seconds for result in results)
    yield f"{report['kind']} {report['name']} {verdict}: {detail or 'no tests'} in {seconds:.0f} s"


def _shared_causes(results: Sequence[KitResult]) -> Iterator[str]:
    """List the errors that made several tests fail, which are to be repaired first."""
    causes = Counter(filter(None, map(_cause, results)))
    for cause, count in causes.most_common():
        if count > 1:
            yield f"{count} failed with the same error: {cause}"


def _cause(result: KitResult) -> str:
    """Return the first error of a failure, or an empty text if it is an assertion."""
    errors = [line for line in result.reason.splitlines() if line.startswith("E ")]
    found = _CAUSE.match(errors[0]) if errors and result.outcome is Outcome.FAILED else None
    return found[1] if found else ""


def _about(result: KitResult, *, again: bool) -> Iterator[str]:
    marks = {Outcome.PASSED: "✓", Outcome.FAILED: "✗", Outcome.SKIPPED: "-"}
    measured = ", ".join(f"{name} {value:.3g}" for name, value in result.measured.items())
    detail = measured if result.outcome is Outcome.PASSED else result.reason.partition("\n")[0]
    failed = result.outcome is Outcome.FAILED
    if failed:
        detail = "with the same error as above" if again else ""
    yield f"  {marks.get(result.outcome, '~')} {result.sentence}" + (f"  ({detail})" if detail else "")
    if failed and not again:
        yield from (f"      {line}" for line in result.reason.splitlines())
