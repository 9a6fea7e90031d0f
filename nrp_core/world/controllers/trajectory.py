"""Joints that follow trajectories."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import TopicError, did_you_mean
from nrp_core.messages.base import Time, invalid_field, ns_of, type_name
from nrp_core.messages.control_msgs import JointTrajectoryControllerState
from nrp_core.messages.std_msgs import Header
from nrp_core.messages.trajectory_msgs import JointTrajectory, JointTrajectoryPoint
from nrp_core.scene.devices import TrajectoryController
from nrp_core.scene.rigid import JointTargets
from nrp_core.world.controllers.joint import JointGroup, JointsPart
from nrp_core.world.topics import Direction, TopicInfo


@dataclass(frozen=True, slots=True)
class Knot:
    """Position of a joint at a time; velocity and acceleration if they are given.

    Args:
        t_ns: the time.
        position: rad or m.
        velocity: rad/s or m/s.
        acceleration: rad/s^2 or m/s^2.
    """

    t_ns: int
    position: float
    velocity: float | None = None
    acceleration: float | None = None


@dataclass(frozen=True, slots=True)
class JointPath:
    """A path from its first knot to its last, where the joint stays.

    Between two knots it is a line; a cubic if both have velocities; a quintic if both also have
    accelerations. See http://wiki.ros.org/joint_trajectory_controller/UnderstandingTrajectoryReplacement.

    Args:
        knots: the knots in order of time, at least one.
        before: the path until the first knot; None: undefined until then.
    """

    knots: tuple[Knot, ...]
    before: JointPath | None = None

    def at(self, t_ns: int) -> Knot | None:
        """Return position, velocity and acceleration at a time; None before the path begins."""
        following = bisect_right(self.knots, t_ns, key=lambda knot: knot.t_ns)
        if not following:
            return None if self.before is None else self.before.at(t_ns)
        if following == len(self.knots):
            return Knot(t_ns, self.knots[-1].position, 0.0, 0.0)
        start, end = self.knots[following - 1 : following + 1]
        elapsed_s = seconds(t_ns - start.t_ns)
        position = velocity = acceleration = 0.0
        for coefficient in reversed(_coefficients(start, end)):  # Horner's scheme, for the derivatives, too
            acceleration = acceleration * elapsed_s + 2 * velocity
            velocity = velocity * elapsed_s + position
            position = position * elapsed_s + coefficient
        return Knot(t_ns, position, velocity, acceleration)

    def is_over(self, t_ns: int) -> bool:
        """Whether its last knot is reached."""
        return t_ns >= self.knots[-1].t_ns

    def since(self, t_ns: int) -> JointPath:
        """Return the path, without the earlier paths if it has begun."""
        if self.before is None:
            return self
        return replace(self, before=None if t_ns >= self.knots[0].t_ns else self.before.since(t_ns))

    def until(self, t_ns: int) -> JointPath | None:
        """Return the path without the paths that would begin at a time or later."""
        if self.knots[0].t_ns < t_ns:
            return self
        return None if self.before is None else self.before.until(t_ns)


def _coefficients(start: Knot, end: Knot) -> Sequence[float]:
    """Return the coefficients of the polynomial in the seconds after ``start`` that leads to ``end``."""
    t = seconds(end.t_ns - start.t_ns)
    x, v0, v1 = end.position - start.position, start.velocity, end.velocity
    if v0 is None or v1 is None:
        return start.position, x / t
    a0, a1 = start.acceleration, end.acceleration
    if a0 is None or a1 is None:
        return start.position, v0, (3 * x / t - 2 * v0 - v1) / t, (v0 + v1 - 2 * x / t) / t**2
    return (
        start.position,
        v0,
        a0 / 2,
        (20 * x - (8 * v1 + 12 * v0) * t - (3 * a0 - a1) * t**2) / (2 * t**3),
        (-30 * x + (14 * v1 + 16 * v0) * t + (3 * a0 - 2 * a1) * t**2) / (2 * t**4),
        (12 * x - 6 * (v1 + v0) * t - (a0 - a1) * t**2) / (2 * t**5),
    )


_LARGEST = 1e30  # also for a number in a file
_LATEST_NS = 2**62
"""Times beyond this, 146 years, are mistakes."""


class TrajectoryPart(JointsPart[TrajectoryController]):
    """Moves the joints of one :class:`~nrp_core.scene.devices.TrajectoryController`.

    A trajectory replaces the previous one from its start on, for the joints that it names; one without points
    stops them at their present targets. A joint that gets another command leaves the trajectory.
    """

    def _open(self) -> None:
        controller, model = self._controller, self._model
        topics = [controller.command_topic] * len(self._parts)
        self._led = JointGroup(topics, self._parts, model.name, self._engine)
        self._turning = {joint.name for joint in model.joints if joint.kind == "continuous"}
        self._paths: dict[str, JointPath] = {}
        what = f"trajectory of {', '.join(controller.joints)} of {model.name}"
        infos = [TopicInfo(controller.command_topic, JointTrajectory, Direction.IN, what=what)]
        if controller.state_topic is not None:
            kind, rate_hz = JointTrajectoryControllerState, controller.rate_hz
            what = f"state of the controller '{controller.name}' of {model.name}"
            infos.append(TopicInfo(controller.state_topic, kind, Direction.OUT, rate_hz, what))
        self.topics = tuple(infos)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        joints = self._joints_of(message)
        stamp_ns = ns_of(message.header.stamp)
        start_ns = max(stamp_ns, now_ns)
        rows = knots_of(message.points, len(joints), stamp_ns or now_ns, topic)
        if rows and rows[-1][0].t_ns < now_ns:
            ended_s, now_s = seconds(rows[-1][0].t_ns), seconds(now_ns)
            raise TopicError(
                f"{topic}: the trajectory ended at {ended_s:g} s and arrived too late, at {now_s:g} s"
            )
        for number, joint in enumerate(joints):
            self._replace(joint, [row[number] for row in rows], start_ns, now_ns)
        self._follow_trajectory(now_ns)

    def at_deadline(self, now_ns: int) -> None:
        self._paths = {joint: path for joint in self._paths if (path := self._path(joint, now_ns))}
        self._follow_trajectory(now_ns)

    def read(self, topic: str, now_ns: int) -> JointTrajectoryControllerState:
        joints, states = self._controller.joints, self._engine.joint_states(self._model.name)
        rows = [states.names.index(joint) for joint in joints]
        position, velocity = states.positions[rows], states.velocities[rows]
        aims = [self._target_at(joint, now_ns, now_ns) for joint in joints]
        aim = np.array([x if aim is None else aim.position for x, aim in zip(position, aims, strict=True)])
        rate = np.array([aim.velocity or 0.0 if aim else 0.0 for aim in aims])
        return JointTrajectoryControllerState(
            Header(Time.from_ns(now_ns)),
            list(joints),
            JointTrajectoryPoint(aim, rate),
            JointTrajectoryPoint(position, velocity),
            JointTrajectoryPoint(aim - position, rate - velocity),
        )

    def reset(self) -> None:
        self._paths, self.deadline_ns = {}, None

    def save(self) -> object:
        return dict(self._paths), self.deadline_ns

    def restore(self, saved: Any) -> None:
        paths, self.deadline_ns = saved
        self._paths = dict(paths)

    def _joints_of(self, message: Any) -> list[str]:
        """Return the joints that a trajectory names; all joints if it names none, which stops them."""
        topic, known = self._controller.command_topic, self._controller.joints
        for field in ("joint_names", "points"):
            if not isinstance(getattr(message, field), list | tuple):
                raise TopicError(f"{topic}: {field} must be a list, not {getattr(message, field)!r:.60}")
        names = list(message.joint_names)
        for name in names:
            if name not in known:
                raise TopicError(
                    f"{topic}: the controller has no joint '{name}'{did_you_mean(str(name), known)}"
                )
        if len(set(names)) < len(names) or (message.points and not names):
            raise TopicError(f"{topic}: a trajectory must name each of its joints once, not {names}")
        return names or list(known)

    def _path(self, joint: str, now_ns: int) -> JointPath | None:
        """Return the path of a joint; None if it has none, or after another command."""
        path, obeys = self._paths.get(joint), self._parts[joint].obeys
        is_left = path is not None and path.at(now_ns) is not None and obeys != self._controller.command_topic
        return None if is_left else path

    def _target_at(self, joint: str, t_ns: int, now_ns: int) -> Knot | None:
        """Return the target of a joint at a time, by the present path; None if it has none."""
        path = self._path(joint, now_ns)
        return None if path is None else path.at(t_ns)

    def _replace(self, joint: str, knots: Sequence[Knot], start_ns: int, now_ns: int) -> None:
        """Give a joint a path through knots, from its target at a time."""
        path, start = self._path(joint, now_ns), self._target_at(joint, start_ns, now_ns)
        if start is None:
            start = self._here(joint, start_ns)
        if joint in self._turning and knots:  # the shorter way round
            turns = round((start.position - knots[0].position) / (2 * pi))
            knots = [replace(knot, position=knot.position + 2 * pi * turns) for knot in knots]
        ahead = [knot for knot in knots if knot.t_ns > start_ns]
        first = [] if knots and not ahead else [start]  # the trajectory is to be reached at once
        before = None if path is None else path.since(now_ns).until(start_ns)
        self._paths[joint] = JointPath((*first, *(ahead or knots[-1:])), before)

    def _here(self, joint: str, t_ns: int) -> Knot:
        states = self._engine.joint_states(self._model.name)
        row = states.names.index(joint)
        return Knot(t_ns, float(states.positions[row]), float(states.velocities[row]), 0.0)

    def _follow_trajectory(self, now_ns: int) -> None:
        """Set each joint's target for the end of the next step, where its servo acts."""
        end_ns = now_ns + self._engine.step_ns
        aims = {joint: aim for joint, path in self._paths.items() if (aim := path.at(end_ns))}
        values, rates = (
            [aim.position for aim in aims.values()],
            [aim.velocity or 0.0 for aim in aims.values()],
        )
        self._led.lead(JointTargets(tuple(aims), values, rates, smooth=False), now_ns)
        moves = any(not path.is_over(now_ns) for path in self._paths.values())
        self.deadline_ns = end_ns if moves else None


