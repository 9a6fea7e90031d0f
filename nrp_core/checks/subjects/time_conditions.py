"""Times, events and criteria that cannot happen in time, and the latency of each path."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import Any

from nrp_core.checks.check import checks_experiment, checks_function
from nrp_core.checks.code.values import NUMBER
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.cle.latency import paths
from nrp_core.clock import NS_PER_S, milliseconds, seconds
from nrp_core.experiment.model.event_schema import END, START, During, Event, causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding, Level


@checks_experiment
def check_events(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events after the end of the run, and for events that wait for each other."""
    experiment, events = static.experiment, static.experiment.events
    late = {name for name, event in events.items() if _is_late(name, event, experiment)}
    for name, event in events.items():
        causes = causes_of(name, events)
        if name in causes:
            message = f"'{name}' waits for itself: {' -> '.join([name, *causes])}"
            yield experiment.place("events", name, "when", "event").finding(
                Code.NRP248, message, Level.WARNING
            )
        elif name in late and late.isdisjoint(causes):
            first, end = (f"{seconds(ns):g} s" for ns in (earliest_ns(name, events), experiment.duration))
            after = f", after {' and '.join(map(repr, causes))}" if causes else ""
            is_fixed = event.at is not None
            when = f"is at {first}" if is_fixed else f"comes at {first} at the earliest{after}"
            place = experiment.place("events", name, *(("at",) if is_fixed else ("when", "after")))
            message = f"'{name}' {when}, and the run ends at {end}"
            yield place.finding(Code.NRP248, message, Level.WARNING)


@checks_experiment
def check_limits_of_criteria(static: StaticExperiment) -> Iterator[Finding]:
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


def _is_late(name: str, event: Event, experiment: Experiment) -> bool:
    """Return whether an event cannot happen before the end; one at a given time must be before it."""
    first_ns = earliest_ns(name, experiment.events)
    return first_ns >= experiment.duration if event.at is not None else first_ns > experiment.duration


def earliest_ns(name: str, events: Mapping[str, Event]) -> int:
    """Return a time, ns, before which an event cannot happen."""
    return sum(_delay_ns(events[one]) for one in {name, *causes_of(name, events)} if one in events)


def _delay_ns(event: Event) -> int:
    """Return the earliest time of an event after the one that it waits for, or after the start."""
    if event.at is not None:
        return event.at
    return 0 if event.when is None else event.when.after


@checks_function
def check_reached_times(function: CheckedFunction) -> Iterator[Finding]:
    """Look for comparisons of ``t`` with times that it never reaches."""
    duration_s = seconds(function.experiment.duration)
    for node in function.declared.own:
        match node:
            case ast.Compare(ast.Name("t"), _, [other]) | ast.Compare(other, _, [ast.Name("t")]):
                bound_s = function.body.constant(other) if function.body.name("t") == NUMBER else None
                if bound_s is not None and bound_s > duration_s:
                    message = f"'t', in seconds, never reaches {bound_s:g}: the run ends at {duration_s:g} s"
                    yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_experiment
def report_latency(static: StaticExperiment) -> Iterator[Finding]:
    """Report the latency of each path from a sensor to an actuator."""
    timestep_ms = milliseconds(static.experiment.timestep)
    for path in paths([one.function for one in static.functions if one.function.active]):
        last = next(e.declared for e in static.functions if e.function.name == path.via[-1])
        message = f"{path} of {timestep_ms:g} ms, {path.steps * timestep_ms:g} ms in all"
        yield last.finding(Code.NRP238, last.nodes.get(""), message, Level.NOTE)


@checks_experiment
def check_step_of_loop(static: StaticExperiment) -> Iterator[Finding]:
    """Look for a time step that is too long for a closed loop."""
    step_ns = static.experiment.timestep
    if step_ns > NS_PER_S:
        message = f"timestep: sensors reach the brain, and this the robot, only every {seconds(step_ns):g} s"
        yield static.experiment.place("timestep").finding(Code.NRP372, message, Level.WARNING)


