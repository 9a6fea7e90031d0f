"""The judgement of a run, the same in every summary: whether it is complete, passed, and its problems.

``passed`` is True only if the run is complete, has criteria and meets them all. It is False if a criterion is
not met or an error ended the run. Otherwise it is None: it has no criteria, some are still open,
or a requested part is missing from the run.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from nrp_core.findings import Code, Finding, Level, Weight
from nrp_core.findings.problems import ProblemGroup, grouped, is_complete, lines_of, ordered

FINISHED, FAILED, INTERRUPTED, RUNNING = "finished", "failed", "interrupted", "running"
"""The states of a run; a recording that still says ``running`` was killed."""


def passed_of(state: str, complete: bool, criteria: Iterable[bool | None]) -> bool | None:
    """Return whether a run passed.

    Args:
        state: how it ended.
        complete: whether all requested parts were there.
        criteria: the outcome of each criterion.
    """
    outcomes = list(criteria)
    if state == FAILED or False in outcomes:
        return False
    return True if complete and outcomes and None not in outcomes else None


@dataclass(frozen=True, slots=True)
class Judgement:
    """The judgement of a run.

    Args:
        state: how it ended.
        problems: the problems by weight, then by place.
        criteria: the outcome of each criterion.
        reached_s: simulated time that was reached, s.
        duration_s: simulated time of the whole experiment, s; None: not known.
    """

    state: str
    problems: tuple[Finding, ...]
    criteria: Mapping[str, bool | None]
    reached_s: float
    duration_s: float | None = None

    @property
    def complete(self) -> bool:
        """Whether the run had all requested parts."""
        return is_complete(self.problems)

    @property
    def passed(self) -> bool | None:
        """Whether the run passed; see the module."""
        return passed_of(self.state, self.complete, self.criteria.values())

    @property
    def covers_all(self) -> bool:
        """Whether the run reached the end of the experiment, as far as known."""
        return self.state == FINISHED and (self.duration_s is None or self.reached_s >= self.duration_s)

    @property
    def headline(self) -> str:
        """The judgement in one line."""
        return f"{self._verdict}{self._span}"

    @property
    def groups(self) -> list[ProblemGroup]:
        """The problems by code, the weightiest first."""
        return list(grouped(self.problems))

    def lines(self, *, details: bool = False) -> Iterator[tuple[Weight, str]]:
        """Yield the problems with their weight; several with the same code are counted.

        Args:
            details: whether to yield each of several problems, and its place, as well.
        """
        yield from lines_of(self.problems, details=details)

    @property
    def _verdict(self) -> str:
        if self.state == RUNNING:
            return f"killed or still running at {self.reached_s:g} s"
        if self.state != FINISHED:
            return f"{self.state} at {self.reached_s:g} s"
        failed = sum(passed is False for passed in self.criteria.values())
        if failed:
            return f"failed: {'a criterion is' if failed == 1 else f'{failed} criteria are'} not met"
        if not self.complete:
            return "not complete: something that the experiment asks for is missing from the run"
        if not self.criteria:
            return "done"
        return "passed" if self.passed else "not decided: the run ended early"

    @property
    def _span(self) -> str:
        """The part of the experiment that was judged, if not all of it."""
        if self.covers_all or self.state != FINISHED:
            return ""
        if not self.criteria:
            return f" ({self.reached_s:g} s of {self.duration_s:g} s)"
        outcomes = list(self.criteria.values())
        counts = {"met": outcomes.count(True), "not met": outcomes.count(False), "open": outcomes.count(None)}
        text = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
        return f" (criteria judged up to {self.reached_s:g} s of {self.duration_s:g} s: {text})"


def recorded_judgement(run: Mapping[str, Any], reached_s: float) -> Judgement | None:
    """Return the judgement of a recorded run; None for a bare file without a description of its run.

    Args:
        run: the contents of ``run.json``.
        reached_s: simulated time of the last recorded step, s.
    """
    if not run:
        return None
    result = dict(run.get("result") or {})
    state = str(run.get("state") or RUNNING) if result else RUNNING
    criteria = {name: outcome["passed"] for name, outcome in dict(result.get("criteria") or {}).items()}
    problems = _recorded_problems(result, state, reached_s)
    reached_s = result.get("sim_time_s", reached_s)
    return Judgement(state, problems, criteria, reached_s, result.get("duration_s"))


def _recorded_problems(result: Mapping[str, Any], state: str, reached_s: float) -> tuple[Finding, ...]:
    """Return the problems of a recorded result; before version 0.2 results had texts and failures."""
    if "problems" in result:
        found = [Finding.from_dict(problem) for problem in result["problems"]]
        if state == INTERRUPTED and is_complete(found):  # the run continued, its recording did not
            found.append(interruption("recorded only in part, up to", reached_s))
        if state == FAILED and is_complete(found):  # the error came from outside of the run
            found.append(_ended_by(result))
        return ordered(found)
    found = [Finding(Code.NRP278, str(text), Level.WARNING) for text in result.get("warnings", ())]
    for failure in result.get("failures", ()) if state == FINISHED else ():
        message = f"the transfer function '{failure['function']}' raised {failure['error']}"
        found.append(Finding(Code.NRP274, message, Level.WARNING, line=failure["line"]))
    if state == FAILED:
        found.append(_ended_by(result))
    if state in (INTERRUPTED, RUNNING):
        found.append(interruption("killed at" if state == RUNNING else "interrupted at", reached_s))
    return ordered(found)


def _ended_by(result: Mapping[str, Any]) -> Finding:
    return Finding(Code.NRP276, str(result.get("error") or "an error ended the run"), Level.WARNING)


def interruption(how: str, t_s: float) -> Finding:
    """Return the finding about a run that was interrupted or killed."""
    return Finding(Code.NRP294, f"the run was {how} {t_s:g} s", Level.WARNING)
