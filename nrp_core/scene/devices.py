"""Sensors, drives and controllers in a scene: the data that files, engines and renderers need of them.

Each drive is a class in :mod:`nrp_core.world.drives` or in another package.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from math import inf
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from nrp_core.scene.rigid import Pose, Vector

LATER: Mapping[str, object] = {"later": True}
"""Metadata of a field that was added later: at its default it is left out, so that earlier digests hold."""


def set_fields(self: Any, values: Sequence[object]) -> None:
    """Set the fields of a dataclass from a pickle; those that an earlier version lacks get their defaults."""
    for one, value in zip(fields(self), values, strict=False):
        object.__setattr__(self, one.name, value)
    for one in fields(self)[len(values) :]:
        object.__setattr__(self, one.name, one.default)


def digest_of(value: object) -> str:
    """Return the digest of data; fields that are excluded from comparisons are excluded here."""
    return hashlib.blake2b(_text(value).encode(), digest_size=16).hexdigest()


def _text(value: object) -> str:
    """Return data as text: fields by name, after the ``tag`` of their class if it has one."""
    if is_dataclass(value) and not isinstance(value, type):
        entries = {
            field.name: getattr(value, field.name)
            for field in fields(value)
            if field.compare
            and not ("later" in field.metadata and getattr(value, field.name) == field.default)
        }
        return getattr(value, "tag", "") + _text(entries)
    if isinstance(value, Mapping):
        return "{" + ",".join(f"{key}:{_text(value[key])}" for key in sorted(value)) + "}"
    if isinstance(value, tuple | list):
        return "[" + ",".join(map(_text, value)) + "]"
    if isinstance(value, Path):
        return repr(value.name)  # meshes are named by a digest of their contents
    if value is None or isinstance(value, bool | int | float | str):
        return repr(value)
    raise TypeError(f"a scene holds a {type(value).__name__}, which has no digest: {value!r:.60}")


@dataclass(frozen=True, slots=True)
class Noise:
    """Gaussian noise on every number of a sensor.

    Args:
        mean: mean of the noise, in the unit of the measurement (for images, 1 is full brightness).
        stddev: standard deviation, in the same unit.
        bias_mean, bias_stddev: mean and standard deviation of the size of a bias that is drawn once.
        drift_stddev: how fast the bias changes, in the unit of the measurement per square root of a second.
        drift_time_s: the correlation time of the drift; 0 for no drift.
        precision: the step to which the measurement is rounded; 0 for none.
        axes: the noise of each number of a vector in place of this one; empty if they are alike.
    """

    mean: float = 0.0
    stddev: float = 0.0
    bias_mean: float = field(default=0.0, metadata=LATER)
    bias_stddev: float = field(default=0.0, metadata=LATER)
    drift_stddev: float = field(default=0.0, metadata=LATER)
    drift_time_s: float = field(default=0.0, metadata=LATER)
    precision: float = field(default=0.0, metadata=LATER)
    axes: tuple[Noise, ...] = field(default=(), kw_only=True, metadata=LATER)

    __setstate__ = set_fields

    def __bool__(self) -> bool:
        alone = self.mean or self.stddev or self.bias_mean or self.bias_stddev or self.precision
        return any(self.axes) if self.axes else bool(alone or self.drift_stddev)

    @property
    def drifts(self) -> bool:
        """Whether its bias changes."""
        return self.drift_stddev > 0 and self.drift_time_s > 0

    @classmethod
    def of_axes(cls, *axes: Noise) -> Noise:
        """Return the noise of a vector."""
        return axes[0] if all(each == axes[0] for each in axes) else cls(axes=axes)

    def on(self, count: int) -> tuple[Noise, ...]:
        """Return the noise of each number of a vector."""
        return self.axes or (self,) * count

    def changed(self, change: Callable[[Noise], Noise]) -> Noise:
        """Return the noise with each of its axes changed."""
        return replace(self, axes=tuple(map(change, self.axes))) if self.axes else change(self)


@dataclass(frozen=True, slots=True)
class Imperfection:
    """Imperfections of a topic that no sensor publishes.

    Args:
        noise: noise on every number.
        delay: from the value to the arrival of its message, s.
        drop_out: share of lost messages.
    """

    noise: Noise | None = None
    delay: float = 0.0
    drop_out: float = 0.0


ANY_CAMERA = 0xFFFFFFFF
"""The flags of a visual that all cameras draw, and the mask of a camera that draws all visuals."""


@dataclass(frozen=True, slots=True)
class View:
    """The images that an engine draws for a sensor: along x of its pose, z up.

    Args:
        pose: in the frame of the sensor's link.
        horizontal_fov: horizontal field of view, rad.
        width, height: size, pixels.
        near, far: clip distances in m.
        mask: bits; visuals are drawn whose flags share one.
    """

    pose: Pose
    horizontal_fov: float
    width: int
    height: int
    near: float
    far: float
    mask: int = ANY_CAMERA


@dataclass(frozen=True, slots=True)
class MountedSensor:
    """A sensor on a link.

    Args:
        name: unique on its link.
        topic: absolute topic of its messages. Further fields whose names end in ``topic`` are topics as well.
        rate_hz: messages per second; 0 for one in each step of the physics.
        noise: noise on every number.
        delay: from the measurement, which is the time in the stamp, to the arrival of its message, s.
        drop_out: share of lost messages.
        frame_name: the frame of its messages in its model, a link or one of its own; empty for the usual one.

    Attributes:
        needs: the capabilities that it needs, fields of
            :class:`~nrp_core.world.capabilities.WorldCapabilities`.
        tag: name of the kind of sensor in digests of scenes.
        frame_suffix: the suffix that follows the sensor's name in the name of its own frame.
        noises: fields with the noise of some of the numbers in place of ``noise``; None is none of their own.
    """

    noise: Noise = field(default=Noise(), kw_only=True)
    delay: float = field(default=0.0, kw_only=True)
    drop_out: float = field(default=0.0, kw_only=True)
    frame_name: str = field(default="", kw_only=True, metadata=LATER)
    name: str
    topic: str
    rate_hz: float

    needs: ClassVar[tuple[str, ...]] = ()
    tag: ClassVar[str] = ""
    frame_suffix: ClassVar[str] = ""
    noises: ClassVar[tuple[str, ...]] = ()

    @property
    def topics(self) -> list[str]:
        """Its topics: it may publish several forms of its measurement."""
        return list(self.topics_by_field.values())

    @property
    def topics_by_field(self) -> dict[str, str]:
        """Its topics by the names of its fields."""
        given = {one.name: getattr(self, one.name) for one in fields(self) if one.name.endswith("topic")}
        return {name: topic for name, topic in given.items() if topic}

    @property
    def view(self) -> View | None:
        """The images that it consists of; None for a sensor without images."""
        return None

    @property
    def views(self) -> Mapping[str, View]:
        """All images that an engine draws for it, by names that are unique on its link: usually its own."""
        return {} if self.view is None else {self.name: self.view}

    @property
    def offset(self) -> Pose | None:
        """The pose of the frame of its messages in that of its link; None: the link's own."""
        return None

    def frame_on(self, model: str, link: str) -> str:
        """Return the name of the frame of its messages: ``model/link``, or its own, ``model/link/sensor``."""
        if self.frame_name:
            return f"{model}/{self.frame_name}"
        own = f"{self.name}{self.frame_suffix}"
        return f"{model}/{link}" if self.offset in (None, Pose()) else f"{model}/{link}/{own}"

    @property
    def measured_joints(self) -> tuple[str, ...]:
        """The joints of its model in which it measures forces."""
        return ()

    @property
    def is_odometry(self) -> bool:
        """Whether it repeats the odometry of a drive on the same topic."""
        return False

    def renamed(self, named: Callable[[str], str]) -> Self:
        """Return the same sensor for a model whose links and joints are renamed."""
        return replace(self, frame_name=named(self.frame_name)) if self.frame_name else self


