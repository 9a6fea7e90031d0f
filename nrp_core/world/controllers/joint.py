"""Controllers of joints: of single ones, of ball joints, of groups, and of pairs by mean and difference."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf, isclose, isfinite, sqrt
from operator import le
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import seconds
from nrp_core.errors import TopicError
from nrp_core.findings import Code
from nrp_core.messages.geometry_msgs import Quaternion
from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.scene.devices import (
    GroupController,
    JointController,
    PairController,
    TrajectoryController,
)
from nrp_core.scene.merged_bodies import stiff_gains
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import JointTargets, ServoTarget, rotation_by
from nrp_core.scene.rigid import Quaternion as Orientation
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, TopicInfo, require_finite

_TOLERANCE = 0.01
"""How far a quaternion may be from a unit quaternion; it is normalised."""

_ROUNDING = 1e-6
"""By how much a command in 32 bits, or a sum, may be beyond a limit without a report."""


class OrientationPart(Part):
    """Leads a ball joint to the orientations of its controller, until the first one to that of its start.

    Args:
        controller: the data of the controller.
        model: the name of the model of the joint.
        engine: the engine that moves it.
    """

    def __init__(self, controller: JointController, model: str, engine: Engine) -> None:
        self._joint, self._model, self._engine = controller.joint, model, engine
        what = f"orientation of the child of {model}/{controller.joint} in the joint's frame"
        self.topics = (TopicInfo(controller.topic, Quaternion, Direction.IN, what=what),)
        self._wanted: Orientation | None = None
        self._holds = controller.holds
        self._is_start = False

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        x, y, z, w = (float(each) for each in (message.x, message.y, message.z, message.w))
        norm = sqrt(x * x + y * y + z * z + w * w)
        if not (isfinite(norm) and abs(norm - 1.0) <= _TOLERANCE):
            raise TopicError(f"{topic}: ({x:g}, {y:g}, {z:g}, {w:g}) is not a unit quaternion")
        self._is_start = False
        self._set_target((x / norm, y / norm, z / norm, w / norm))

    def begin(self) -> None:
        if self._holds and self._wanted is None and self._engine.capabilities.joint_control:
            self._hold()

    def _hold(self) -> None:
        """Hold the present orientation until the first command."""
        joints = self._engine.joint_states(self._model)
        x, y, z = (float(joints.positions[joints.names.index(f"{self._joint}_{axis}")]) for axis in "xyz")
        self._is_start = True
        self._set_target(rotation_by((x, y, z)))

    def on_model_moved(self) -> None:
        if self._is_start:
            self._hold()

    def reset(self) -> None:
        self._wanted, self._is_start = None, False

    def save(self) -> object:
        return self._wanted, self._is_start

    def restore(self, saved: Any) -> None:
        before = self._wanted
        wanted, self._is_start = saved
        if wanted is not None or before is not None:
            self._set_target(wanted)

    def _set_target(self, orientation: Orientation | None) -> None:
        self._wanted = orientation
        self._engine.set_ball_target(self._model, self._joint, orientation)


_LINEAR = {"position": "m", "velocity": "m/s", "effort": "N"}
_ANGULAR = {"position": "rad", "velocity": "rad/s", "effort": "N m"}


class Target(NamedTuple):
    """The target of a controller: a position, velocity or effort.

    ``rate`` is the rate of change of a position. ``smooth``: it is approached smoothly; otherwise it is a
    point of a path, for the end of the next step.
    """

    value: float
    rate: float = 0.0
    smooth: bool = True


Command = tuple[str, Target]
"""A topic and its target."""
Inertias = Callable[[], Mapping[str, float]]
"""Returns the inertia that each joint of a model moves, which takes long to compute."""


def unit_of(model: Model, joint: str, kind: str) -> str:
    """Return the unit of the position, velocity or effort of a joint."""
    slides = any(each.name == joint and each.kind == "prismatic" for each in model.joints)
    return (_LINEAR if slides else _ANGULAR)[kind]


class ControllerPart(Part):
    """Serves the commands of the :class:`~nrp_core.scene.devices.JointController` of one joint.

    A command holds until the next one to any of the controllers. The engine's servo computes the proportional
    and the derivative part in each physics step; the integral part is computed here.

    Args:
        controllers: all controllers of the joint that take commands.
        led: the controller that trajectories use, if any.
        model: the model of the joint.
        engine: the engine that moves it.
        inertias: returns the inertias of the joints of the model.

    Attributes:
        joint, model, engine: the names of the joint and its model, and the engine.
    """

    def __init__(
        self,
        controllers: Sequence[JointController],
        led: Sequence[JointController],
        model: Model,
        engine: Engine,
        inertias: Inertias,
    ) -> None:
        every = (*led, *controllers)
        self.joint, self.model, self.engine = every[0].joint, model.name, engine
        self._laws = {controller.topic: _Law(controller, model, inertias) for controller in every}
        units = {each.kind: unit_of(model, self.joint, each.kind) for each in controllers}
        self.topics = tuple(
            TopicInfo(
                each.topic, Float64, Direction.IN, unit=units[each.kind],
                what=f"{each.kind} of {model.name}/{each.joint}, {units[each.kind]}",
            )
            for each in controllers
        )  # fmt: skip
        starts = [(each.topic, Target(each.initial)) for each in every if each.initial is not None]
        self._holder = next((each.topic for each in every if each.holds), None)
        if self._holder is not None:  # a motor of the file at speed 0 does not release a held object
            starts = [each for each in starts if self._laws[each[0]].controller.kind == "position"]
        self._initial = starts[-1] if starts else None
        self._own = self._initial
        self._start: Command | None = None
        self._leader: JointGroup | None = None
        self._number = 0
        self._integral = 0.0
        self._exceeded = set[str]()

    @property
    def obeys(self) -> str | None:
        """The topic of the last command; None before the first."""
        return self._command and self._command[0]

    @property
    def _command(self) -> Command | None:
        """The topic that leads the joint, and its target; None before the first command."""
        return self._own if self._leader is None else self._leader.command(self._number)

    @_command.setter
    def _command(self, command: Command | None) -> None:
        if self._leader is not None:
            self._leader.release()
        self._own, self._leader = command, None

    def follow(self, leader: JointGroup, number: int) -> None:
        """Let a leader keep the command from now on, until the next one of another topic.

        Args:
            leader: the leader.
            number: its number for this joint.
        """
        self._leader, self._number = leader, number

    def is_firm(self, topic: str) -> bool:
        """Return whether the joint follows the commands of a topic with any load."""
        return self._laws[topic].controller.is_firm

    def takes_efforts(self, topic: str) -> bool:
        """Return whether the commands of a topic are efforts."""
        return self._laws[topic].controller.kind == "effort"

    def limits(self, topic: str) -> tuple[float, float]:
        """Return the limits of the targets of a topic."""
        return self._laws[topic].lower, self._laws[topic].upper

    def has_reported(self, topic: str) -> bool:
        """Return whether a target of a topic beyond the limits was reported."""
        return topic in self._exceeded

    @property
    def has_deadlines(self) -> bool:
        return any(law.integrates for law in self._laws.values())

    @property
    def target(self) -> Target:
        """The target of the last command, after the first."""
        assert self._command is not None
        return self._command[1]

    def target_now(self, kind: str) -> float:
        """Return the commanded position or velocity, or else the joint's present one."""
        topic, target = self._command or ("", Target(0.0))
        is_commanded = bool(topic) and self._laws[topic].controller.kind == kind
        return target.value if is_commanded else self._now(kind)

    def lead(self, topic: str, target: Target, now_ns: int) -> None:
        """Make a topic the source of the command from now on."""
        if self.obeys not in (topic, None):
            self._integral = 0.0
        bounded = self._laws[topic].within_limits(target)
        is_beyond = not isclose(bounded.value, target.value, rel_tol=_ROUNDING, abs_tol=_ROUNDING)
        if is_beyond and topic not in self._exceeded:
            self._report(topic, target.value, bounded.value)
        self._command = topic, bounded
        self._set_target(now_ns)

    def _report(self, topic: str, value: float, limit: float) -> None:
        """Report the first command on a topic that is beyond the limits of the joint."""
        self._exceeded.add(topic)
        beyond = f"beyond the limit of the joint '{self.joint}'"
        message = f"a command on {topic} is {value:g}, {beyond}: {limit:g} is used"
        self.engine.warnings.add(Code.NRP299, message, subject=topic)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self.lead(topic, Target(float(message.data)), now_ns)

    def at_deadline(self, now_ns: int) -> None:
        assert self._command is not None  # without a target, no deadline
        topic, target = self._command
        law = self._laws[topic]
        gains, error = law.gains, target.value - self._now(law.controller.kind)
        integral = self._integral + gains.i * error * seconds(self.engine.step_ns)
        self._integral = min(max(integral, -gains.i_limit), gains.i_limit)
        self._set_target(now_ns)

    def begin(self) -> None:
        if self._initial is not None:
            self._set_target(0)
        elif self._holder is not None and self._command is None and self.engine.capabilities.joint_control:
            self._hold(self._holder)

    def _hold(self, topic: str) -> None:
        """Hold the present position until the first command."""
        self._command = self._start = topic, Target(self._now("position"))
        self._set_target(self.engine.now_ns)

    def on_model_moved(self) -> None:
        if self._start is not None and self._command == self._start:
            self._hold(self._start[0])

    def reset(self) -> None:
        self._command, self._integral, self._start = self._initial, 0.0, None
        self.deadline_ns = None

    def save(self) -> object:
        return self._command, self._integral, self.deadline_ns, self._start

    def restore(self, saved: Any) -> None:
        before = self._command
        self._command, self._integral, deadline_ns, self._start = saved
        if before is not None or self._command is not None:
            self._set_target(0)
        self.deadline_ns = deadline_ns

    def _set_target(self, now_ns: int) -> None:
        self.deadline_ns, aim = None, ServoTarget()
        if self._command is not None:
            topic, target = self._command
            law = self._laws[topic]
            aim = law.servo_target(target, self._integral)
            if law.integrates:
                self.deadline_ns = now_ns + self.engine.step_ns
        self.engine.set_servo_target(self.model, self.joint, aim)

    def _now(self, kind: str) -> float:
        """Return the position or the velocity of the joint."""
        joints = self.engine.joint_states(self.model)
        values = joints.positions if kind == "position" else joints.velocities
        return float(values[joints.names.index(self.joint)])


