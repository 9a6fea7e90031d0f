"""Contacts, and sensors of the force and torque in a joint."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from nrp_core.messages.base import Time
from nrp_core.messages.gazebo_msgs import ContactsState, ContactState
from nrp_core.messages.geometry_msgs import Vector3, Wrench, WrenchStamped
from nrp_core.messages.geometry_msgs import Wrench as WrenchMessage
from nrp_core.messages.std_msgs import Header
from nrp_core.scene.devices import LATER, Noise
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts
from nrp_core.scene.reading.sensors import Mount, noise_of_axes, plugin_sensor, rate_of, topic_of
from nrp_core.scene.rigid import Pose, Touch, Vector
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.sensors.sensor import Sensor, SensorPart
from nrp_core.world.topics import Direction, TopicInfo

_WRENCH_TOPICS = {"gazebo_ros_ft_sensor": "topicName"}
_DIRECTIONS = "child_to_parent", "parent_to_child"


@dataclass(frozen=True, slots=True)
class ForceTorque(Sensor):
    """A sensor of the force and torque in a joint; it belongs to the joint's child link.

    Args:
        joint: the name of the joint.
        frame: the frame of the axes: ``child``, ``parent`` or ``sensor``.
        onto_child: whether it is the force of the parent on the child, or the reverse.
        pose: the point on the child link about which torques are, and the axes of the frame ``sensor``.
        torque_noise: the noise of the torque; None for that of all numbers.
    """

    tag: ClassVar[str] = "force_torque"

    needs: ClassVar[tuple[str, ...]] = ("joint_wrenches",)
    noises: ClassVar[tuple[str, ...]] = ("torque_noise",)
    on_joint: ClassVar[bool] = True

    joint: str
    frame: str = "child"
    onto_child: bool = False
    pose: Pose = Pose()
    torque_noise: Noise | None = field(default=None, kw_only=True, metadata=LATER)

    @property
    def measured_joints(self) -> tuple[str, ...]:
        """The joints of its model in which it measures forces."""
        return (self.joint,)

    def renamed(self, named: Callable[[str], str]) -> ForceTorque:
        """Return the same sensor for a model whose links and joints are renamed."""
        return replace(super(ForceTorque, self).renamed(named), joint=named(self.joint))

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> ForceTorque:
        name, section = sensor.attribute("name"), sensor.section("force_torque")
        frame = section.choice("frame", ("child", "parent", "sensor"), "child")
        topic = topic_of(sensor, reading.topic_of(mount.name, f"{name}/forcetorque"), _WRENCH_TOPICS, reading)
        onto_child = section.choice("measure_direction", _DIRECTIONS, _DIRECTIONS[0]) == _DIRECTIONS[1]
        noise, torque = (noise_of_axes(section.section(tag), reading) for tag in ("force", "torque"))
        own = None if torque == noise else torque
        return cls(
            name, topic, rate_of(sensor, reading), mount.name, frame, onto_child, mount.place(sensor),
            noise=noise, torque_noise=own,
        )  # fmt: skip

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, ForceTorque]:
        """Read ``gazebo_ros_ft_sensor``."""
        name, topic, rate_hz, noise = plugin_sensor(plugin, reading)
        joint = model.joint(plugin.require("jointName"))
        placed = next(link.pose for link in model.links if link.name == joint.child).inverse() @ joint.pose
        return joint.child, cls(name, topic, rate_hz, joint.name, pose=placed, noise=noise)

    def part(self, model: Model, link: str, engine: Engine) -> ForceTorquePart:
        return ForceTorquePart(self, model, link, engine)


class ForceTorquePart(SensorPart):
    """Publishes the wrench in a joint at the origin of the sensor, as in Gazebo Sim."""

    def __init__(self, sensor: ForceTorque, model: Model, link: str, engine: Engine) -> None:
        super().__init__(sensor, model.name, link, engine)
        self._sensor = sensor
        joint = next(joint for joint in model.joints if joint.name == sensor.joint)
        poses = {each.name: each.pose for each in model.links}
        self._parent = joint.parent if joint.parent in poses else link
        place = poses[link].inverse() @ joint.pose
        (x, y, z), (i, j, k) = sensor.pose.position, place.position
        self._lever = x - i, y - j, z - k  # on the child, from the joint
        self.topics = (self._served(sensor.topic, WrenchStamped, f"force and torque in {sensor.joint}"),)

    def read(self, topic: str, now_ns: int) -> WrenchStamped:
        model, link = self._place
        wrench = self._engine.joint_wrench(model, self._sensor.joint)
        along = child = self._engine.link_motion(model, link).pose
        if self._sensor.frame == "sensor":
            along = child @ self._sensor.pose
        elif self._sensor.frame == "parent":
            along = self._engine.link_motion(model, self._parent).pose
        x, y, z = child.rotate(self._lever)
        (fx, fy, fz), (tx, ty, tz) = wrench.force, wrench.torque
        about = tx - (y * fz - z * fy), ty - (z * fx - x * fz), tz - (x * fy - y * fx)
        sign = -1.0 if self._sensor.onto_child else 1.0
        turned = [along.inverse().rotate(vector) for vector in (wrench.force, about)]
        signed = ((sign * x, sign * y, sign * z) for x, y, z in turned)
        force, torque = self._noisy(topic, now_ns, *signed, own=(None, self._sensor.torque_noise))
        return WrenchStamped(self._header(now_ns), WrenchMessage(Vector3(*force), Vector3(*torque)))


CONTACTS = "/gazebo/contact_point_data"
_CONTACT_TOPICS = {"gazebo_ros_bumper": "bumperTopicName"}

Named = tuple[Touch, tuple[str, str]]


@dataclass(frozen=True, slots=True)
class ContactSensor(Sensor):
    """A sensor of the contacts of its link; ``collisions`` are the sensitive ones, by default all.

    One of another link is ``link::collision``.
    """

    tag: ClassVar[str] = "contact"

    needs: ClassVar[tuple[str, ...]] = ("contacts",)

    collisions: tuple[str, ...] = ()
    pose: Pose = Pose()

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> ContactSensor:
        name, contact = sensor.attribute("name"), sensor.section("contact")
        usual = contact.word("topic") or reading.topic_of(mount.name, f"{name}/contact")
        topic = topic_of(sensor, usual, _CONTACT_TOPICS, reading)
        collisions = tuple(each.text.rpartition("::")[2] for each in contact.all("collision"))
        return cls(name, topic, rate_of(sensor, reading), collisions, mount.place(sensor))

    def part(self, model: Model, link: str, engine: Engine) -> ContactPart:
        return ContactPart(self, model.name, link, engine)


class ContactPart(SensorPart):
    """Publishes the contacts of one link in the last physics step; the link's collisions come first."""

    def __init__(self, sensor: ContactSensor, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._prefix = f"{model}/{link}/"
        parted = (name.rpartition("::") for name in sensor.collisions)
        self._feeling = {f"{model}/{owner or link}/{name}" for owner, _, name in parted}
        self.topics = (self._served(sensor.topic, ContactsState, f"contacts of {model}/{link}"),)

    def read(self, topic: str, now_ns: int) -> ContactsState:
        mine: dict[tuple[str, str], list[Touch]] = {}
        for touch, names in self._engine.touches():
            for seen, pair in ((touch, names), (_reverse(touch), names[::-1])):
                if self._is_measured(pair[0]):
                    mine.setdefault((pair[0], pair[1]), []).append(seen)
        states = [contact_message(*names, touches) for names, touches in mine.items()]
        return ContactsState(self._header(now_ns), states)

    def _is_measured(self, collision: str) -> bool:
        return collision in self._feeling if self._feeling else collision.startswith(self._prefix)


class ContactsPart(Part):
    """Serves all contacts of the last physics step; each pair of shapes once."""

    topics = (TopicInfo(CONTACTS, ContactsState, Direction.OUT, None, "contacts of all models"),)

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def read(self, topic: str, now_ns: int) -> ContactsState:
        pairs: dict[tuple[str, str], list[Touch]] = {}
        for touch, (one, other) in self._engine.touches():
            in_order = touch if one <= other else _reverse(touch)
            pairs.setdefault((min(one, other), max(one, other)), []).append(in_order)
        states = [contact_message(*names, pairs[names]) for names in sorted(pairs)]
        return ContactsState(Header(Time.from_ns(now_ns), "world"), states)


def contact_message(one: str, other: str, touches: Iterable[Touch]) -> ContactState:
    """Return the contacts of two collisions as a message of Gazebo."""
    found = list(touches)
    total = np.sum([touch.force for touch in found], axis=0).tolist()
    return ContactState(
        "",
        one.replace("/", "::"),
        other.replace("/", "::"),
        [Wrench(Vector3(*touch.force)) for touch in found],
        Wrench(Vector3(*total)),
        [Vector3(*touch.position) for touch in found],
        [Vector3(*touch.normal) for touch in found],
        np.array([touch.depth for touch in found]),
    )


def _reverse(touch: Touch) -> Touch:
    """Return a contact as seen from the other body."""
    one, other = touch.bodies
    return Touch((other, one), touch.position, _minus(touch.normal), touch.depth, _minus(touch.force))


def _minus(vector: Vector) -> Vector:
    return -vector[0], -vector[1], -vector[2]
