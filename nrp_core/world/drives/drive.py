"""The base classes of drives: their data in a file, and the part of a world that runs them.

A drive is found by entry points in the group ``nrp_core.drives``, named after the plugins that it reads.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from math import isfinite
from operator import attrgetter
from typing import Any, ClassVar, Final, Protocol

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import from_seconds
from nrp_core.findings import Code
from nrp_core.world.copies import copies_of
from nrp_core.world.engine import Engine
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.gazebo_msgs import WheelSpeeds
from nrp_core.world.messages.geometry_msgs import PoseWithCovariance, Twist, TwistWithCovariance
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.part import Part
from nrp_core.world.pose_messages import pose_message, twist_message
from nrp_core.world.rigid.motion import BodyVelocity
from nrp_core.world.scene.acting import MountedDrive
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.topics import Direction, TopicInfo

_FAST_M_S: Final = 100.0
_FAST_RAD_S: Final = 50.0
"""Eight turns a second; a turn of a right angle that is given in degrees is faster."""

_numbers_of = attrgetter("linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z")


class Drive(MountedDrive):
    """The data of a drive; a subclass is a frozen dataclass with slots whose fields are its parameters.

    Attributes:
        components: the components of a Twist that command it; empty for a drive with other commands.
    """

    __slots__ = ()

    components: ClassVar[tuple[str, ...]] = ()

    @classmethod
    @abstractmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Drive:
        """Read a ``<plugin>`` of a model.

        Raises:
            SceneError: it names joints that the model does not have, or is not a valid drive of this kind.
        """

    @abstractmethod
    def part(self, model: Model, engine: Engine) -> Part:
        """Return the part that runs the drive of a model."""


class GroundDrive(Protocol):
    """The fields of drives that move on the ground."""

    @property
    def name(self) -> str:
        """The name of the plugin."""

    @property
    def command_topic(self) -> str:
        """The absolute topic of commands."""

    @property
    def odometry_topic(self) -> str | None:
        """Absolute; None where there is none."""

    @property
    def wheel_speeds_topic(self) -> str | None:
        """Absolute; None where there is none."""

    @property
    def timeout(self) -> float:
        """Seconds without a command after which the drive stops; ``inf`` for never."""

    @property
    def rate_hz(self) -> float:
        """Rate of odometry and wheel speeds, Hz."""


class DrivePart(Part):
    """Runs a drive that moves on the ground.

    A command holds until the next one or until the time-out; speeds are not clamped.
    """

    def __init__(self, drive: GroundDrive, model: Model, engine: Engine) -> None:
        self._drive, self._model, self._engine = drive, model.name, engine
        self._frame = f"{model.name}/{model.links[0].name}"
        self._home = model.pose.inverse()
        self._timeout_ns = from_seconds(drive.timeout) if isfinite(drive.timeout) else None
        command = TopicInfo(
            drive.command_topic, Twist, Direction.IN, what=f"velocity command of {model.name}"
        )
        topics = [command]
        if drive.odometry_topic is not None:
            what = f"odometry of {model.name}"
            topics.append(TopicInfo(drive.odometry_topic, Odometry, Direction.OUT, drive.rate_hz, what))
        if drive.wheel_speeds_topic is not None:
            what = f"wheel speeds of {model.name}, m/s: actual and commanded"
            topics.append(
                TopicInfo(drive.wheel_speeds_topic, WheelSpeeds, Direction.BOTH, drive.rate_hz, what)
            )
        self.topics = tuple(topics)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        twist = message if topic == self._drive.command_topic else self._body_twist(message)
        self._follow(map(float, _numbers_of(twist)), now_ns)

    def write_numbers(self, topic: str, numbers: Sequence[float], now_ns: int) -> bool:
        if topic != self._drive.command_topic:
            return False
        self._follow(numbers, now_ns)
        return True

    def _follow(self, command: Iterable[float], now_ns: int) -> None:
        self._aim(self._commanded(*command))
        self.deadline_ns = None if self._timeout_ns is None else now_ns + self._timeout_ns

    @classmethod
    def write_rows(cls, parts: Sequence[Any], topic: str, rows: FloatArray, now_ns: Sequence[int]) -> bool:
        first, (forward, *others, turn) = parts[0], rows.T
        replaced = (DrivePart.write, DrivePart._follow, DrivePart._commanded, DrivePart._aim)
        usual = topic == first._drive.command_topic and all(
            getattr(cls, one.__name__) is one for one in replaced
        )
        slow = (np.abs(forward) <= _FAST_M_S) & (np.abs(turn) <= _FAST_RAD_S)
        if not (usual and slow.all()) or np.any(others):
            return False
        velocities = [BodyVelocity(x, 0.0, z) for x, z in zip(forward.tolist(), turn.tolist(), strict=True)]
        copies_of([part._engine for part in parts]).set_drives(first._model, first._drive.name, velocities)
        for part, velocity, t_ns in zip(parts, velocities, now_ns, strict=True):
            part._velocity = velocity
            part.deadline_ns = None if part._timeout_ns is None else t_ns + part._timeout_ns
        return True

    def at_deadline(self, now_ns: int) -> None:
        self._aim(BodyVelocity())
        self.deadline_ns = None

    def read(self, topic: str, now_ns: int) -> Any:
        return self._odometry(now_ns) if topic == self._drive.odometry_topic else self._wheel_speeds()

    def moved(self) -> None:
        self._aim(self._velocity)

    def reset(self) -> None:
        self.deadline_ns = None
        self._aim(BodyVelocity())

    def save(self) -> object:
        return self.deadline_ns, self._velocity

    def restore(self, saved: Any) -> None:
        self.deadline_ns, velocity = saved
        self._aim(velocity)

    _velocity = BodyVelocity()
    _reported = False

    def _commanded(
        self, x: float, y: float, z: float, roll: float, pitch: float, turn: float
    ) -> BodyVelocity:
        """Return the velocity that the numbers of a twist command, m/s and rad/s."""
        if y or z or roll or pitch:
            self._report("moves along x and turns about z; the rest of a command on it has no effect")
        # without abs(): a step counts its calls
        if not (-_FAST_M_S <= x <= _FAST_M_S and -_FAST_RAD_S <= turn <= _FAST_RAD_S):
            self._report(f"is commanded {x:g} m/s and {turn:g} rad/s, which no such robot reaches")
        return BodyVelocity(x, 0.0, turn)

    def _report(self, what: str) -> None:
        """Report the first command that the drive cannot follow."""
        if not self._reported:
            self._reported = True
            message = f"the drive '{self._drive.name}' of '{self._model}' {what}"
            self._engine.warnings.add(Code.NRP299, message, subject=self._drive.command_topic)

    def _aim(self, velocity: BodyVelocity) -> None:
        self._velocity = velocity
        self._engine.set_drive(self._model, self._drive.name, velocity)

    def _odometry(self, now_ns: int) -> Odometry:
        motion = self._engine.model_motion(self._model)
        pose, to_body = self._home @ motion.pose, motion.pose.rotate_back
        moving = twist_message(to_body(motion.linear), to_body(motion.angular))
        header = Header(Time.from_ns(now_ns), f"{self._model}/odom")
        place = PoseWithCovariance(pose_message(pose))
        return Odometry(header, self._frame, place, TwistWithCovariance(moving))

    def _body_twist(self, speeds: WheelSpeeds) -> Twist:
        """Return the velocity of the body for these wheel speeds; for drives with wheels."""
        raise NotImplementedError

    def _wheel_speeds(self) -> WheelSpeeds:
        """Return the speeds of the wheels; for drives with wheels."""
        raise NotImplementedError


def commanded_components(scene: Scene) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return the model and the components that are used of each topic that takes a Twist for a drive."""
    return {
        drive.command_topic: (model.name, drive.components)
        for model in scene.models
        for drive in model.drives
        if isinstance(drive, Drive) and drive.components and hasattr(drive, "command_topic")
    }