class _Law:
    """The settings of a joint's servo while one of its controllers has the last command."""

    def __init__(self, controller: JointController, model: Model, inertias: Inertias) -> None:
        self.controller = controller
        joint = next(joint for joint in model.joints if joint.name == controller.joint)
        self.gains = controller.gains or stiff_gains(
            inertias()[joint.name], velocity=controller.kind == "velocity"
        )
        self.integrates = bool(self.gains.i) and controller.kind != "effort"
        # without gains the velocity is set directly, against any damping
        self._braking = joint.damping if controller.gains is None else 0.0
        lower, upper = {
            "position": (-inf, inf) if controller.beyond else (joint.lower, joint.upper),
            "velocity": (-joint.velocity, joint.velocity),
            "effort": (-joint.effort, joint.effort),
        }[controller.kind]
        self.lower, self.upper = max(lower, controller.range[0]), min(upper, controller.range[1])

    def within_limits(self, target: Target) -> Target:
        """Return a command within the limits of the joint."""
        value = min(max(target.value, self.lower), self.upper)
        return target if value == target.value else Target(value, 0.0, target.smooth)

    def servo_target(self, target: Target, integral: float) -> ServoTarget:
        """Return the target of the servo."""
        gains, value = self.gains, target.value
        firm = target.smooth if self.controller.is_firm else None
        if self.controller.kind == "position":
            effort = integral + self._braking * target.rate
            return ServoTarget(gains.p, gains.d, value, target.rate, effort, firm)
        if self.controller.kind == "velocity":
            effort = integral + self._braking * value
            return ServoTarget(damping=gains.p, velocity=value, effort=effort, firm=firm)
        return ServoTarget(effort=value)