@checks_experiment
def check_periods_of_criteria(static: StaticExperiment) -> Iterator[Finding]:
    """Look for criteria that are never evaluated."""
    experiment, end_ns = static.experiment, static.experiment.duration
    for keys, during in _periods(experiment):
        place = experiment.place(*keys, "during")
        for moment in (during.since, during.until):
            if isinstance(moment, int) and moment > end_ns:
                message = f"{seconds(moment):g} s is never reached: the run ends at {seconds(end_ns):g} s"
                yield place.finding(Code.NRP248, message, Level.WARNING)
        wrong = _never_counts(during, experiment)
        if wrong:
            yield place.finding(Code.NRP248, f"it is never evaluated: {wrong}", Level.WARNING)


def _never_counts(during: During, experiment: Experiment) -> str:
    """Return why a period is empty; an empty text if it is not, or if this is unknown."""
    since, until = (_time_of(moment, experiment) for moment in (during.since, during.until))
    if isinstance(since, int) and isinstance(until, int):
        if since >= until:
            return f"{seconds(since):g} s is not before {seconds(until):g} s"
        step_ns = experiment.timestep
        is_between = until // step_ns == (since - 1) // step_ns  # no multiple of the step lies in the period
        return f"no step of {seconds(step_ns):g} s ends in this period" if is_between else ""
    if since == until:
        return f"'{since}' is both its beginning and its end"
    if isinstance(during.since, str) and during.until in causes_of(during.since, experiment.events):
        return f"'{during.until}' comes before '{during.since}'"
    return ""


def _time_of(moment: int | str, experiment: Experiment) -> int | str:
    """Return a time in ns; the event itself if its time is only known during the run."""
    fixed = {START: 0, END: experiment.duration}
    fixed |= {name: event.at for name, event in experiment.events.items() if event.at is not None}
    return moment if isinstance(moment, int) else fixed.get(moment, moment)


@checks_experiment
def check_topics_of_criteria(static: StaticExperiment) -> Iterator[Finding]:
    """Look for criteria on topics of the experiment that nothing publishes on."""
    experiment = static.experiment
    if not static.is_complete:
        return
    published = {topic.name for declared in static.declared for topic in declared.function.published}
    published |= {one.topic for event in experiment.events.values() for one in event.publish}
    published = {experiment.aliases.get(name, name) for name in published}
    for keys, wanted in conditions(experiment, "topic", "topic_stays"):
        name = experiment.aliases.get(wanted.name, wanted.name)
        if keys[0] == "criteria" and name in experiment.topics and name not in published:
            message = f"no transfer function and no event publishes on '{wanted.name}': it has no value"
            yield experiment.place(*keys, "name").finding(Code.NRP212, message, Level.WARNING)


def _periods(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], During]]:
    for name, criterion in experiment.criteria.items():
        for kind in ("stays_within", "topic_stays"):
            asked = getattr(criterion, kind)
            if asked is not None:
                yield ("criteria", name, kind), asked.during


def conditions(experiment: Experiment, when: str, criterion: str) -> Iterator[tuple[tuple[Key, ...], Any]]:
    """Yield the conditions of one kind, with their keys in the experiment file.

    Args:
        experiment: the experiment.
        when: the key of the condition in events.
        criterion: its key in criteria.
    """
    for name, event in experiment.events.items():
        if (condition := getattr(event.when, when, None)) is not None:
            yield ("events", name, "when", when), condition
    for name, each in experiment.criteria.items():
        if (condition := getattr(each, criterion)) is not None:
            yield ("criteria", name, criterion), condition


def read_topics(static: StaticExperiment) -> set[str]:
    """Return the topics that functions, events and criteria read."""
    names = {topic.name for one in static.declared for topic in one.function.subscribed}
    names |= {wanted.name for _, wanted in conditions(static.experiment, "topic", "topic_stays")}
    return {static.experiment.aliases.get(name, name) for name in names}