def knots_of(points: Sequence[Any], joints: int, begin_ns: int, name: str) -> list[list[Knot]]:
    """Return the knots of each point of a trajectory, one for each joint.

    Args:
        points: messages ``trajectory_msgs/JointTrajectoryPoint``.
        joints: the number of joints.
        begin_ns: start time of the trajectory, ns.
        name: the name of the topic or action, for errors.

    Raises:
        TopicError: a point has too few or too many numbers, or is not later than the previous one.
    """
    rows: list[list[Knot]] = []
    for number, point in enumerate(points):
        if type_name(type(point)) != type_name(JointTrajectoryPoint):
            raise TopicError(f"{name}: point {number} must be a JointTrajectoryPoint, not {point!r:.60}")
        if wrong := invalid_field(point):
            raise TopicError(f"{name}: point {number}: {wrong}")
        t_ns = begin_ns + ns_of(point.time_from_start)
        if t_ns < (rows[-1][0].t_ns + 1 if rows else begin_ns):
            raise TopicError(f"{name}: point {number} is not later than the one before it")
        if t_ns > _LATEST_NS:
            raise TopicError(
                f"{name}: point {number} is {seconds(t_ns):g} s after the start of the run, too late"
            )
        columns = [
            _numbers(
                getattr(point, field), joints, field != "positions", f"{name}: the {field} of point {number}"
            )
            for field in ("positions", "velocities", "accelerations")
        ]
        rows.append([Knot(t_ns, *values) for values in zip(*columns, strict=True)])
    return rows


def _numbers(values: Any, count: int, may_lack: bool, what: str) -> Sequence[Any]:
    try:
        numbers = np.asarray(values, float)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if may_lack and numbers.shape == (0,):
        return [None] * count
    if numbers.shape != (count,) or not (abs(numbers) < _LARGEST).all():
        given = f"{values!r:.60}"
        raise TopicError(
            f"{what} must be one number below {_LARGEST:g} for each of {count} joints, not {given}"
        )
    finite: list[float] = numbers.tolist()
    return finite
