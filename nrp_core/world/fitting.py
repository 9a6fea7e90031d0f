"""The additions of an experiment to a robot: how it stands, and how its joints are commanded."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.world.added_sensors import AddedSensor, with_added_sensors
from nrp_core.world.controllers.joint_plugins import TOPICS
from nrp_core.world.scene.acting import GroupController, JointController, Pid, TrajectoryController
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Joint, Link, Model
from nrp_core.world.topics import resolve_name

TRAJECTORY = "joint_trajectory_controller"
"""The name of the controller that makes joints follow trajectories."""
HELD = "held_by_the_world"
"""The name of the joint that fixes to the world a robot that is free of it in its file."""


@dataclass(frozen=True, slots=True)
class JointControl:
    """How joints are commanded.

    Args:
        mode: the commanded quantity; joints with trajectories go along them together.
        gains: of each joint; None: it follows with any load within its limits.
        group: the name of a group, all joints of which take one message; empty for a topic of its own.
    """

    mode: Literal["position", "velocity", "effort", "trajectory"] = "position"
    gains: Pid | None = None
    group: str = ""


@dataclass(frozen=True, slots=True)
class Fitting:
    """What is added to a robot.

    Args:
        fixed: whether its base is fixed to the world; None: as in its file.
        starts: positions of joints at the start, rad or m.
        control: how joints are commanded, by regular expressions that match whole names of joints. These
            replace controllers of the same joints and quantities in the file.
        sensors: further sensors.
    """

    fixed: bool | None = None
    starts: tuple[tuple[str, float], ...] = ()
    control: tuple[tuple[str, JointControl], ...] = ()
    sensors: tuple[AddedSensor, ...] = ()


def commandable(model: Model) -> list[Joint]:
    """Return the joints of a model that could be commanded."""
    return [joint for joint in model.joints if joint.coordinates and joint.mimic is None]


def without_commands(model: Model) -> list[Joint]:
    """Return the joints of a model that could be commanded, but that nothing in its file commands."""
    led = {joint for each in (*model.leaders, *model.drives) for joint in each.joints}
    led |= {controller.joint for controller in model.controllers}
    return [joint for joint in commandable(model) if joint.name not in led]


def fitted(model: Model, fitting: Fitting) -> Model:
    """Return a robot with what an experiment adds to it.

    Raises:
        SceneError: a joint does not exist, cannot be commanded or cannot start where it is told to, or a
            pattern matches no joint.
    """
    if fitting == Fitting():
        return model
    if model.static:
        raise SceneError(f"the robot '{model.name}' never moves (<static>), so nothing can be fitted to it")
    model = _held(model, fitting.fixed)
    starts = {**dict(model.starts), **dict(_start(model, *start) for start in fitting.starts)}
    model = replace(model, starts=tuple(starts.items()))
    told: dict[tuple[str, str], JointControl] = {}
    for pattern, control in fitting.control:
        for joint in _chosen(model, pattern, control):
            if (joint, control.mode) in told:
                raise SceneError(f"two patterns give the joint '{joint}' of '{model.name}' a {control.mode}")
            told[joint, control.mode] = control
    single = [
        _controller(model, joint, each)
        for (joint, mode), each in told.items()
        if mode != "trajectory" and not each.group
    ]
    groups = (
        *(
            each
            for each in model.group_controllers
            if not told.keys() & {(j, each.kind) for j in each.joints}
        ),
        *_groups(model, told),
    )
    led = {joint: each for (joint, mode), each in told.items() if mode == "trajectory"}
    kept = [each for each in model.controllers if (each.joint, each.kind) not in told]
    leaders = model.trajectory_controllers
    if led:
        leaders = (*(each for each in leaders if not led.keys() & {*each.joints}), _leader(model, led))
    controllers = (*kept, *single)
    result = replace(model, controllers=controllers, trajectory_controllers=leaders, group_controllers=groups)
    if result.joint_states_topic is None and commandable(result):
        result = replace(result, joint_states_topic=resolve_name("joint_states", model.name))
    result.check()
    return with_added_sensors(result, fitting.sensors)


def _held(model: Model, fixed: bool | None) -> Model:
    """Return a robot whose base is fixed to the world, or free of it."""
    holding = [joint for joint in model.joints if joint.parent == WORLD and joint.kind == "fixed"]
    if fixed and not any(joint.parent == WORLD for joint in model.joints):
        base = _root(model)
        held = Joint(HELD, "fixed", WORLD, base.name, base.pose)
        return replace(model, joints=(*model.joints, held))
    if fixed is False and holding:
        return replace(model, joints=tuple(joint for joint in model.joints if joint not in holding))
    return model


def _root(model: Model) -> Link:
    """Return the link at the root of the tree with the model's first link."""
    parents = {joint.child: joint.parent for joint in model.joints}
    name = model.links[0].name
    while name in parents:
        name = parents[name]
    return model.link(name)


