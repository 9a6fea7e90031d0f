"""All findings about a run: from before it, from its engines, about failures, and from its observers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from nrp_core.cle.engine import Failure
from nrp_core.clock import seconds
from nrp_core.errors import RecordingError, SimulationError, TransferFunctionRaisedError
from nrp_core.experiment.running.judgement import FAILED, FINISHED, INTERRUPTED, interruption
from nrp_core.findings import Code, Finding, Findings, Level
from nrp_core.findings.problems import ordered

Reporter = Callable[[], Iterable[Finding]]
"""Returns findings about a run."""


def problems_of(
    found: Iterable[Finding],
    engines: Iterable[Finding | str],
    ends: Iterable[Finding],
    reporters: Iterable[Reporter],
) -> tuple[Finding, ...]:
    """Return the findings about a run so far, each once, by weight, then by place.

    Args:
        found: findings before the run.
        engines: reports of the engines, which often repeat those before the run, without a place.
        ends: errors that stopped functions or the run; see :func:`ends_of`.
        reporters: other sources of findings.
    """
    all_found = Findings(found)
    known = {(finding.code, finding.message) for finding in all_found}
    all_found += [report for report in Findings(engines) if (report.code, report.message) not in known]
    all_found += ends
    for reporter in reporters:
        all_found += reporter()
    return ordered(all_found)


def not_failed(found: Iterable[Finding], failures: Iterable[Failure]) -> Iterator[Finding]:
    """Yield the findings before a run, except doubts about a line that raised an error."""
    failed = {(failure.path, failure.line) for failure in failures}
    for finding in found:
        if (finding.path, finding.line) not in failed:
            yield finding


def state_of(error: BaseException | None) -> str:
    """Return the final state of a run, given the error that ended it."""
    if error is None:
        return FINISHED
    return FAILED if isinstance(error, Exception) else INTERRUPTED


def ends_of(failures: Iterable[Failure], error: BaseException | None, now_s: float) -> Iterator[Finding]:
    """Yield a finding for each function that was stopped by an error, and for the end of a run by an error.

    Args:
        failures: the failures of functions.
        error: the error that ended the run, if any; the failure of a function may be its cause.
        now_s: the simulated time reached, s.
    """
    cause = None if error is None else error.__cause__
    for failure in failures:
        if failure.error is not cause:
            yield _quarantine(failure)
    if error is not None:
        yield _end(error, now_s)


def _quarantine(failure: Failure) -> Finding:
    message = (
        f"the transfer function '{failure.function}' {failure.reason} at {seconds(failure.t_ns):g} s and was "
        "not called any more"
    )
    return Finding(
        Code.NRP274, message, Level.WARNING, Path(failure.path), failure.line, subject=failure.function
    )


def _end(error: BaseException, now_s: float) -> Finding:
    if state_of(error) == INTERRUPTED:
        return interruption("interrupted at", now_s)
    by_engine = isinstance(error, SimulationError) and not isinstance(
        error, (TransferFunctionRaisedError, RecordingError)
    )
    text = next(iter(str(error).splitlines()), type(error).__name__)
    return Finding(Code.NRP275 if by_engine else Code.NRP276, text, Level.WARNING)
