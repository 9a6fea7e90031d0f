"""Drives and controllers of joints in a scene: the data for files and engines.

Each drive is a class in :mod:`nrp_core.world.drives` or in another package.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import Literal, Self

Rename = Callable[[str], str]
ControllerKind = Literal["position", "velocity", "effort"]
"""The quantity that a controller of joints commands."""


@dataclass(frozen=True, slots=True)
class MountedDrive(ABC):
    """A drive of a model: it moves the whole body as commanded.

    Args:
        name: the name of the plugin.
        command_topic: the absolute topic of commands.
    """

    name: str
    command_topic: str

    @property
    def odometry_topic(self) -> str | None:
        """The absolute topic of its odometry; None for a drive without odometry."""
        return None

    @property
    def wheel_speeds_topic(self) -> str | None:
        """The absolute topic of the speeds of its wheels; None for a drive without wheels."""
        return None

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it moves."""
        return ()

    @abstractmethod
    def renamed(self, named: Rename) -> Self:
        """Return the same drive for a model whose parts are renamed."""


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
    """Makes one joint follow commands (``std_msgs/Float64``).

    That of a ball joint is of positions, has neither gains nor an initial target, and follows orientations of
    the child in the joint's frame (``geometry_msgs/Quaternion``).

    Args:
        joint: its name.
        kind: the commanded quantity: a position (rad, m), a velocity or an effort (N m, N).
        topic: the absolute topic of commands.
        gains: gains of the error in position or in velocity, not used for efforts; None: the joint follows
            within some hundredths of a second with any load within its limits of effort and velocity.
        initial: the target before the first command; None: the joint is free.
    """

    joint: str
    kind: ControllerKind
    topic: str
    gains: Pid | None = Pid()
    initial: float | None = None

    @property
    def is_firm(self) -> bool:
        """Whether the joint follows with any load within its limits."""
        return self.gains is None and self.kind != "effort"

    def renamed(self, named: Rename) -> JointController:
        """Return the same controller for a model whose parts are renamed."""
        return replace(self, joint=named(self.joint))


@dataclass(frozen=True, slots=True)
class PairController:
    """Makes the mean or the difference of two joints follow commands, as for two eyes that move together.

    A command for the mean keeps the difference, and the reverse.

    Args:
        name: name of the commanded quantity, such as ``eye_version``, also in joint states.
        of: the mean of both joints, or the first less the second.
        joints: their names.
        kind: the commanded quantity, positions (rad, m) or velocities.
        topic: absolute (``std_msgs/Float64``).
        gains: of each joint, as those of :class:`JointController`.
    """

    name: str
    of: Literal["mean", "difference"]
    joints: tuple[str, str]
    kind: Literal["position", "velocity"]
    topic: str
    gains: Pid | None = None

    def of_joint(self, joint: str) -> JointController:
        """Return the controller of one of its joints."""
        return JointController(joint, self.kind, self.topic, self.gains)

    def value(self, first: float, second: float) -> float:
        """Return the mean or the difference of two numbers."""
        return (first + second) / 2 if self.of == "mean" else first - second

    def apart(self, value: float, first: float, second: float) -> tuple[float, float]:
        """Return two numbers with a new mean and the old difference, or the reverse."""
        if self.of == "mean":
            return value + (first - second) / 2, value - (first - second) / 2
        return (first + second + value) / 2, (first + second - value) / 2

    def renamed(self, named: Rename) -> PairController:
        """Return the same controller for a model whose parts are renamed."""
        return replace(self, name=named(self.name), joints=(named(self.joints[0]), named(self.joints[1])))


@dataclass(frozen=True, slots=True)
class GroupController:
    """Makes several joints follow the numbers of one command, as a ``forward_command_controller`` does.

    Args:
        name: the name of the controller.
        joints: their names, in the order of the numbers.
        kind: the commanded quantity.
        topic: absolute (``std_msgs/Float64MultiArray``).
        gains: gains by joint, as those of :class:`JointController`; None for joints without gains.
    """

    name: str
    joints: tuple[str, ...]
    kind: ControllerKind
    topic: str
    gains: tuple[tuple[str, Pid], ...] = ()

    def of_joint(self, joint: str) -> JointController:
        """Return the controller of one of its joints."""
        return JointController(joint, self.kind, self.topic, dict(self.gains).get(joint))

    def renamed(self, named: Rename) -> GroupController:
        """Return the same controller for a model whose parts are renamed."""
        gains = tuple((named(joint), gains) for joint, gains in self.gains)
        return replace(self, joints=tuple(map(named, self.joints)), gains=gains)


@dataclass(frozen=True, slots=True)
class TrajectoryController:
    """Makes joints follow trajectories (``trajectory_msgs/JointTrajectory``).

    Args:
        name: the name of the controller or its plugin.
        command_topic: the absolute topic of commands.
        joints: their names.
        gains: gains by joint, as those of :class:`JointController`; None for joints without gains.
        initial: positions by joint in which it is held before the first trajectory; the others are free.
        state_topic: topic of its state (``control_msgs/JointTrajectoryControllerState``); None for none.
        rate_hz: rate of the state, Hz.
    """

    name: str
    command_topic: str
    joints: tuple[str, ...]
    gains: tuple[tuple[str, Pid], ...] = ()
    initial: tuple[tuple[str, float], ...] = ()
    state_topic: str | None = None
    rate_hz: float = 50.0

    def of_joint(self, joint: str) -> JointController:
        """Return the controller of one of its joints."""
        gains, initial = dict(self.gains).get(joint), dict(self.initial).get(joint)
        return JointController(joint, "position", self.command_topic, gains, initial)

    def renamed(self, named: Rename) -> TrajectoryController:
        """Return the same controller for a model whose parts are renamed."""
        return replace(
            self,
            joints=tuple(map(named, self.joints)),
            gains=tuple((named(joint), gains) for joint, gains in self.gains),
            initial=tuple((named(joint), position) for joint, position in self.initial),
        )