C = TypeVar("C", GroupController, PairController, TrajectoryController)


class JointGroup:
    """Leads joints of a model, firm ones and those that are given efforts with one call of the engine.

    Args:
        topics: the topic that leads each of them.
        parts: the controller part of each joint.
        model: their model.
        engine: the engine that moves it.
    """

    def __init__(
        self, topics: Sequence[str], parts: Mapping[str, ControllerPart], model: str, engine: Engine
    ) -> None:
        self._topics, self._model, self._engine = topics, model, engine
        self._joints, self._parts = tuple(parts), list(parts.values())
        each = list(zip(self._parts, topics, strict=True))
        self._are_efforts = all(part.takes_efforts(topic) for part, topic in each)
        self._at_once = self._are_efforts or all(part.is_firm(topic) for part, topic in each)
        self._lowest, self._highest = zip(*(part.limits(topic) for part, topic in each), strict=True)
        self._targets = JointTargets(self._joints, (), (), smooth=True)
        self._holds = False

    def command(self, number: int) -> tuple[str, Target]:
        """Return the topic and the target of a joint that follows."""
        targets = self._targets
        rate = targets.rates[number] if targets.rates else 0.0
        return self._topics[number], Target(float(targets.values[number]), rate, targets.smooth)

    def release(self) -> None:
        """Record that one of the joints received another command."""
        self._holds = False

    def lead(self, targets: JointTargets, now_ns: int) -> None:
        """Make targets the commands of joints.

        Args:
            targets: the targets; faster if they are of all joints, in their order.
            now_ns: the time.
        """
        if self._holds and self._joints == targets.joints and self._retarget(targets):
            return
        rates = targets.rates or [0.0] * len(targets.joints)
        for joint, value, rate in zip(targets.joints, targets.values, rates, strict=True):
            number = self._joints.index(joint)
            self._parts[number].lead(self._topics[number], Target(value, rate, targets.smooth), now_ns)
        if self._at_once and len(targets.joints) == len(self._parts):
            kept = [part.target for part in self._parts]
            self._targets = JointTargets(
                self._joints, [each.value for each in kept], [each.rate for each in kept], targets.smooth
            )
            for number, part in enumerate(self._parts):
                part.follow(self, number)
            self._holds = True

    @staticmethod
    def lead_all(groups: Sequence[JointGroup], rows: FloatArray) -> list[int]:
        """Make efforts the commands of all joints of the same group in several engines, a row for each.

        Returns:
            The numbers of the groups that have to be led one by one.
        """
        first = groups[0]
        inside = ((rows >= first._lowest) & (rows <= first._highest)).all(axis=1)
        within = set(np.flatnonzero(inside).tolist())
        alike = first._lowest, first._highest
        at_once = [
            number
            for number, group in enumerate(groups)
            if number in within and group._holds and alike == (group._lowest, group._highest)
        ]
        if at_once:
            engines = [groups[number]._engine for number in at_once]
            chosen = rows if len(at_once) == len(rows) else rows[at_once]
            type(engines[0]).set_servo_efforts_of(engines, first._model, first._joints, chosen)
            for number, values in zip(at_once, chosen, strict=True):
                groups[number]._targets = JointTargets(first._joints, values, (), True)
        done = set(at_once)
        return [number for number in range(len(groups)) if number not in done]

    def lead_each(self, values: Sequence[float], now_ns: int) -> None:
        """Make targets the commands of all joints, in their order."""
        self.lead(JointTargets(self._joints, values, (), smooth=True), now_ns)

    def _retarget(self, targets: JointTargets) -> bool:
        """Change the targets at once, if the engine supports it and no joint newly exceeds its limits."""
        values, lowest, highest = targets.values, self._lowest, self._highest
        if not (all(map(le, lowest, values)) and all(map(le, values, highest))):
            kept = [min(max(each), high) for *each, high in zip(values, lowest, highest, strict=True)]
            beyond = [number for number, value in enumerate(values) if kept[number] != value]
            if targets.rates or not all(
                self._parts[number].has_reported(self._topics[number]) for number in beyond
            ):
                return False
            targets = targets._replace(values=kept)
        if self._are_efforts:
            self._engine.set_servo_efforts(self._model, self._joints, targets.values)
        elif not self._engine.retarget(self._model, targets):
            return False
        self._targets = targets
        return True


