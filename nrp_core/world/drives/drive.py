"""The base classes of drives: their data in a file, and the part of a world that runs them.

A drive is found by entry points in the group ``nrp_core.drives``, named after the plugins that it reads.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any, ClassVar, Final, Protocol

from nrp_core.clock import from_seconds
from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.messages.base import Time, resolve_name
from nrp_core.messages.gazebo_msgs import WheelSpeeds
from nrp_core.messages.geometry_msgs import PoseWithCovariance, Twist, TwistWithCovariance
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.std_msgs import Float64, Header
from nrp_core.scene.devices import MountedDrive
from nrp_core.scene.merged_bodies import Body, body_of, tree_of
from nrp_core.scene.model import Inertial, Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts
from nrp_core.scene.rigid import BodyVelocity
from nrp_core.world.engine import Engine
from nrp_core.world.model_states import pose_message, twist_message
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, TopicInfo

_FAST_M_S: Final = 100.0
_FAST_RAD_S: Final = 50.0
"""Eight turns a second; a turn of a right angle that is given in degrees is faster."""


class Drive(MountedDrive, ABC):
    """The data of a drive; a subclass is a frozen dataclass with slots whose fields are its parameters.

    Attributes:
        components: the components of a Twist that command it; empty for a drive with other commands.
        of_world: whether the plugin stands in a ``<world>``, too; the drive then acts on every model.
    """

    __slots__ = ()

    components: ClassVar[tuple[str, ...]] = ()
    of_world: ClassVar[bool] = False

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
        """Absolute; None without such a topic."""

    @property
    def wheel_speeds_topic(self) -> str | None:
        """Absolute; None without such a topic."""

    @property
    def timeout(self) -> float:
        """Seconds without a command after which the drive stops; ``inf`` for never."""

    @property
    def rate_hz(self) -> float:
        """Rate of odometry and wheel speeds, Hz."""


class DrivePart(Part):
    """Runs a drive that moves on the ground.

    A command holds until the next one or until the time-out.

    Attributes:
        steers: whether joints follow its target velocity, by :meth:`_steer`.
    """

    steers: ClassVar[bool] = False

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
        self.number_topics = frozenset({drive.command_topic})

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        numbers = message if topic == self._drive.command_topic else self._body_twist(message)
        velocity = self._body_velocity(*numbers)
        self.deadline_ns = None if self._timeout_ns is None else now_ns + self._timeout_ns
        self.set_target_velocity(velocity)

    @classmethod
    def write_all(
        cls, parts: Sequence[Any], topic: str, rows: Sequence[Sequence[float]], times_ns: Sequence[int]
    ) -> bool:
        kinds = {(type(part._engine), part._model, part._drive.name) for part in parts}
        is_plain = (cls.write, cls.set_target_velocity) == (DrivePart.write, DrivePart.set_target_velocity)
        if len(kinds) > 1 or cls.steers or not is_plain:
            return False
        ((engine, model, drive),) = kinds
        velocities = [part._body_velocity(*row) for part, row in zip(parts, rows, strict=True)]
        if not engine.set_drive_of([part._engine for part in parts], model, drive, velocities):
            return False
        for part, velocity, now_ns in zip(parts, velocities, times_ns, strict=True):
            part.deadline_ns = None if part._timeout_ns is None else now_ns + part._timeout_ns
            part._velocity = velocity
        return True

    def set_target_velocity(self, velocity: BodyVelocity) -> None:
        """Set the velocity that the engine gives the robot from now on."""
        self._velocity = velocity
        self._engine.set_drive(self._model, self._drive.name, velocity)
        if self.steers:
            self._steer(velocity)

    def at_deadline(self, now_ns: int) -> None:
        self.set_target_velocity(BodyVelocity())
        self.deadline_ns = None

    def read(self, topic: str, now_ns: int) -> Any:
        return self._odometry(now_ns) if topic == self._drive.odometry_topic else self._wheel_speeds()

    def on_model_moved(self) -> None:
        self.set_target_velocity(self._velocity)

    def reset(self) -> None:
        self.deadline_ns = None
        self.set_target_velocity(BodyVelocity())

    def save(self) -> object:
        return self.deadline_ns, self._velocity

    def restore(self, saved: Any) -> None:
        self.deadline_ns, velocity = saved
        self.set_target_velocity(velocity)

    _velocity = BodyVelocity()
    _reported = False

    def _body_velocity(
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

    def _steer(self, velocity: BodyVelocity) -> None:
        """Set the joints that follow the target velocity; for drives that steer."""
        raise NotImplementedError

    def _odometry(self, now_ns: int) -> Odometry:
        motion = self._engine.model_motion(self._model)
        pose, to_body = self._home @ motion.pose, motion.pose.rotate_back
        moving = twist_message(to_body(motion.linear), to_body(motion.angular))
        header = Header(Time.from_ns(now_ns), f"{self._model}/odom")
        place = PoseWithCovariance(pose_message(pose))
        return Odometry(header, self._frame, place, TwistWithCovariance(moving))

    def _body_twist(self, speeds: WheelSpeeds) -> Sequence[float]:
        """Return the numbers of the body's twist for these wheel speeds; for drives with wheels."""
        raise NotImplementedError

    def _wheel_speeds(self) -> WheelSpeeds:
        """Return the speeds of the wheels; for drives with wheels."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class Actuator(Drive):
    """An actuator among the elements for one engine; its control is commanded (``std_msgs/Float64``).

    Args:
        lowest, highest: the range of its control; the engine clips it.
    """

    tag: ClassVar[str] = "actuator"

    lowest: float = -inf
    highest: float = inf

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Actuator:
        """Read ``<actuator>`` (its name), ``<topic>``, ``<lowest>`` and ``<highest>``."""
        name = plugin.require("actuator").text
        topic = resolve_name(plugin.word("topic", f"{name}/cmd"), reading.robot)
        return cls(name, topic, plugin.number("lowest", -inf), plugin.number("highest", inf))

    def part(self, model: Model, engine: Engine) -> ActuatorPart:
        return ActuatorPart(self, model.name, engine)


class ActuatorPart(Part):
    """Commands one actuator; in an engine without it commands have no effect, which is reported."""

    def __init__(self, actuator: Actuator, model: str, engine: Engine) -> None:
        self._actuator, self._model, self._engine = actuator, model, engine
        self._works, self._reported = engine.capabilities.own_actuators, False
        what = f"control of the actuator {actuator.name} of {model}"
        self.topics = (TopicInfo(actuator.command_topic, Float64, Direction.IN, what=what),)
        if not self._works:
            message = f"{engine.title} does not have the actuator '{actuator.name}' of '{model}'"
            engine.warnings.add(Code.NRP260, message, subject=actuator.name)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        actuator, value = self._actuator, message.data
        if self._works:
            self._engine.set_control(self._model, actuator.name, value)
        if not (actuator.lowest <= value <= actuator.highest or self._reported):
            self._reported = True
            limits = f"from {actuator.lowest:g} to {actuator.highest:g}"
            text = (
                f"the actuator '{actuator.name}' of '{self._model}' is commanded {value:g}; it goes {limits}"
            )
            self._engine.warnings.add(Code.NRP299, text, subject=topic)


def driven_root(
    model: Model, drive: MountedDrive, bodies: Sequence[Body], wheels: Sequence[Body] = ()
) -> int:
    """Return the root that holds all wheels; for a drive without wheels, the base of its model.

    Links that move may be between: those that steer, rockers, and suspensions.

    Raises:
        SceneError: the wheels are not held by one freely floating body.
    """
    names = [wheel.name for wheel in wheels] or [model.links[0].name]
    chains = [list(_chain(body_of(bodies, name), bodies)) for name in names]
    held_by_wheels = {bodies[above].name for chain in chains for above in chain[1:]} & set(names)
    if len({chain[-1] for chain in chains}) != 1 or held_by_wheels:
        raise SceneError(f"the wheels of the drive '{drive.name}' of '{model.name}' are not held by one body")
    base = chains[0][-1]
    if not bodies[base].floats:
        raise SceneError(
            f"the drive '{drive.name}' cannot move '{model.name}', whose base does not float freely"
        )
    return base


def _chain(index: int, bodies: Sequence[Body]) -> Iterator[int]:
    """Yield a body and those that hold it, up to the root."""
    above: int | None = index
    while above is not None:
        yield above
        above = bodies[above].parent


def masses_in(root: int, bodies: Sequence[Body]) -> list[Inertial]:
    """Return the inertials of a root and its descendants, in its frame, which is the model's."""
    tree = tree_of(root, bodies)
    parts = [(bodies[index].in_model, bodies[index].inertial) for index in tree]
    return [replace(mass, pose=place @ mass.pose) for place, mass in parts if mass is not None]
