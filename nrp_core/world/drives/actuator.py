"""Actuators that only one engine has, such as adhesion, muscles and motors of tendons."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Any, ClassVar

from nrp_core.findings import Code
from nrp_core.world.drives.drive import Drive
from nrp_core.world.engine import Engine
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.part import Part
from nrp_core.world.scene.acting import Rename
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.topics import Direction, TopicInfo, resolve_name


@dataclass(frozen=True, slots=True)
class Actuator(Drive):
    """An actuator among the elements for one engine; its control is commanded (``std_msgs/Float64``).

    Args:
        lowest, highest: the range of its control; the engine clips it.
    """

    tag: ClassVar[str] = "actuator"

    lowest: float = -inf
    highest: float = inf

    def renamed(self, named: Rename) -> Actuator:
        """Return the same actuator for a model whose parts are renamed."""
        return replace(self, name=named(self.name))

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
            message = f"{type(engine).__name__} does not have the actuator '{actuator.name}' of '{model}'"
            engine.warnings.add(Code.NRP345, message, subject=actuator.name)

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