Rename = Callable[[str], str]
ControllerKind = Literal["position", "velocity", "effort"]
"""The quantity that a controller of joints commands."""


@dataclass(frozen=True, slots=True)
class MountedDrive:
    """A drive of a model: it moves the whole body as commanded.

    Args:
        name: the name of the plugin.
        command_topic: the absolute topic of commands.

    Attributes:
        joint_fields: fields with the names of the joints that it moves, in their order.
        servo_fields: those of them whose joints it moves by servos.
    """

    name: str
    command_topic: str

    joint_fields: ClassVar[tuple[str, ...]] = ()
    servo_fields: ClassVar[tuple[str, ...]] = ()

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
        return tuple(joint for field in self.joint_fields for joint in getattr(self, field))

    @property
    def needs(self) -> tuple[str, ...]:
        """The capabilities of the world without which a scene with it is refused."""
        return ()

    def describe(self, model: Any) -> str:
        """Return its numbers for an outline of its model; empty for none."""
        return ""

    def tube(self, model: Any) -> tuple[Sequence[Vector], float] | None:
        """Return the tube that it is drawn as: points in its model where this starts, and a radius, m."""
        return None

    def check(self, model: Any) -> None:
        """Refuse a drive that names parts that its model does not have, besides :attr:`joints`.

        Raises:
            SceneError: the model does not have a part.
        """

    def renamed(self, named: Rename) -> Self:
        """Return the same drive for a model whose parts are renamed."""
        joints: dict[str, Any] = {
            field: tuple(map(named, getattr(self, field))) for field in self.joint_fields
        }
        return replace(self, name=named(self.name), **joints)


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

    For a ball joint, it is of positions, has neither gains nor an initial target, and follows orientations
    of the child in the joint's frame (``geometry_msgs/Quaternion``).

    Args:
        joint: its name.
        kind: the commanded quantity: a position (rad, m), a velocity or an effort (N m, N).
        topic: the absolute topic of commands.
        gains: gains of the error in position or in velocity, not used for efforts; None: the joint follows
            within some hundredths of a second with any load within its limits of effort and velocity.
        initial: the target before the first command; None: see ``holds``.
        holds: whether the joint holds its start position before the first command, as in ros2_control; else
            it is free, as with most plugins of Gazebo.
        range: the minimum and maximum of commands, in addition to the limits of the joint.
        beyond: whether target positions may lie beyond the limits of the joint.
    """

    joint: str
    kind: ControllerKind
    topic: str
    gains: Pid | None = Pid()
    initial: float | None = None
    holds: bool = field(default=False, metadata=LATER)
    range: tuple[float, float] = field(default=(-inf, inf), metadata=LATER)
    beyond: bool = field(default=False, metadata=LATER)

    __setstate__ = set_fields

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

    def split(self, value: float, first: float, second: float) -> tuple[float, float]:
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
        """Return the controller of one of its joints; positions are held before the first command."""
        gains = dict(self.gains).get(joint)
        return JointController(joint, self.kind, self.topic, gains, holds=self.kind == "position")

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
        initial: positions by joint in which it is held before the first trajectory.
        state_topic: topic of its state (``control_msgs/JointTrajectoryControllerState``); None for none.
        rate_hz: rate of the state, Hz.
        holds: whether the other joints hold their start positions until then, as those of
            :class:`JointController`.
    """

    name: str
    command_topic: str
    joints: tuple[str, ...]
    gains: tuple[tuple[str, Pid], ...] = ()
    initial: tuple[tuple[str, float], ...] = ()
    state_topic: str | None = None
    rate_hz: float = 50.0
    holds: bool = field(default=False, metadata=LATER)

    __setstate__ = set_fields

    def of_joint(self, joint: str) -> JointController:
        """Return the controller of one of its joints."""
        gains, initial = dict(self.gains).get(joint), dict(self.initial).get(joint)
        return JointController(joint, "position", self.command_topic, gains, initial, self.holds)

    def renamed(self, named: Rename) -> TrajectoryController:
        """Return the same controller for a model whose parts are renamed."""
        return replace(
            self,
            joints=tuple(map(named, self.joints)),
            gains=tuple((named(joint), gains) for joint, gains in self.gains),
            initial=tuple((named(joint), position) for joint, position in self.initial),
        )
