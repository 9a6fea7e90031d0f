"""What events, criteria and comparisons of an experiment ask for, and never get."""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter
from typing import Any

from nrp_core.analysis.registry import checks_experiment
from nrp_core.analysis.study import Study
from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.happenings import During, TopicIs
from nrp_core.experiment.model import Experiment
from nrp_core.experiment.reader import experiment_of
from nrp_core.experiment.tree import Key
from nrp_core.findings import Code, Finding, Level


@checks_experiment(Code.NRP202)
def a_step_is_short(study: Study) -> Iterator[Finding]:
    """Look for a loop that hardly turns."""
    step_ns = study.experiment.timestep
    if step_ns > NS_PER_S:
        message = f"timestep: sensors reach the brain, and this the robot, only every {seconds(step_ns):g} s"
        yield study.experiment.place("timestep").finding(Code.NRP202, message, Level.WARNING)


@checks_experiment(Code.NRP248)
def criteria_count_some_time(study: Study) -> Iterator[Finding]:
    """Look for criteria that never count."""
    experiment, end_ns = study.experiment, study.experiment.duration
    for keys, during in _periods(experiment):
        since, until = during.since, during.until
        place = experiment.place(*keys, "during")
        for moment in (since, until):
            if isinstance(moment, int) and moment > end_ns:
                message = f"{seconds(moment):g} s never comes: the run ends at {seconds(end_ns):g} s"
                yield place.finding(Code.NRP248, message, Level.WARNING)
        if isinstance(since, int) and isinstance(until, int) and since >= until:
            message = f"it never counts: {seconds(since):g} s is not before {seconds(until):g} s"
            yield place.finding(Code.NRP248, message, Level.WARNING)


@checks_experiment(Code.NRP212, Code.NRP248)
def numbers_are_compared_with_numbers(study: Study) -> Iterator[Finding]:
    """Look for bounds of what is no number."""
    for keys, wanted in _conditions(study.experiment):
        info = study.topics.get(wanted.name)
        if info is None or (wanted.above is None and wanted.below is None):
            continue
        try:
            said: Any = attrgetter(wanted.field)(info.type())
        except (AttributeError, TypeError):  # reported where it is read
            continue
        if wanted.above is not None and wanted.below is not None and wanted.above >= wanted.below:
            message = f"nothing is above {wanted.above:g} and below {wanted.below:g}"
            yield study.experiment.place(*keys, "above").finding(Code.NRP248, message, Level.WARNING)
        if not hasattr(said, "__float__"):
            message = (
                f"'above' and 'below' are for numbers, and '{wanted.field}' of {wanted.name} is "
                f"a {type(said).__name__}"
            )
            yield study.experiment.place(*keys, "name").finding(Code.NRP212, message)


@checks_experiment(Code.NRP215)
def varied_settings_exist(study: Study) -> Iterator[Finding]:
    """Try a value of each range that a comparison draws from."""
    experiment = study.experiment
    if not experiment.source.value:  # it was made in Python
        return
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
        if message:
            message = f"'{key}' cannot be varied: {message}"
            yield experiment.place("comparison", "vary", key).finding(Code.NRP215, message)


def _named(experiment: Experiment) -> set[str]:
    return {*experiment.events, *experiment.criteria, *experiment.world.robots}


def _periods(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], During]]:
    for name, criterion in experiment.criteria.items():
        for kind in ("stays_within", "topic_stays"):
            asked = getattr(criterion, kind)
            if asked is not None:
                yield ("criteria", name, kind), asked.during


def _conditions(experiment: Experiment) -> Iterator[tuple[tuple[Key, ...], TopicIs]]:
    for name, event in experiment.events.items():
        if event.when is not None and event.when.topic is not None:
            yield ("events", name, "when", "topic"), event.when.topic
    for name, criterion in experiment.criteria.items():
        if criterion.topic_stays is not None:
            yield ("criteria", name, "topic_stays"), criterion.topic_stays