def _start(model: Model, name: str, position: float) -> tuple[str, float]:
    joints = {joint.name: joint for joint in model.joints if joint.takes_commands}
    if name not in joints:
        raise SceneError(f"'{model.name}' has no joint '{name}' that moves{did_you_mean(name, joints)}")
    lower, upper = joints[name].lower, joints[name].upper
    if not lower <= position <= upper:
        limits = f"{lower:g} to {upper:g}"
        raise SceneError(
            f"the joint '{name}' of '{model.name}' cannot start at {position:g}: its limits are {limits}"
        )
    return name, position


def _chosen(model: Model, pattern: str, control: JointControl) -> list[str]:
    """Return the joints that a pattern matches; ball joints only take positions, without gains."""
    try:
        matches = re.compile(pattern).fullmatch
    except re.error as error:
        raise SceneError(f"'{pattern}' is not a regular expression for joints: {error}") from None
    turns_all_ways = control == JointControl("position")
    names = [joint.name for joint in commandable(model) if joint.takes_commands or turns_all_ways]
    chosen = [name for name in names if matches(name)]
    if not chosen:
        balls = [joint.name for joint in model.joints if joint.kind == "ball" and matches(joint.name)]
        if balls:
            raise SceneError(f"the ball joint '{balls[0]}' of '{model.name}' takes only {{mode: position}}")
        hint = did_you_mean(pattern, names) if names else "; no joint of it can be commanded"
        raise SceneError(f"no joint of '{model.name}' that can be commanded matches '{pattern}'{hint}")
    return chosen


def _controller(model: Model, joint: str, control: JointControl) -> JointController:
    assert control.mode != "trajectory"
    topic = resolve_name(f"{joint}/{TOPICS[control.mode]}".replace("::", "/"), model.name)
    gains = Pid() if control.mode == "effort" else control.gains
    return JointController(joint, control.mode, topic, gains)


def _groups(model: Model, told: Mapping[tuple[str, str], JointControl]) -> Iterator[GroupController]:
    """Yield the controllers of groups; the numbers of each are in the order of the joints in the file."""
    groups: dict[str, dict[str, JointControl]] = {}
    for joint in model.joints:
        for (name, _), control in told.items():
            if name == joint.name and control.group:
                groups.setdefault(control.group, {})[name] = control
                modes = {each.mode for each in groups[control.group].values()}
                if len(modes) > 1:
                    several = " and ".join(sorted(modes))
                    raise SceneError(f"the group '{control.group}' of '{model.name}' mixes {several}")
    for group, joints in groups.items():
        mode = next(iter(joints.values())).mode
        assert mode != "trajectory"
        gains = {name: Pid() if mode == "effort" else each.gains for name, each in joints.items()}
        given = tuple((name, each) for name, each in gains.items() if each is not None)
        topic = resolve_name(f"{group}/commands", model.name)
        yield GroupController(group, tuple(joints), mode, topic, given)


def _leader(model: Model, led: Mapping[str, JointControl]) -> TrajectoryController:
    command, state = (resolve_name(f"{TRAJECTORY}/{end}", model.name) for end in ("command", "state"))
    gains = tuple((joint, control.gains) for joint, control in led.items() if control.gains is not None)
    return TrajectoryController(TRAJECTORY, command, tuple(led), gains, state_topic=state)
