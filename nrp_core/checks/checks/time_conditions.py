"""Times, events and criteria that cannot happen in time, and the latency of each path."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from math import isclose
from typing import Any, Final

from nrp_core.checks.code.shapes import Add, Known, Number
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.cle.latency import paths
from nrp_core.clock import NS_PER_S, milliseconds, seconds
from nrp_core.dsl.parameters import SubscribedTopic
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.making.maker import with_parameters
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.event_schema import END, START, During, Event, causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.section import Key
from nrp_core.experiment.reading.reader import experiment_of
from nrp_core.findings import Code, Finding, Level
from nrp_core.quantities import time_ns
from nrp_core.scripts import last_name


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


_STEPS: Final = ("dt", "delta_t", "timestep", "time_step", "dt_s", "timestep_s")
"""Names of the time between two calls of a function."""
_LOOPS: Final = (ast.For, ast.While, ast.comprehension)
_COUNTING: Final = ("int", "round", "range", "ceil", "arange", "linspace")
"""Functions that count steps, or list their times."""


@checks_function(Code.NRP358)
def steps_are_those_of_the_loop(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a constant ``DT`` that is not how often the function runs."""
    step_s = seconds(function.experiment.timestep)
    rates_hz = [function.function.throttle.rate_hz]
    rates_hz += [one.info.rate_hz for one in function.adapters.values() if isinstance(one, SubscribedTopic)]
    periods_s = [step_s, *(1 / rate_hz for rate_hz in rates_hz if rate_hz)]
    nodes = function.declared.own
    repeated = {id(one) for loop in nodes if isinstance(loop, _LOOPS) for one in ast.walk(loop)}
    own = {
        one.id for node in nodes if _is_own_step(node) for one in ast.walk(node) if isinstance(one, ast.Name)
    }
    for node in nodes:
        name = node.id if isinstance(node, ast.Name) and node.id not in own else ""
        given = function.declared.names.get(name)
        if not isinstance(given, Known) or not isinstance(given.value, int | float) or id(node) in repeated:
            continue  # loops take smaller steps of their own
        fits = any(isclose(given.value, factor * one) for one in periods_s for factor in (1, 1000))
        if name.lower() in _STEPS and given.value > 0 and not fits:
            message = (
                f"'{name}' is {given.value:g}, and the function runs every {step_s:g} s; is the time since "
                "its last call meant? It is known from 't'"
            )
            yield function.declared.finding(Code.NRP358, node, message, Level.WARNING)
            return


def _is_own_step(node: ast.AST) -> bool:
    """Return whether a function waits for a time by itself, or divides its step into smaller ones."""
    match node:
        case ast.Compare():
            return True
        case ast.Call(func):
            return last_name(func) in _COUNTING
    return False


@checks_experiment(Code.NRP238)
def paths_take_time(static: StaticExperiment) -> Iterator[Finding]:
    """Report the latency of each path from a sensor to an actuator."""
    timestep_ms = milliseconds(static.experiment.timestep)
    for path in paths([one.function for one in static.functions if one.function.active]):
        last = next(e.declared for e in static.functions if e.function.name == path.via[-1])
        message = f"{path} of {timestep_ms:g} ms, {path.steps * timestep_ms:g} ms in all"
        yield last.finding(Code.NRP238, last.nodes.get(""), message, Level.NOTE)


@checks_experiment(Code.NRP296)
def a_step_is_short(static: StaticExperiment) -> Iterator[Finding]:
    """Look for a time step that is too long for a closed loop."""
    step_ns = static.experiment.timestep
    if step_ns > NS_PER_S:
        message = f"timestep: sensors reach the brain, and this the robot, only every {seconds(step_ns):g} s"
        yield static.experiment.place("timestep").finding(Code.NRP296, message, Level.WARNING)


@checks_experiment(Code.NRP248)
def criteria_count_some_time(static: StaticExperiment) -> Iterator[Finding]:
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


@checks_experiment(Code.NRP212)
def topics_of_criteria_are_published(static: StaticExperiment) -> Iterator[Finding]:
    """Look for criteria on topics of the experiment that nothing publishes on."""
    experiment = static.experiment
    if not static.is_complete:
        return
    spoken = {topic.name for declared in static.declared for topic in declared.function.published}
    spoken |= {one.topic for event in experiment.events.values() for one in event.publish}
    spoken = {experiment.aliases.get(name, name) for name in spoken}
    for keys, wanted in asked(experiment, "topic", "topic_stays"):
        name = experiment.aliases.get(wanted.name, wanted.name)
        if keys[0] == "criteria" and name in experiment.topics and name not in spoken:
            message = f"no transfer function and no event publishes on '{wanted.name}': it has no value"
            yield experiment.place(*keys, "name").finding(Code.NRP212, message, Level.WARNING)


@checks_experiment(Code.NRP202, Code.NRP248)
def varied_settings_exist(static: StaticExperiment) -> Iterator[Finding]:
    """Try a value from each range of a comparison."""
    experiment = static.experiment
    if not experiment.source.value:  # it was created in Python
        return
    own = _wrong_parameters(experiment_of(experiment.source)) if experiment.comparison.vary else []
    for key, values in experiment.comparison.vary.items():
        message = ""
        try:
            changed = experiment_of(experiment.source, [values.override(key, experiment.seed)])
        except ExperimentError as error:
            message = error.message
        else:
            known = _named(experiment)
            message = "".join(
                f"there is no '{name}'{did_you_mean(name, known)}" for name in _named(changed) - known
            )
            message = message or "; ".join(one for one in _wrong_parameters(changed) if one not in own)
        end_ns = experiment.duration
        if not message and key.startswith("events.") and key.endswith((".at", ".when.after")):
            latest_ns = time_ns(f"{values.high:.9g} {values.unit}")
            if latest_ns >= end_ns:
                late = f"up to {seconds(latest_ns):g} s, and the run ends at {seconds(end_ns):g} s"
                place = experiment.place("comparison", "vary", key)
                yield place.finding(Code.NRP248, f"'{key}' is {late}", Level.WARNING)
        if message:
            message = f"'{key}' cannot be varied: {message}"
            yield experiment.place("comparison", "vary", key).finding(Code.NRP202, message)


def _wrong_parameters(experiment: Experiment) -> list[str]:
    found = Collector(experiment.source)
    with_parameters(experiment, found)
    return [one.message for one in found.findings if one.code is Code.NRP288]


def _named(experiment: Experiment) -> set[str]:
    return {*experiment.events, *experiment.criteria, *experiment.world.robots}


def _periods(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], During]]:
    for name, criterion in experiment.criteria.items():
        for kind in ("stays_within", "topic_stays"):
            asked = getattr(criterion, kind)
            if asked is not None:
                yield ("criteria", name, kind), asked.during


def asked(experiment: Experiment, when: str, criterion: str) -> Iterator[tuple[tuple[Key, ...], Any]]:
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
    """Return the names, or aliases, of the topics that functions, events and criteria read."""
    names = {topic.name for one in static.declared for topic in one.function.subscribed}
    return names | {wanted.name for _, wanted in asked(static.experiment, "topic", "topic_stays")}
