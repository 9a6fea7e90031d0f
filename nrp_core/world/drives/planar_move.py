"""Bases that go in any direction on the ground, without wheels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import ClassVar

from nrp_core.world.drives.drive import Drive, DrivePart
from nrp_core.world.engine import Engine
from nrp_core.world.rigid.motion import BodyVelocity
from nrp_core.world.scene.acting import Rename
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import ros_topic
from nrp_core.world.scene.reading.registered import ModelParts
from nrp_core.world.scene.reading.xml import Element


@dataclass(frozen=True, slots=True)
class PlanarMove(Drive):
    """A base that goes forward, sideways and turns as a Twist commands, without wheels.

    Its base slides without friction. Its fields are those of
    :class:`~nrp_core.world.drives.wheels.WheelDrive`.
    """

    tag: ClassVar[str] = "planar_move"
    components: ClassVar[tuple[str, ...]] = ("linear.x", "linear.y", "angular.z")

    timeout: float = inf
    rate_hz: float = 20.0
    odometry_topic: str | None = None
    wheel_speeds_topic: None = None

    def renamed(self, named: Rename) -> PlanarMove:
        """Return the same drive for a model whose parts are renamed."""
        return replace(self, name=named(self.name))

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> PlanarMove:
        timeout = plugin.number("cmdTimeout", -1.0)  # none if it is not above 0
        return cls(
            plugin.attribute("name"),
            ros_topic(plugin, plugin.word("commandTopic", "cmd_vel"), reading),
            timeout=timeout if timeout > 0 else plugin.positive("commandTimeout", inf),
            rate_hz=plugin.number("odometryRate", 0.0) or plugin.positive("publish_rate", 20.0),
            odometry_topic=ros_topic(plugin, plugin.word("odometryTopic", "odom"), reading),
        )

    def part(self, model: Model, engine: Engine) -> PlanarMovePart:
        return PlanarMovePart(self, model, engine)


class PlanarMovePart(DrivePart):
    """Runs one such base."""

    def _commanded(
        self, x: float, y: float, z: float, roll: float, pitch: float, turn: float
    ) -> BodyVelocity:
        return BodyVelocity(x, y, turn)
