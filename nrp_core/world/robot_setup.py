"""The additions of an experiment to a robot: its posture, sensors, and commands of its joints."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Code, Finding
from nrp_core.messages.base import resolve_name
from nrp_core.scene.bodies import free_name
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.devices import GroupController, JointController, Pid, TrajectoryController
from nrp_core.scene.model import Joint, Link, Model
from nrp_core.scene.posture import at_start
from nrp_core.scene.reading.context import Element, Notes, Reading, Resources
from nrp_core.scene.reading.plugins import find_registered
from nrp_core.scene.reading.sensors import (
    SENSORS,
    Mount,
    joint_sensors,
    link_sensors,
    sensor_types,
    with_frames,
    with_sensors,
)
from nrp_core.scene.reading.unread import find_unread
from nrp_core.scene.rigid import Pose
from nrp_core.scene.tessellation import box_around
from nrp_core.world.controllers.plugins import TOPICS


class _SensorError(SceneError):
    """An error in a sensor that is not in a file of its own."""

    def __init__(self, message: str, **_where: Any) -> None:
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class AddedSensor:
    """A sensor on a link, or in a joint.

    Args:
        type: the type of the ``<sensor>``: ``camera``, ``lidar``, ``imu``, ``contact`` and so on.
        link: the link that holds it, or the joint that it measures.
        name: unique on its link; by default its type.
        pose: in the frame of its link.
        rate_hz: messages per second.
        settings: further elements of the ``<sensor>``; nested elements are nested mappings.
    """

    type: str
    link: str
    name: str = ""
    pose: Pose = Pose()
    rate_hz: float = 30.0
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))


def with_added_sensors(model: Model, sensors: Iterable[AddedSensor]) -> Model:
    """Return a robot with further sensors.

    Raises:
        SceneError: a link does not exist, a type or an element of a sensor is unknown, or a value is invalid.
    """
    links, notes = list(model.links), Notes()
    for sensor in sensors:
        holders = {link.name: link for link in links}
        joints = {joint.name: joint.child for joint in model.joints}
        if sensor.link not in holders.keys() | joints.keys():
            hint = did_you_mean(sensor.link, [*holders, *joints])
            what = f"no link or joint '{sensor.link}' for an added sensor"
            raise SceneError(f"'{model.name}' has {what}{hint}")
        taken = {each.name for link in links if link.name == sensor.link for each in link.sensors}
        if sensor.name in taken:
            raise SceneError(f"'{model.name}/{sensor.link}' has a sensor of the name '{sensor.name}' already")
        name = sensor.name or free_name(sensor.type, taken)
        element = _element_of(replace(sensor, name=name))
        if name not in (sensor.name, sensor.type):
            held = f"'{model.name}/{sensor.link}' has a sensor '{sensor.type}' already"
            message = f"{held}: a further one without a name is called '{name}'"
            notes.warn(element, Code.NRP266, message, subject=name)
        holder = sensor.link if sensor.link in holders else joints[sensor.link]
        mount = Mount(sensor.link, partial(_place, sensor.pose))
        reading = Reading(Resources(()), notes, robot=model.name)
        read = link_sensors if sensor.link in holders else joint_sensors
        found = list(read([element], mount, reading))
        if not found:
            where = "a joint" if sensor.link in holders else "a link"
            raise SceneError(f"a sensor of type '{sensor.type}' is on {where}, which '{sensor.link}' is not")
        for unread in find_unread(element):
            if unread.message:
                raise _unknown(element, unread.message)
        links = with_sensors(links, holder, *found)
    links, misplaced = with_frames(links, model.joints)
    if misplaced:
        raise SceneError(f"'{model.name}/{misplaced[0].link}': {misplaced[0].message}")
    result = replace(model, links=tuple(links), warnings=(*model.warnings, *_without_place(notes)))
    result.check()
    return result


def _place(pose: Pose, part: Element) -> Pose:
    """Return the pose of the sensor, which is also that of its parts."""
    return pose if part.tag == "sensor" else Pose()


def _without_place(notes: Notes) -> Iterator[Finding]:
    """Yield the warnings, which are about no file."""
    return (replace(each, path=None, line=None) for each in notes.findings)


def _element_of(sensor: AddedSensor) -> Element:
    """Return the ``<sensor>``; each of its elements must exist."""
    if sensor.type not in sensor_types():
        hint = did_you_mean(sensor.type, sensor_types())
        raise SceneError(f"'{sensor.type}' is not a type of sensors{hint}")
    settings = {"update_rate": f"{sensor.rate_hz:.17g}", **sensor.settings}
    attributes = {"name": sensor.name, "type": sensor.type}
    (element,) = _elements("sensor", settings)
    element.attributes |= attributes
    reader = find_registered(SENSORS, sensor.type, element)
    if reader and "renderers" in reader.needs and not element.find("camera"):
        element.children += _elements("camera", {})  # of the default optics
    return element


def _unknown(sensor: Element, message: str) -> SceneError:
    text = message.replace(": ignored", "")
    return SceneError(f"the added sensor '{sensor.attribute('name')}': {text}")


def _elements(tag: str, value: Any) -> list[Element]:
    """Return the elements of a value in YAML: one, or one for each mapping in a list."""
    if isinstance(value, list | tuple) and all(isinstance(each, Mapping) for each in value) and value:
        return list(chain.from_iterable(_elements(tag, each) for each in value))
    element = Element(tag, {}, Path(), 0, kind=_SensorError)
    if isinstance(value, Mapping):
        for name, inner in value.items():
            if name.startswith("@"):  # an attribute
                element.attributes[name[1:]] = _text(inner)
            else:
                element.children += _elements(name, inner)
    else:
        element.text = element.raw_text = _text(value)
    return [element]


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return " ".join(map(_text, value))
    return str(value)


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
class RobotSetup:
    """What is added to a robot.

    Args:
        fixed: whether its base is fixed to the world; None: as in its file.
        keyframe: a start that its file names; empty for none.
        placed: whether an experiment states its pose, so that it is not that of the keyframe.
        on_ground: whether its lowest collision is at the height of its pose, or at 0 without one.
        starts: positions of joints at the start, rad or m.
        control: how joints are commanded, by regular expressions that match whole names of joints. These
            replace controllers of the same joints and quantities in the file.
        sensors: further sensors.
    """

    fixed: bool | None = None
    starts: tuple[tuple[str, float], ...] = ()
    control: tuple[tuple[str, JointControl], ...] = ()
    sensors: tuple[AddedSensor, ...] = ()
    keyframe: str = ""
    placed: bool = False
    on_ground: bool = False


def commandable(model: Model) -> list[Joint]:
    """Return the joints of a model that could be commanded."""
    return [joint for joint in model.joints if joint.coordinates and joint.mimic is None]


def without_commands(model: Model) -> list[Joint]:
    """Return the joints of a model that could be commanded, but that its file leaves without a controller."""
    led = {joint for each in (*model.leaders, *model.drives) for joint in each.joints}
    led |= {controller.joint for controller in model.controllers}
    return [joint for joint in commandable(model) if joint.name not in led]


def set_up_robot(model: Model, fitting: RobotSetup) -> Model:
    """Return a robot with the parts that an experiment adds.

    Raises:
        SceneError: a joint does not exist, cannot be commanded or cannot start at its given position, or a
            pattern matches no joint.
    """
    if fitting == RobotSetup():
        return model
    if model.static:
        return _set_up_static(model, fitting)
    model = _begin_at(model, fitting) if fitting.keyframe else model
    model = _fix_base(model, fitting.fixed)
    starts = {**dict(model.starts), **dict(_start(model, *start) for start in fitting.starts)}
    model = replace(model, starts=tuple(starts.items()))
    controls: dict[tuple[str, str], JointControl] = {}
    for pattern, control in fitting.control:
        for joint in _matching_joints(model, pattern, control):
            if (joint, control.mode) in controls:
                raise SceneError(f"two patterns give the joint '{joint}' of '{model.name}' a {control.mode}")
            controls[joint, control.mode] = control
    single = [
        _controller(model, joint, each)
        for (joint, mode), each in controls.items()
        if mode != "trajectory" and not each.group
    ]
    groups = (
        *(
            each
            for each in model.group_controllers
            if not controls.keys() & {(j, each.kind) for j in each.joints}
        ),
        *_groups(model, controls),
    )
    led = {joint: each for (joint, mode), each in controls.items() if mode == "trajectory"}
    kept = [each for each in model.controllers if (each.joint, each.kind) not in controls]
    leaders = model.trajectory_controllers
    if led:
        leaders = (*(each for each in leaders if not led.keys() & {*each.joints}), _leader(model, led))
    controllers = (*kept, *single)
    result = replace(model, controllers=controllers, trajectory_controllers=leaders, group_controllers=groups)
    if result.joint_states_topic is None and commandable(result):
        result = replace(result, joint_states_topic=resolve_name("joint_states", model.name))
    result.check()
    result = with_added_sensors(result, fitting.sensors)
    return _put_on_ground(result, fitting.placed) if fitting.on_ground else result


def _set_up_static(model: Model, fitting: RobotSetup) -> Model:
    """Return a robot that never moves, with its pose and further sensors; it supports no other settings."""
    fixed = fitting.fixed or None
    if replace(fitting, placed=False, on_ground=False, sensors=(), fixed=fixed) != RobotSetup(fixed=fixed):
        message = "it has no free base, and no keyframe, start or control of joints"
        raise SceneError(f"the robot '{model.name}' never moves (<static>), so {message}")
    result = with_added_sensors(model, fitting.sensors)
    return _put_on_ground(result, fitting.placed) if fitting.on_ground else result


def _begin_at(model: Model, fitting: RobotSetup) -> Model:
    """Return a robot that starts at a keyframe of its file; its position controllers hold it there."""
    known = {each.name: each for each in model.keyframes}
    if fitting.keyframe not in known:
        hint = did_you_mean(fitting.keyframe, known) if known else "; its file has none"
        raise SceneError(f"'{model.name}' has no keyframe '{fitting.keyframe}'{hint}")
    key = known[fitting.keyframe]
    held = {**dict(key.starts), **dict(fitting.starts), **dict(key.targets)}
    controllers = [
        replace(each, initial=held.get(each.joint, each.initial)) if each.kind == "position" else each
        for each in model.controllers
    ]
    pose = model.pose if fitting.placed or key.pose is None else key.pose
    return replace(model, pose=pose, starts=key.starts, controllers=tuple(controllers))


def _put_on_ground(model: Model, placed: bool) -> Model:
    """Return a robot whose lowest collision, at the initial joint positions, is at the height of its pose."""
    shapes = [
        (model.pose @ link.pose @ each.pose, each.geometry)
        for link in at_start(model).links
        for each in link.collisions
    ]
    box = box_around(shapes)
    if box is None:
        raise SceneError(f"'{model.name}' cannot be put on the ground: it has no collisions")
    x, y, z = model.pose.position
    ground = z if placed else 0.0
    return replace(model, pose=replace(model.pose, position=(x, y, z + ground - float(box[0][2]))))


def _fix_base(model: Model, fixed: bool | None) -> Model:
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
        raise SceneError(
            f"'{model.name}' has no joint '{name}' that takes commands{did_you_mean(name, joints)}"
        )
    lower, upper = joints[name].lower, joints[name].upper
    if not lower <= position <= upper:
        limits = f"{lower:g} to {upper:g}"
        raise SceneError(
            f"the joint '{name}' of '{model.name}' cannot start at {position:g}: its limits are {limits}"
        )
    return name, position


def _matching_joints(model: Model, pattern: str, control: JointControl) -> list[str]:
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
    return JointController(joint, control.mode, topic, gains, holds=control.mode == "position")


def _groups(model: Model, controls: Mapping[tuple[str, str], JointControl]) -> Iterator[GroupController]:
    """Yield the controllers of groups; the numbers of each are in the order of the joints in the file."""
    groups: dict[str, dict[str, JointControl]] = {}
    for joint in model.joints:
        for (name, _), control in controls.items():
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
    return TrajectoryController(TRAJECTORY, command, tuple(led), gains, state_topic=state, holds=True)


_NONE: Final[Mapping[str, str]] = MappingProxyType({})
_PLAIN: Final = re.compile(r"(?:\.{1,2}/|[A-Za-z_/])[\w/.-]*")
_WORDS: Final = ("null", "true", "false", "yes", "no", "on", "off", "y", "n")
"""Words that some version of YAML takes for something else than a text."""


def section_for(model: Model, file: str, args: Mapping[str, str] = _NONE) -> Iterator[str]:
    """Yield the lines of an experiment file that give a robot's joints commands.

    Args:
        model: the robot.
        file: its file, as the experiment names it.
        args: the arguments that it was expanded with.
    """
    modes = {joint.name: _mode(model, joint) for joint in without_commands(model)}
    yield from ("robots:", f"  {_quote(_identifier(model.name))}:", f"    model: {_quote(file)}")
    if args:
        given = ", ".join(f"{_quote(name)}: {json.dumps(value)}" for name, value in args.items())
        yield f"    args: {{{given}}}"
    yield "    control:"
    if len(modes) == len(commandable(model)) and len({*modes.values()}) == 1:
        yield f'      ".*": {{mode: {next(iter(modes.values()))}}}'
        return
    for joint, mode in modes.items():
        yield f"      {_quote(re.escape(joint))}: {{mode: {mode}}}"


def models_for(folders: Iterable[Path]) -> str:
    """Return the line of an experiment file with the folders in which the parts of robots are searched."""
    return f"models: [{', '.join(_quote(str(folder)) for folder in folders)}]"


def sensors_for(model: Model) -> Iterator[str]:
    """Yield lines, as comments in the section of a robot, that would give it sensors."""
    link = _quote(model.links[0].name)
    image = "camera: {horizontal_fov: 1.2, image: {width: 160, height: 120}}"
    yield "    # add_sensors:"
    yield f"    #   - {{type: imu, link: {link}, rate: 100 Hz}}"
    yield f"    #   - {{type: camera, link: {link}, pose: [0.1, 0, 0.1, 0, 0, 0], {image}}}"


def _mode(model: Model, joint: Joint) -> str:
    needs = {need for drive in model.drives for need in drive.needs}
    if joint.takes_commands and needs & {"muscles", "own_actuators", "wrapping"}:
        return "effort"  # a servo would hold it against these, and OpenSim has none
    return "velocity" if joint.kind == "continuous" else "position"


def _quote(text: str) -> str:
    """Return a text in YAML: unchanged if YAML reads it as a text, else quoted."""
    plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS
    return text if plain else json.dumps(text, ensure_ascii=False)


def _identifier(name: str) -> str:
    """Return a name as that of a robot in an experiment."""
    plain = re.sub(r"\W", "_", name)
    return plain if plain.isidentifier() else f"robot_{plain}"
