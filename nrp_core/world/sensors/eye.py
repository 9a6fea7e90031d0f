"""Eyes: sensors whose messages are computed from the images of a camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import View
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.sensors.sensor import Sensor
from nrp_core.world.topics import resolve_name


@dataclass(frozen=True, slots=True)
class Eye(Sensor):
    """A sensor behind a lens.

    Args:
        optics: the camera that sees the images.
    """

    needs: ClassVar[tuple[str, ...]] = ("renderers",)

    frame_suffix: ClassVar[str] = Camera.frame_suffix

    optics: Camera

    @property
    def view(self) -> View | None:
        """The images that it consists of; None: several views."""
        return self.optics.view

    @property
    def offset(self) -> Pose:
        return self.optics.offset


def topic_of(sensor: Element, mount: Mount, reading: Reading, last: str) -> str:
    """Return the absolute topic of a sensor: its ``<topic>``, or its place and name, and a last part."""
    default = reading.topic_of(mount.name, f"{sensor.attribute('name')}/{last}")
    return resolve_name(sensor.word("topic", default), reading.robot)
