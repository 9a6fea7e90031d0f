"""Flying bodies: velocities along and about all axes, controlled by a force and a torque."""

from __future__ import annotations

from dataclasses import dataclass
from posixpath import join
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import length, product
from nrp_core.clock import seconds
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.scene.inertia import inertia_tensor, sum_inertials
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts, plugin_name, vector_in
from nrp_core.scene.rigid import Vector, Wrench, rotation_matrix
from nrp_core.world.drives.drive import Drive, driven_root, masses_in
from nrp_core.world.engine import Engine
from nrp_core.world.model_states import vector_of
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, TopicInfo

MAX_ACCELERATION = 20.0
"""Maximum acceleration, m/s^2, in addition to the compensation of gravity."""
MAX_ANGULAR_ACCELERATION = 200.0
"""Maximum angular acceleration, rad/s^2."""


@dataclass(frozen=True, slots=True)
class Flight(Drive):
    """A body that moves along and turns about all its axes as a Twist commands; its lift is not simulated.

    Before the first command it falls. Its fields are those of
    :class:`~nrp_core.world.drives.wheels.WheelDrive`.

    Args:
        initial: initial velocities along its axes (m/s) and about them (rad/s); it then does not fall.
    """

    tag: ClassVar[str] = "flight"

    initial: tuple[Vector, Vector] | None = None
    odometry_topic: None = None
    wheel_speeds_topic: None = None

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Flight:
        if plugin_name(plugin) == "MulticopterVelocityControl":
            # its rotors are not simulated: the body flies as they would make it
            topic = join("/", plugin.word("robotNamespace"), plugin.word("commandSubTopic", "cmd_vel"))
            return cls(plugin.attribute("name"), resolve_name(topic, reading.robot))
        for ignored in plugin.all("link_name"):
            reading.notes.warn(
                ignored,
                Code.NRP383,
                "the <link_name> of a VelocityControl has no effect: the plugin moves the whole model",
            )
        first = vector_in(plugin, "initial_linear"), vector_in(plugin, "initial_angular")
        begins = bool(plugin.all("initial_linear", "initial_angular"))
        topic = resolve_name(plugin.word("topic", f"/model/{reading.robot}/cmd_vel"), reading.robot)
        return cls(plugin.attribute("name"), topic, first if begins else None)

    def part(self, model: Model, engine: Engine) -> FlightPart:
        return FlightPart(self, model, engine)


class FlightPart(Part):
    """Runs one :class:`Flight`.

    A command holds until the next one. In each physics step a force at the centre of mass and a torque bring
    the body to the commanded velocities, up to its maximum accelerations, and carry its weight.

    Args:
        drive: the drive.
        model: the model that flies.
        engine: the engine that moves it.
    """

    def __init__(self, drive: Flight, model: Model, engine: Engine) -> None:
        self._drive, self._model, self._engine = drive, model.name, engine
        bodies = bodies_of(model)
        root = driven_root(model, drive, bodies)
        whole = sum_inertials(masses_in(root, bodies))
        assert whole is not None  # a floating body has mass
        base = model.links[0]
        self._link, self._mass = base.name, whole.mass
        in_link = base.pose.inverse()
        self._centre = np.array((in_link @ whole.pose).position)
        own = base.inertial.pose.position if base.inertial else (0.0, 0.0, 0.0)
        self._lever = self._centre - own  # the engine applies wrenches at the link's own centre
        turn = rotation_matrix(in_link.orientation)
        self._inertia = product(product(turn, inertia_tensor(whole)), turn.T)
        what = f"velocity command of {model.name}"
        self.topics = (TopicInfo(drive.command_topic, Twist, Direction.IN, what=what),)
        self._command = drive.initial

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self._command = vector_of(message.linear), vector_of(message.angular)
        self._push(now_ns)

    def at_deadline(self, now_ns: int) -> None:
        self._push(now_ns)

    def begin(self) -> None:
        if self._command is not None:
            self._push(0)

    def reset(self) -> None:
        self._restart(self._drive.initial, None)

    def save(self) -> object:
        return self._command, self.deadline_ns

    def restore(self, saved: Any) -> None:
        self._restart(*saved)

    def _restart(self, command: tuple[Vector, Vector] | None, deadline_ns: int | None) -> None:
        self._command = command
        if deadline_ns is None:
            self._pull(np.zeros(3), np.zeros(3))
        else:
            self._push(deadline_ns - self._engine.step_ns)
        self.deadline_ns = deadline_ns

    def _push(self, now_ns: int) -> None:
        """Apply the wrench for the next step."""
        assert self._command is not None
        step_s = seconds(self._engine.step_ns)
        motion = self._engine.link_motion(self._model, self._link)
        turn = rotation_matrix(motion.pose.orientation)
        velocity, rate = np.array(motion.linear), np.array(motion.angular)
        forward, turning = (product(turn, np.array(each)) for each in self._command)
        forward = forward + np.cross(turning, forward) * step_s / 2  # the chord of the next step's arc
        arm, inertia = product(turn, self._centre), product(product(turn, self._inertia), turn.T)
        missing = forward - velocity + np.cross(turning - rate, arm)
        acceleration = _clip_norm(missing / step_s, MAX_ACCELERATION)
        spin = _clip_norm((turning - rate) / step_s, MAX_ANGULAR_ACCELERATION)
        force = self._mass * (acceleration - np.array(self._engine.scene.gravity))
        torque = product(inertia, spin) + np.cross(rate, product(inertia, rate))
        torque += np.cross(product(turn, self._lever), force)
        self._pull(force, torque)
        self.deadline_ns = now_ns + self._engine.step_ns

    def _pull(self, force: FloatArray, torque: FloatArray) -> None:
        (fx, fy, fz), (tx, ty, tz) = force.tolist(), torque.tolist()
        wrench = Wrench((fx, fy, fz), (tx, ty, tz))
        self._engine.set_wrench(self._model, self._link, wrench, self._drive.name)


def _clip_norm(vector: FloatArray, most: float) -> FloatArray:
    size = length(vector)
    return vector * (most / size) if size > most else vector
