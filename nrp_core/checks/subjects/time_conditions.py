"""Times, events and criteria that cannot happen in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from nrp_core.checks.examined import ExaminedExperiment, checks_experiment
from nrp_core.clock import NS_PER_S, seconds
from nrp_core.experiment.model.event_schema import END, START, During, Event, TopicIs, causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.section import Key
from nrp_core.findings import Code, Finding


@checks_experiment
def check_events(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report events after the end of the run, and events that wait for each other."""
    events, end_ns = examined.experiment.events, examined.experiment.duration
    first_ns = {name: earliest_ns(name, events) for name in events}
    # one at a given time must be before the end
    late = {name for name, event in events.items() if first_ns[name] + (event.at is not None) > end_ns}
    for name, event in events.items():
        causes = causes_of(name, events)
        if name in causes:
            message = f"'{name}' waits for itself: {' -> '.join([name, *causes])}"
            yield examined.warning(Code.NRP248, message, "events", name, "when", "event")
        elif name in late and late.isdisjoint(causes):
            first, end = f"{seconds(first_ns[name]):g} s", f"{seconds(end_ns):g} s"
            after = f", after {' and '.join(map(repr, causes))}" if causes else ""
            is_fixed = event.at is not None
            when = f"is at {first}" if is_fixed else f"comes at {first} at the earliest{after}"
            keys = ("at",) if is_fixed else ("when", "after")
            message = f"'{name}' {when}, and the run ends at {end}"
            yield examined.warning(Code.NRP248, message, "events", name, *keys)


def earliest_ns(name: str, events: Mapping[str, Event]) -> int:
    """Return a time, ns, before which an event cannot happen."""
    return sum(_delay_ns(events[one]) for one in {name, *causes_of(name, events)} if one in events)


def _delay_ns(event: Event) -> int:
    """Return the earliest time of an event, after the event that it waits for or after the start."""
    if event.at is not None:
        return event.at
    return 0 if event.when is None else event.when.after


@checks_experiment
def check_step_of_loop(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report a time step that is too long for a closed loop."""
    step_ns = examined.experiment.timestep
    if step_ns > NS_PER_S:
        message = f"timestep: sensors reach the brain, and this the robot, only every {seconds(step_ns):g} s"
        yield examined.warning(Code.NRP372, message, "timestep")


@checks_experiment
def check_times_of_criteria(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report criteria that allow more time than the run has, or that are never evaluated."""
    experiment, end_ns = examined.experiment, examined.experiment.duration
    for name, each in experiment.criteria.items():
        if each.within_of is not None and each.within_of.time > end_ns:
            allowed_s = seconds(each.within_of.time)
            message = f"'{name}' allows {allowed_s:g} s, and the run lasts {seconds(end_ns):g} s"
            yield examined.warning(Code.NRP248, message, "criteria", name, "within_of", "time")
        for keys, during in each.periods():
            for message in _wrong_period(during, experiment):
                yield examined.warning(Code.NRP248, message, "criteria", name, *keys, "during")


def _wrong_period(during: During, experiment: Experiment) -> Iterator[str]:
    """Yield that a period ends after the run, and that it is empty."""
    fixed_ns: dict[int | str, int] = {START: 0, END: experiment.duration}
    fixed_ns |= {name: event.at for name, event in experiment.events.items() if event.at is not None}
    for moment in (during.since, during.until):
        if isinstance(moment, int) and moment > experiment.duration:
            end_s = seconds(experiment.duration)
            yield f"{seconds(moment):g} s is never reached: the run ends at {end_s:g} s"
    since, until = (fixed_ns.get(one, one) for one in (during.since, during.until))
    never, step_ns = "it is never evaluated: ", experiment.timestep
    if isinstance(since, int) and isinstance(until, int):
        if since >= until:
            yield f"{never}{seconds(since):g} s is not before {seconds(until):g} s"
        elif until // step_ns == (since - 1) // step_ns:  # no multiple of the step lies in the period
            yield f"{never}no step of {seconds(step_ns):g} s ends in this period"
    elif since == until:
        yield f"{never}'{since}' is both its beginning and its end"
    elif isinstance(since, str) and during.until in causes_of(since, experiment.events):
        yield f"{never}'{during.until}' comes before '{since}'"


@checks_experiment
def check_topics_of_criteria(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report criteria on topics of the experiment without a publisher."""
    experiment = examined.experiment
    if not examined.function_topics.is_complete:
        return
    published = set(examined.function_topics.published)
    published |= {one.topic for event in experiment.events.values() for one in event.publish}
    published = {experiment.aliases.get(name, name) for name in published}
    for keys, wanted in topic_conditions(experiment):
        name = experiment.aliases.get(wanted.name, wanted.name)
        if keys[0] == "criteria" and name in experiment.topics and name not in published:
            message = f"no transfer function and no event publishes on '{wanted.name}': it has no value"
            yield examined.warning(Code.NRP212, message, *keys, "name")


def topic_conditions(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], TopicIs]]:
    """Yield the conditions of events and criteria on topics, with their keys in the experiment file."""
    for name, event in experiment.events.items():
        if event.when is not None and event.when.topic is not None:
            yield ("events", name, "when", "topic"), event.when.topic
    for name, each in experiment.criteria.items():
        if each.topic_stays is not None:
            yield ("criteria", name, "topic_stays"), each.topic_stays


def read_topics(examined: ExaminedExperiment) -> set[str]:
    """Return the topics that functions, events and criteria read."""
    names = set(examined.function_topics.read)
    names |= {wanted.name for _, wanted in topic_conditions(examined.experiment)}
    return {examined.experiment.aliases.get(name, name) for name in names}
