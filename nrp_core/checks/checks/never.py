"""Events and criteria that cannot happen in time."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

from nrp_core.checks.events import Add
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.shapes import Known, Number
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.clock import seconds
from nrp_core.experiment.model.event_schema import Event, causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP248)
def events_come_in_time(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events after the end of the run, and for events that wait for each other."""
    experiment = static.experiment
    for name, event in experiment.events.items():
        duration_s = f"{seconds(experiment.duration):g} s"
        if event.at is not None and event.at >= experiment.duration:
            message = f"'{name}' is at {seconds(event.at):g} s, and the run ends at {duration_s}"
            yield experiment.place("events", name, "at").finding(Code.NRP248, message, Level.WARNING)
        if event.when is not None and event.when.after > experiment.duration:
            message = (
                f"'{name}' is {seconds(event.when.after):g} s after another, and the run lasts {duration_s}"
            )
            yield experiment.place("events", name, "when", "after").finding(
                Code.NRP248, message, Level.WARNING
            )
        causes = causes_of(name, experiment.events)
        if name in causes:
            message = f"'{name}' waits for itself: {' -> '.join([name, *causes])}"
            place = experiment.place("events", name, "when", "event")
            yield place.finding(Code.NRP248, message, Level.WARNING)
        yield from _comes_too_late(name, experiment)


@checks_experiment(Code.NRP248)
def limits_of_criteria_end_in_time(static: StaticExperiment) -> Iterator[Finding]:
    """Look for criteria that allow more time than the run has."""
    experiment = static.experiment
    for name, criterion in experiment.criteria.items():
        if criterion.within_of is not None and criterion.within_of.time > experiment.duration:
            message = (
                f"'{name}' allows {seconds(criterion.within_of.time):g} s, and the run lasts "
                f"{seconds(experiment.duration):g} s"
            )
            yield experiment.place("criteria", name, "within_of", "time").finding(
                Code.NRP248, message, Level.WARNING
            )
        elif criterion.within_of is not None and criterion.within_of.event in experiment.events:
            first_ns = earliest_ns(criterion.within_of.event, experiment.events)
            if first_ns < experiment.duration < first_ns + criterion.within_of.time:
                message = (
                    f"'{name}' allows {seconds(criterion.within_of.time):g} s after "
                    f"'{criterion.within_of.event}', which is at {seconds(first_ns):g} s at the earliest, "
                    f"and the run ends at {seconds(experiment.duration):g} s"
                )
                yield experiment.place("criteria", name, "within_of", "time").finding(
                    Code.NRP248, message, Level.NOTE
                )


def _comes_too_late(name: str, experiment: Experiment) -> Iterator[Finding]:
    """Yield events that follow others so late that the run is over."""
    events, end_ns = experiment.events, experiment.duration
    first_ns, causes = earliest_ns(name, events), causes_of(name, events)
    alone_ns = max([_delay_ns(events[name]), *(earliest_ns(one, events) for one in causes)])
    if causes and alone_ns <= end_ns < first_ns:
        message = (
            f"'{name}' comes at {seconds(first_ns):g} s at the earliest, after "
            f"{' and '.join(map(repr, causes))}, and the run ends at {seconds(end_ns):g} s"
        )
        yield experiment.place("events", name, "when", "after").finding(Code.NRP248, message, Level.WARNING)


def earliest_ns(name: str, events: Mapping[str, Event]) -> int:
    """Return a time, ns, before which an event cannot happen."""
    return sum(_delay_ns(events[one]) for one in {name, *causes_of(name, events)} if one in events)


def _delay_ns(event: Event) -> int:
    """Return the earliest time of an event after the one that it waits for, or after the start."""
    if event.at is not None:
        return event.at
    return 0 if event.when is None else event.when.after


@checks_function(Code.NRP248)
def times_are_reached(function: CheckedFunction) -> Iterator[Finding]:
    """Look for comparisons of ``t`` with times that it never reaches."""
    duration_s = seconds(function.experiment.duration)
    for event in function.events:
        match event:
            case Add(
                ast.Compare(ast.Name("t"), _, [_]) as node, Number("s"), Known(int() | float() as bound)
            ):
                pass
            case Add(
                ast.Compare(_, _, [ast.Name("t")]) as node, Known(int() | float() as bound), Number("s")
            ):
                pass
            case _:
                continue
        if bound > duration_s:
            message = f"'t', in seconds, never reaches {bound:g}: the run ends at {duration_s:g} s"
            yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)
