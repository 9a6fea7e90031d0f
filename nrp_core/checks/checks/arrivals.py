"""Models that are where an event or criterion wants them before they have moved."""

from __future__ import annotations

from collections.abc import Iterator
from math import dist, inf

from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.dsl.testing.mocks import MockWorld
from nrp_core.errors import NrpError
from nrp_core.experiment.events.ground_positions import GroundPositions, Proximity
from nrp_core.experiment.model.event_schema import START, Near
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.raycast.solids import width_m
from nrp_core.world.scene.model import Scene


@checks_experiment(Code.NRP248)
def criteria_are_not_met_at_once(static: StaticExperiment) -> Iterator[Finding]:
    """Look for models that start at their destination."""
    if static.scene is None:
        return
    where = GroundPositions(MockWorld(scene=static.scene))
    for name, criterion in static.experiment.criteria.items():
        near = criterion.near
        if near is None or criterion.within_of is not None:
            continue
        distance = _distance(near, static.scene, where)
        if distance is not None and distance <= near.within:
            message = f"'{name}' is met before anything moves: '{near.model}' starts {distance:.2g} m away"
            place = static.experiment.place("criteria", name, "near", "within")
            yield place.finding(Code.NRP248, message, Level.WARNING)
    for name, event in static.experiment.events.items():
        when = event.when
        if when is None or when.near is None or when.event is not None:
            continue
        distance = _distance(when.near, static.scene, where)
        if distance is not None and distance <= when.near.within:
            message = (
                f"'{name}' happens before anything moves: '{when.near.model}' starts {distance:.2g} m away"
            )
            place = static.experiment.place("events", name, "when", "near", "within")
            yield place.finding(Code.NRP248, message, Level.WARNING)


@checks_experiment(Code.NRP248)
def criteria_are_not_met_by_their_event(static: StaticExperiment) -> Iterator[Finding]:
    """Look for destinations at which a model certainly is when the event happens that they come after."""
    if static.scene is None:
        return
    where = GroundPositions(MockWorld(scene=static.scene))
    for name, criterion in static.experiment.criteria.items():
        near, limit = criterion.near, criterion.within_of
        if near is None or limit is None or near.within > width_m(static.scene):  # which is reported as such
            continue
        for away_m, why in _farthest(static, near, limit.event, where):
            if away_m <= near.within:
                message = (
                    f"'{name}' is met as soon as '{limit.event}' happens: '{near.model}' is {why} then, "
                    f"and so at most {away_m:.3g} m away"
                )
                place = static.experiment.place("criteria", name, "near", "within")
                yield place.finding(Code.NRP248, message, Level.WARNING)
                break


def _farthest(
    static: StaticExperiment, near: Near, event: str, where: GroundPositions
) -> Iterator[tuple[float, str]]:
    """Yield how far from its destination a model can be at an event, m, each with the reason."""
    scene, experiment = static.scene, static.experiment
    assert scene is not None
    start_m = _distance(near, scene, where)
    cause = experiment.events[event].when if event in experiment.events else None
    if cause is not None and cause.near is not None and cause.near.model == near.model:
        aim = cause.near.visual or cause.near.other or "its point"
        yield (
            cause.near.within + _apart(cause.near, near, scene, where),
            f"within {cause.near.within:g} m of {aim}",
        )
    for each in experiment.criteria.values():
        stays = each.stays_within
        if stays is None or start_m is None or (stays.model, stays.of) != (near.model, START):
            continue
        if (stays.during.since, stays.during.until) == (START, event):
            yield start_m + stays.distance, f"within {stays.distance:g} m of its start"


def _apart(one: Near, other: Near, scene: Scene, where: GroundPositions) -> float:
    """Return how far any place at one target is from the other, m; infinite if that is not known."""
    moving = [model.name for model in scene.models if not model.static]
    if any(
        name in moving
        for near in (one, other)
        for name in (near.other, (near.visual or "").partition("/")[0])
    ):
        return inf
    try:
        first, second = (Proximity(near, scene).target(where) for near in (one, other))
    except NrpError:  # reported by the check of events and criteria
        return inf
    return max(map(second.distance, first.corners)) + first.radius


def _distance(near: Near, scene: Scene, where: GroundPositions) -> float | None:
    """Return how far apart the model and its target are at the start, m; None if they do not exist."""
    try:
        return Proximity(near, scene).distance(where)
    except NrpError:  # reported by the check of events and criteria
        return None


@checks_experiment(Code.NRP248)
def models_start_where_they_stay(static: StaticExperiment) -> Iterator[Finding]:
    """Look for models that start outside the circle in which they should stay from the beginning on."""
    if static.scene is None:
        return
    starts = {model.name: model.pose.position for model in static.scene.models}
    for name, criterion in static.experiment.criteria.items():
        stays = criterion.stays_within
        if stays is None or isinstance(stays.of, str) or stays.during.since != START:
            continue
        x, y, *_ = starts.get(stays.model, stays.of)
        away_m = dist((x, y), stays.of[:2])
        if away_m > stays.distance:
            message = f"'{name}' is not met from the beginning: '{stays.model}' starts {away_m:.3g} m away"
            place = static.experiment.place("criteria", name, "stays_within", "of")
            yield place.finding(Code.NRP248, message, Level.WARNING)
