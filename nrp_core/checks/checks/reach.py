"""Places, times and topics of events and criteria that cannot be as intended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

from nrp_core.checks.checks.conditions import asked
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.clock import milliseconds, seconds
from nrp_core.dsl.functions.function import TIME
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.raycast.solids import inside_m, outside_m


@checks_experiment(Code.NRP248)
def places_are_in_the_scene(static: StaticExperiment) -> Iterator[Finding]:
    """Look for points that are farther outside the scene than a model may be away from them."""
    if static.scene is None:
        return
    for keys, near in asked(static.experiment, "near", "near"):
        away_m = 0.0 if near.point is None else outside_m(static.scene, near.point)
        if away_m > near.within:
            message = (
                f"'point' is {away_m:.3g} m outside the scene: no model comes within {near.within:g} m of it"
            )
            yield static.experiment.place(*keys, "point").finding(Code.NRP248, message, Level.WARNING)


@checks_experiment(Code.NRP248)
def places_are_free(static: StaticExperiment) -> Iterator[Finding]:
    """Look for points that are deeper inside a part of the room than a model may be away from them."""
    if static.scene is None:
        return
    heights_m = {model.name: model.pose.position[2] for model in static.scene.models}
    for keys, near in asked(static.experiment, "near", "near"):
        if near.point is None or near.model not in heights_m:
            continue
        inside = inside_m(static.scene, near.point, heights_m[near.model])
        if inside is not None and inside[1] > near.within:
            message = (
                f"'point' is {inside[1]:.2g} m inside '{inside[0]}': '{near.model}' does not come within "
                f"{near.within:g} m of it"
            )
            yield static.experiment.place(*keys, "point").finding(Code.NRP248, message, Level.WARNING)


@checks_experiment(Code.NRP248)
def limits_last_a_step(static: StaticExperiment) -> Iterator[Finding]:
    """Look for time limits that are over before anything can follow their event."""
    experiment, step_ms = static.experiment, milliseconds(static.experiment.timestep)
    for name, criterion in experiment.criteria.items():
        limit = criterion.within_of
        if limit is not None and limit.time < experiment.timestep:
            message = (
                f"'{limit.event}' and what follows it are at least a step of {step_ms:g} ms apart, "
                f"and the limit is {milliseconds(limit.time):g} ms"
            )
            place = experiment.place("criteria", name, "within_of", "time")
            yield place.finding(Code.NRP248, message, Level.WARNING)


@checks_experiment(Code.NRP229)
def events_do_not_contradict(static: StaticExperiment) -> Iterator[Finding]:
    """Look for two events that publish different values on one topic at one time."""
    experiment = static.experiment
    timed = [(name, event) for name, event in experiment.events.items() if event.at is not None]
    for (first, one), (second, other) in combinations(timed, 2):
        if one.at != other.at:
            continue
        values = {_target(experiment, said.topic): said.value for said in one.publish}
        for said in other.publish:
            if values.get(_target(experiment, said.topic), said.value) != said.value:
                message = (
                    f"'{second}' publishes on '{said.topic}' at {seconds(other.at or 0):g} s, when '{first}' "
                    "publishes another value"
                )
                place = experiment.place("events", second, "publish")
                yield place.finding(Code.NRP229, message, Level.WARNING)


@checks_experiment(Code.NRP229)
def events_are_not_overwritten(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events that publish on a topic that a function writes again in the next step."""
    experiment = static.experiment
    writers = {
        experiment.aliases.get(function.topic.name, function.topic.name): function.name
        for function in (examined.function for examined in static.functions)
        if function.active and function.topic is not None and TIME in function.triggers
    }
    for name, event in experiment.events.items():
        for said in event.publish:
            writer = writers.get(_target(experiment, said.topic))
            if writer is not None:
                message = f"'{name}' publishes on '{said.topic}', as '{writer}' does in every step"
                place = experiment.place("events", name, "publish")
                yield place.finding(Code.NRP229, message, Level.WARNING)


@checks_experiment(Code.NRP298)
def coloured_shapes_are_seen(static: StaticExperiment) -> Iterator[Finding]:
    """Look for shapes that events colour, and that are invisible until then."""
    if static.scene is None:
        return
    invisible = {
        f"/{path}/color": path for path, visual in static.scene.visuals.items() if visual.rgba[3] == 0
    }
    experiment = static.experiment
    for name, event in experiment.events.items():
        for said in event.publish:
            visual = invisible.get(_target(experiment, said.topic))
            if visual is not None:
                message = f"'{visual}', which '{name}' colours, is invisible at the start: its opacity is 0"
                yield experiment.place("events", name, "publish").finding(Code.NRP298, message, Level.WARNING)


@checks_experiment(Code.NRP298)
def given_colours_are_seen(static: StaticExperiment) -> Iterator[Finding]:
    """Look for colours of events that leave out the opacity, which is then 0."""
    experiment = static.experiment
    for name, event in experiment.events.items():
        for said in event.publish:
            info = static.topics.get(_target(experiment, said.topic))
            if info is None or info.type is not ColorRGBA or not isinstance(said.value, Mapping):
                continue
            if "a" not in said.value and any(said.value.values()):
                message = f"'{name}' makes '{said.topic}' invisible: the opacity 'a' is 0 unless it is given"
                yield experiment.place("events", name, "publish").finding(Code.NRP298, message, Level.WARNING)


def _target(experiment: Experiment, topic: str) -> str:
    return experiment.aliases.get(topic, topic)
