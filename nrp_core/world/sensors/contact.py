"""Contacts: sensors on links, and all contacts of a world."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from nrp_core.world.engine import Engine
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.gazebo_msgs import ContactsState, ContactState
from nrp_core.world.messages.geometry_msgs import Vector3, Wrench
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.part import Part
from nrp_core.world.rigid.motion import Touch
from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensor_elements import rate_of, topic_of
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.sensor import Sensor, SensorPart
from nrp_core.world.topics import Direction, TopicInfo

CONTACTS = "/gazebo/contact_point_data"
_TOPICS = {"gazebo_ros_bumper": "bumperTopicName"}

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
        topic = topic_of(sensor, usual, _TOPICS, reading)
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
            for seen, pair in ((touch, names), (_reversed(touch), names[::-1])):
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
            in_order = touch if one <= other else _reversed(touch)
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


def _reversed(touch: Touch) -> Touch:
    """Return a contact as seen from the other body."""
    one, other = touch.bodies
    return Touch((other, one), touch.position, _minus(touch.normal), touch.depth, _minus(touch.force))


def _minus(vector: Vector) -> Vector:
    return -vector[0], -vector[1], -vector[2]
