"""What a robot acts with, as data: drives, and controllers of joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import Literal

from nrp_core.world.rigid.pose import Vector

Rename = Callable[[str], str]


@dataclass(frozen=True, slots=True)
class WheelDrive:
    """A differential or skid-steer drive: a body velocity commanded as a Twist.

    Args:
        name: of the plugin.
        command_topic, odometry_topic, wheel_speeds_topic: absolute; None where there is none.
        left, right: names of the wheel joints, back to front.
        separation: effective distance of left and right wheels, m.
        wheel_diameter: m.
        torque: limit of each wheel, N m.
        timeout: seconds without a command after which the drive stops; ``inf`` for never.
        rate_hz: of odometry and wheel speeds.
    """

    name: str
    command_topic: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    wheel_diameter: float
    torque: float = inf
    timeout: float = 0.1
    rate_hz: float = 100.0
    odometry_topic: str | None = None
    wheel_speeds_topic: str | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it moves."""
        return (*self.left, *self.right)

    def renamed(self, named: Rename) -> WheelDrive:
        """Return the drive of a model whose parts have other names."""
        left, right = tuple(map(named, self.left)), tuple(map(named, self.right))
        return replace(self, name=named(self.name), left=left, right=right)


@dataclass(frozen=True, slots=True)
class PlanarMove:
    """A base that goes forward, sideways and turns as a Twist commands, without wheels.

    Its base slides without friction. Fields as those of :class:`WheelDrive`.
    """

    name: str
    command_topic: str
    timeout: float = inf
    rate_hz: float = 20.0
    odometry_topic: str | None = None
    wheel_speeds_topic: None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it moves: none."""
        return ()

    def renamed(self, named: Rename) -> PlanarMove:
        """Return the drive of a model whose parts have other names."""
        return replace(self, name=named(self.name))


@dataclass(frozen=True, slots=True)
class Ackermann:
    """A car: rear wheels at a body velocity, front wheels that steer.

    Args:
        left, right: names of the wheel joints, back to front.
        steering: joints that turn the left and the right front wheel.
        separation: distance of left and right wheels, m.
        wheel_base: distance of front and rear axle, m.
        wheel_diameter: m.
        max_steer: limit of the steering angle, rad.
        steers: whether ``angular.z`` commands the steering angle (Gazebo's ROS plugin, which steers to the
            other side in reverse), or the turn rate.
    """

    name: str
    command_topic: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    steering: tuple[str, str]
    separation: float
    wheel_base: float
    wheel_diameter: float
    max_steer: float = 0.6
    steers: bool = False
    torque: float = inf
    timeout: float = inf
    rate_hz: float = 100.0
    odometry_topic: str | None = None
    wheel_speeds_topic: str | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it moves."""
        return (*self.left, *self.right, *self.steering)

    def renamed(self, named: Rename) -> Ackermann:
        """Return the drive of a model whose parts have other names."""
        left, right = tuple(map(named, self.left)), tuple(map(named, self.right))
        steering = named(self.steering[0]), named(self.steering[1])
        return replace(self, name=named(self.name), left=left, right=right, steering=steering)


@dataclass(frozen=True, slots=True)
class Flight:
    """A body that moves along and turns about all its axes as a Twist commands, whatever carries it.

    Before the first command it falls. Fields as those of :class:`WheelDrive`.

    Args:
        initial: the velocities along its axes (m/s) and about them (rad/s) that it begins with, instead.
    """

    name: str
    command_topic: str
    initial: tuple[Vector, Vector] | None = None
    odometry_topic: None = None
    wheel_speeds_topic: None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it moves: none."""
        return ()

    def renamed(self, named: Rename) -> Flight:
        """Return the drive of a model whose parts have other names."""
        return replace(self, name=named(self.name))


PlanarDrive = WheelDrive | PlanarMove | Ackermann
"""What moves a body on the ground."""
Drive = PlanarDrive | Flight


@dataclass(frozen=True, slots=True)
class Pid:
    """Gains of a controller: force (N, N m) for each unit of error, of its integral, of its rate.

    ``i_limit`` bounds the force of the integral.
    """

    p: float = 0.0
    i: float = 0.0
    d: float = 0.0
    i_limit: float = inf


@dataclass(frozen=True, slots=True)
class JointController:
    """Lets one joint follow commands (``std_msgs/Float64``).

    Args:
        joint: its name.
        kind: what is commanded: a position (rad, m), a velocity or an effort (N m, N).
        topic: absolute.
        gains: of the error in position or in velocity, not used for efforts; None: such that the joint
            follows within some hundredths of a second, whatever it has to move.
        initial: what it aims at before the first command; None: nothing, the joint is free.
    """

    joint: str
    kind: Literal["position", "velocity", "effort"]
    topic: str
    gains: Pid | None = Pid()
    initial: float | None = None

    def renamed(self, named: Rename) -> JointController:
        """Return the controller of a model whose parts have other names."""
        return replace(self, joint=named(self.joint))


@dataclass(frozen=True, slots=True)
class TrajectoryController:
    """Lets joints follow trajectories (``trajectory_msgs/JointTrajectory``).

    Args:
        name: of the controller or its plugin.
        command_topic: absolute.
        joints: their names.
        gains: by joint, as those of :class:`JointController`; None for all that are not told.
        initial: by joint, where it is held before the first trajectory; the others are free.
        state_topic: where it tells what it does (``control_msgs/JointTrajectoryControllerState``); None for
            nowhere.
        rate_hz: of that.
    """

    name: str
    command_topic: str
    joints: tuple[str, ...]
    gains: tuple[tuple[str, Pid], ...] = ()
    initial: tuple[tuple[str, float], ...] = ()
    state_topic: str | None = None
    rate_hz: float = 50.0

    def of_joint(self, joint: str) -> JointController:
        """Return what leads one of its joints."""
        gains, initial = dict(self.gains).get(joint), dict(self.initial).get(joint)
        return JointController(joint, "position", self.command_topic, gains, initial)

    def renamed(self, named: Rename) -> TrajectoryController:
        """Return the controller of a model whose parts have other names."""
        return replace(
            self,
            joints=tuple(map(named, self.joints)),
            gains=tuple((named(joint), gains) for joint, gains in self.gains),
            initial=tuple((named(joint), position) for joint, position in self.initial),
        )
