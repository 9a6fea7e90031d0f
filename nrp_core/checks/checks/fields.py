"""Conditions on fields of messages: settings of a sensor, and numbers that a field never has."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from operator import attrgetter
from typing import Any, Final

from nrp_core.checks.checks.conditions import asked
from nrp_core.checks.checks.never import PARTS
from nrp_core.checks.events import Read
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.shapes import Instance
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.experiment.model.event_schema import TopicIs
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.geometry_msgs import PoseWithCovariance, Quaternion, TwistWithCovariance
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.messages.sensor_msgs import Image, Imu, LaserScan, Range
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.raycast.solids import width_m
from nrp_core.world.topics import TopicInfo

_SETTINGS: Final = {
    LaserScan: ("angle_", "range_", "time_increment", "scan_time"),
    Range: ("radiation_type", "field_of_view", "min_range", "max_range"),
    Image: ("height", "width", "encoding", "is_bigendian", "step"),
}
"""Beginnings of the fields that a sensor gives the same value in each message."""
_UNFILLED: Final[dict[type, tuple[str, ...]]] = {
    LaserScan: ("intensities",),
    PoseWithCovariance: ("covariance",),
    TwistWithCovariance: ("covariance",),
    Imu: ("orientation_covariance", "angular_velocity_covariance", "linear_acceleration_covariance"),
}
"""Fields that are empty or 0 in every message of a sensor or drive."""
_LIMITED: Final = {
    Quaternion: (-1.0, 1.0, PARTS[Quaternion]),
    ColorRGBA: (0.0, 1.0, "a part of a colour, from 0 to 1"),
}
_PLACES: Final = ("pose.pose.position.x", "pose.pose.position.y")


@checks_experiment(Code.NRP248, Code.NRP320)
def fields_can_decide(static: StaticExperiment) -> Iterator[Finding]:
    """Look for conditions on fields that are always met, or never."""
    experiment = static.experiment
    for keys, wanted in asked(experiment, "topic", "topic_stays"):
        info = static.topics.get(experiment.aliases.get(wanted.name, wanted.name))
        owner = None if info is None else _owner(info, wanted.field)
        if info is None or owner is None:
            continue  # reported where the condition is made
        code, message = _of_settings(wanted, info) or _of_limits(static, wanted, info, owner)
        if message:
            yield experiment.place(*keys, "field").finding(code, message, Level.WARNING)


@checks_experiment(Code.NRP320)
def fields_that_are_read_are_filled(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions that read a field which no sensor here fills."""
    if static.scene is None or static.world is None or static.world.capabilities.own_scene:
        return
    for function in static.functions:
        for event in function.events:
            match event:
                case Read(node, Instance(cls), name) if name in _UNFILLED.get(cls, ()):
                    message = f"'{excerpt(node)}' has no value: no sensor of a simulated robot fills it"
                    yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


def _owner(info: TopicInfo, field: str) -> Any:
    """Return the part of a message that has a field; None if there is none."""
    parts, _, leaf = field.rpartition(".")
    try:
        owner = attrgetter(parts)(info.type()) if parts else info.type()
    except AttributeError:
        return None
    return owner if hasattr(owner, leaf) else None


def _of_settings(wanted: TopicIs, info: TopicInfo) -> tuple[Code, str] | None:
    if not wanted.field.startswith(_SETTINGS.get(info.type, ("\0",))):
        return None
    return (
        Code.NRP320,
        f"'{wanted.field}' of {wanted.name} is a setting of the sensor, the same in each message",
    )


def _of_limits(static: StaticExperiment, wanted: TopicIs, info: TopicInfo, owner: Any) -> tuple[Code, str]:
    """Return that the limits of a field decide a condition; an empty text if they do not."""
    low, high, what = _LIMITED.get(type(owner), (-inf, inf, ""))
    if info.type is Odometry and wanted.field in _PLACES and static.scene is not None:
        across_m = width_m(static.scene)
        low, high, what = -across_m, across_m, f"a place in a scene that is {across_m:.3g} m across"
    above = -inf if wanted.above is None else wanted.above
    below = inf if wanted.below is None else wanted.below
    subject = f"'{wanted.field}' of {wanted.name}"
    if above >= high or below <= low:
        return Code.NRP248, f"{subject} is {what}: the condition is never met"
    if wanted.equals is None and above < low and below > high:
        return Code.NRP320, f"{subject} is {what}: the condition is always met"
    return Code.NRP248, ""