def effort_group(topics: Sequence[str], parts: Sequence[Part]) -> JointGroup | None:
    """Return what leads joints by efforts at once; None if the topics do not command efforts of one model.

    Args:
        topics: a topic for each joint.
        parts: the parts of these topics.
    """
    chosen = [part for part in parts if type(part) is ControllerPart]
    if len(chosen) < len(parts) or not all(map(ControllerPart.takes_efforts, chosen, topics)):
        return None
    joints, models = {part.joint: part for part in chosen}, {part.model for part in chosen}
    if len(models) > 1 or len(joints) < len(chosen):
        return None
    return JointGroup(topics, joints, chosen[0].model, chosen[0].engine)


class JointsPart(Part, Generic[C]):
    """Leads the joints of one controller of several joints.

    Args:
        controller: the data of the controller.
        parts: the controller part of each joint.
        model: the model of the joints.
        engine: the engine that moves it.
    """

    def __init__(
        self, controller: C, parts: Mapping[str, ControllerPart], model: Model, engine: Engine
    ) -> None:
        self._controller: C = controller
        self._model, self._engine = model, engine
        self._parts = {joint: parts[joint] for joint in controller.joints}
        self._open()

    def _open(self) -> None:
        """Set the topics and the other data of the part."""
        raise NotImplementedError


