"""Drives and controllers of joints as a scene carries them: the data that files and engines need.

Each drive is a class of its own in :mod:`nrp_core.world.drives`, or in a package of somebody else.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import Literal, Self

Rename = Callable[[str], str]


@dataclass(frozen=True, slots=True)
class MountedDrive(ABC):
    """A drive of a model: it moves the whole body as it is commanded.

    Args:
        name: of the plugin.
        command_topic: absolute.
    """

    name: str
    command_topic: str

    @property
    def odometry_topic(self) -> str | None:
        """The absolute topic of its odometry; None for a drive without."""
        return None

    @property
    def wheel_speeds_topic(self) -> str | None:
        """The absolute topic of the speeds of its wheels; None for a drive without."""
        return None

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it moves."""
        return ()

    @abstractmethod
    def renamed(self, named: Rename) -> Self:
        """Return the drive of a model whose parts have other names."""


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
