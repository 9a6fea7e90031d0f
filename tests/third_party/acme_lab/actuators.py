"""A drive, which pushes a link, and a controller of a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nrp_core.messages.base import resolve_name
from nrp_core.messages.std_msgs import Float64
from nrp_core.world import (
    Actuators,
    Direction,
    Drive,
    Element,
    Engine,
    JointController,
    Model,
    ModelParts,
    Part,
    Pid,
    Reading,
    TopicInfo,
    Wrench,
)


@dataclass(frozen=True, slots=True)
class Thruster(Drive):
    """Pushes a link along the x axis of the world.

    Args:
        link: the link.
        newton: the force for a command of 1, N.
    """

    link: str
    newton: float

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Thruster:
        link = model.link(plugin.require("link")).name
        topic = resolve_name(plugin.word("topic", "thrust"), reading.robot)
        return cls(plugin.attribute("name"), topic, link, plugin.positive("newton", 1.0))

    def part(self, model: Model, engine: Engine) -> ThrusterPart:
        return ThrusterPart(self, model.name, engine)


class ThrusterPart(Part):
    """Applies the force; a command holds until the next one."""

    def __init__(self, drive: Thruster, model: str, engine: Engine) -> None:
        self._drive, self._model, self._engine = drive, model, engine
        what = f"force on {model}/{drive.link}"
        self.topics = (TopicInfo(drive.command_topic, Float64, Direction.IN, what=what),)
        self._command = 0.0

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self._push(message.data)

    def _push(self, command: float) -> None:
        self._command = command
        wrench = Wrench((command * self._drive.newton, 0.0, 0.0))
        self._engine.set_wrench(self._model, self._drive.link, wrench, self._drive.name)

    def reset(self) -> None:
        self._push(0.0)

    def save(self) -> object:
        return self._command

    def restore(self, saved: Any) -> None:
        self._push(saved)


def read_hinge(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read a ``<plugin>`` with a ``<joint>``, which follows positions on the topic ``hinge``."""
    joint = model.joint(plugin.require("joint")).name
    topic = resolve_name("hinge", reading.robot)
    gains = Pid(plugin.positive("p", 10.0), 0.0, 1.0)
    return Actuators(controllers=(JointController(joint, "position", topic, gains, 0.0),))