class GroupPart(JointsPart[GroupController]):
    """Leads the joints of one :class:`~nrp_core.scene.devices.GroupController`."""

    def _open(self) -> None:
        controller, model = self._controller, self._model.name
        topics = [controller.topic] * len(self._parts)
        self._led = JointGroup(topics, self._parts, model, self._engine)
        what = f"{controller.kind} of {', '.join(controller.joints)} of {model}"
        joints = tuple(controller.joints)
        topic = TopicInfo(controller.topic, Float64MultiArray, Direction.IN, what=what, elements=joints)
        self.topics = (topic,)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        joints = self._controller.joints
        if (count := len(message.data)) != len(joints):
            name = self._controller.name
            raise TopicError(f"{topic}: '{name}' has {len(joints)} joints; {count} numbers came")
        values = np.asarray(message.data, dtype=float).tolist()
        require_finite(topic, values)
        self._led.lead(JointTargets(joints, values, (), smooth=True), now_ns)


class PairPart(JointsPart[PairController]):
    """Leads the joints of one :class:`~nrp_core.scene.devices.PairController`."""

    def _open(self) -> None:
        controller, model = self._controller, self._model
        first, second = controller.joints
        unit = unit_of(model, first, controller.kind)
        what = f"{controller.kind} of {model.name}/{controller.name}, {unit}: "
        what += f"the {controller.of} of {first} and {second}"
        self.topics = (TopicInfo(controller.topic, Float64, Direction.IN, what=what, unit=unit),)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        controller = self._controller
        first, second = (part.target_now(controller.kind) for part in self._parts.values())
        values = controller.split(float(message.data), first, second)
        for part, value in zip(self._parts.values(), values, strict=True):
            part.lead(topic, Target(value), now_ns)
