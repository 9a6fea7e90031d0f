"""Findings, events, criteria and functions as data for the page."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Mapping
from typing import Any

from nrp_cockpit.session.costs import Cost
from nrp_core.cle.loop import Failure
from nrp_core.clock import seconds
from nrp_core.dsl import TransferFunction
from nrp_core.experiment import Criterion, Event, Experiment, Run, Verdict
from nrp_core.findings import Finding, Level, Weight
from nrp_core.observables import topic_of

_OPEN = Verdict(None, None, None, None, None, "not decided")


def finding_data(finding: Finding) -> dict[str, Any]:
    """Return a finding."""
    return {
        "code": finding.code.name,
        "weight": _weight(finding),
        "summary": finding.text,
        "why": finding.code.why,
        "fix": finding.code.suggestion,
        "file": None if finding.path is None else str(finding.path),
        "line": finding.line,
        "column": finding.column,
        "count": finding.count,
        "instead": None if finding.instead is None else finding.instead._asdict(),
    }


def _weight(finding: Finding) -> str:
    if finding.level is Level.ERROR or finding.weight is Weight.INCOMPLETE:
        return "error"
    return "note" if finding.weight is Weight.REMARK else "warning"


def function_data(function: TransferFunction, run: Run, cost: Cost) -> dict[str, Any]:
    """Return a transfer function, its cost, and why it does not run."""
    failed = {failure.function: failure for failure in run.loop.failures}
    failure = failed.get(function.name)
    stops = failure is not None and run.error is not None and run.error.__cause__ is failure.error
    if function.active and not stops:
        failure = None  # it was activated again
    return {
        "name": function.name,
        "file": str(function.place.path),
        "line": function.place.line,
        "flow": function.flow.value,
        "active": function.active,
        "failure": None if failure is None else failure_data(failure) | {"stops": stops},
        "calls": cost.calls,
        "since_s": cost.since_s,
        "mean_ms": cost.mean_ms,
        "recent_ms": [round(each, 4) for each in cost.recent_ms],
    }


def failure_data(failure: Failure) -> dict[str, Any]:
    """Return the failure of a function."""
    lines = traceback.format_exception(failure.error)
    return {"t_s": seconds(failure.t_ns), "message": str(failure), "traceback": "".join(lines)}


def timeline_data(
    experiment: Experiment,
    events: Mapping[str, float | None],
    criteria: Mapping[str, Verdict],
    failures: Iterable[Mapping[str, Any]],
    past: Mapping[str, Any],
) -> dict[str, Any]:
    """Return past and future events, interventions during the run, criteria, failures and snapshots.

    Args:
        experiment: with its events, interventions and criteria.
        events: the time of each, s; None if it has not happened.
        criteria: the verdict on each, as far as known.
        failures: of functions, in the form of a result.
        past: snapshots, the times of automatic ones, and changes from outside, as data.
    """
    duration_s = seconds(experiment.duration)
    return {
        "duration_s": duration_s,
        "events": [
            {"name": name, "t_s": events.get(name), "waits_for": _waits_for(event)}
            for name, event in experiment.events.items()
        ],
        "interventions": [
            {"name": one.name, "t_s": seconds(one.at)}
            for one in experiment.brain.interventions
            if 0 < one.at < experiment.duration
        ],
        "criteria": [
            criterion_data(name, criterion, criteria.get(name, _OPEN), events, duration_s)
            for name, criterion in experiment.criteria.items()
        ],
        "failures": [
            {"t_s": failure["t_s"], "function": failure["function"], "message": failure["error"]}
            for failure in failures
        ],
        **past,
    }


def criterion_data(
    name: str, criterion: Criterion, verdict: Verdict, events: Mapping[str, float | None], duration_s: float
) -> dict[str, Any]:
    """Return a criterion, the time in which it applies as far as known, and the verdict."""
    from_s, to_s = 0.0, duration_s
    if criterion.within_of is not None:
        from_s = events.get(criterion.within_of.event) or 0.0
        to_s = min(duration_s, from_s + seconds(criterion.within_of.time))
    for _, during in criterion.periods():
        from_s = _moment_s(during.since, events, 0.0)
        to_s = _moment_s(during.until, events, duration_s)
    if criterion.by is not None:
        to_s = _moment_s(criterion.by, events, duration_s)
    if verdict.decided_s is not None:
        to_s = verdict.decided_s
    return {
        "name": name, "passed": verdict.passed, "from_s": from_s, "to_s": to_s, "text": verdict.reason,
        "curve": _curve(criterion),
    }  # fmt: skip


def _curve(criterion: Criterion) -> dict[str, Any] | None:
    """Return the topic and field of what a criterion measures, with its limits; None: it has no topic.

    A limit with a unit of its own is left out.
    """
    stays, observable = criterion.topic_stays, criterion.observable
    if stays is not None:
        topic, path, bounds = stays.name, stays.field, [stays.above, stays.below]
    elif isinstance(observable, str):
        topic, path = topic_of(observable), "data"
        bounds = [criterion.above, criterion.below, *(criterion.between or ())]
    else:
        return None
    return {"topic": topic, "path": path, "limits": [one for one in bounds if isinstance(one, int | float)]}


def _moment_s(moment: int | str, events: Mapping[str, float | None], otherwise: float) -> float:
    if isinstance(moment, int):
        return seconds(moment)
    found = events.get(moment)
    return otherwise if found is None else found


def _waits_for(event: Event) -> str:
    if event.at is not None:
        return f"at {seconds(event.at):g} s"
    when = event.when
    if when is None:
        return ""
    if when.near is not None:
        target = when.near.visual or when.near.other or "a point"
        return f"{when.near.model} near {target}"
    if when.event is not None:
        return f"{seconds(when.after):g} s after {when.event}" if when.after else f"after {when.event}"
    if when.observable is not None:
        return str(when.observable)
    return f"{when.topic.name} {when.topic.field}" if when.topic is not None else ""
