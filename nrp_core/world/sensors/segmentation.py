"""Segmentation cameras: the class of what each pixel shows, and the instance of that class."""

from __future__ import annotations

from dataclasses import dataclass
from posixpath import join
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from nrp_core.errors import did_you_mean
from nrp_core.world.engine import Engine
from nrp_core.world.messages.sensor_msgs import CameraInfo, Image
from nrp_core.world.render.segments import SegmentArray
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.camera import Camera, info_of
from nrp_core.world.sensors.eye import Eye
from nrp_core.world.sensors.sensor import SensorPart
from nrp_core.world.topics import resolve_name

_SEMANTIC = "semantic"
_PANOPTIC = ("panoptic", "instance")


@dataclass(frozen=True, slots=True)
class SegmentationCamera(Eye):
    """A camera of labels, which gz-sim's ``Label`` plugin gives to visuals and models.

    Args:
        topic: absolute topic of the labels (``rgb8``): the label in all channels; of a panoptic one the label
            in the last channel, and the number of the instance in the first (low) and the second byte.
        colored_topic: that of the same as colours, a colour for each label (and instance).
        info_topic: that of its optics.
        panoptic: whether instances are told apart.
    """

    tag: ClassVar[str] = "segmentation"

    colored_topic: str
    info_topic: str
    panoptic: bool = False

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> SegmentationCamera:
        optics = Camera.read(sensor, mount, reading)
        kind = sensor.section("camera").word("segmentation_type", _SEMANTIC).lower()
        if kind not in (_SEMANTIC, *_PANOPTIC):
            given = sensor.require("camera").require("segmentation_type")
            hint = did_you_mean(kind, (_SEMANTIC, *_PANOPTIC))
            raise given.error(f"'{given.text}' is not a <segmentation_type>{hint}")
        base = sensor.word("topic", reading.topic_of(mount.name, f"{optics.name}/segmentation"))
        labels, colored, info = (
            resolve_name(join(base, end), reading.robot)
            for end in ("labels_map", "colored_map", "camera_info")
        )
        return cls(optics.name, labels, optics.rate_hz, optics, colored, info, kind in _PANOPTIC)

    def part(self, model: Model, link: str, engine: Engine) -> SegmentationPart:
        return SegmentationPart(self, model.name, link, engine)


class SegmentationPart(SensorPart):
    """Publishes the labels of one camera."""

    def __init__(self, sensor: SegmentationCamera, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._sensor, self._path = sensor, (model, link, sensor.name)
        what = f"seen by {sensor.name}"
        self.topics = (
            self._served(sensor.topic, Image, f"labels {what}"),
            self._served(sensor.colored_topic, Image, f"labels {what}, as colours"),
            self._served(sensor.info_topic, CameraInfo, f"optics of {sensor.name}"),
        )

    def read(self, topic: str, now_ns: int) -> Any:
        header = self._header(now_ns)
        if topic == self._sensor.info_topic:
            return info_of(self._sensor.optics, header, self._engine.image_size(*self._path))
        segments = self._engine.segments(*self._path)
        painted = colors_of if topic == self._sensor.colored_topic else bytes_of
        image = painted(segments, panoptic=self._sensor.panoptic)
        height, width, channels = image.shape
        return Image(header, height, width, "rgb8", 0, width * channels, image)


def bytes_of(segments: SegmentArray, *, panoptic: bool) -> npt.NDArray[np.uint8]:
    """Return segments as gz-sim's map of labels, shape ``(height, width, 3)``."""
    labels, instances = segments[..., 0], segments[..., 1]
    channels = (instances & 255, instances >> 8, labels) if panoptic else (labels, labels, labels)
    return np.stack(channels, axis=-1).astype(np.uint8)


def colors_of(segments: SegmentArray, *, panoptic: bool) -> npt.NDArray[np.uint8]:
    """Return a colour for each label (and instance), black for none, shape ``(height, width, 3)``.

    They are those of the PASCAL VOC data sets: the bits of the number are dealt out to red, green and blue,
    the highest bits first.
    """
    numbers = segments[..., 0].astype(np.uint32)
    if panoptic:
        numbers |= (segments[..., 1].astype(np.uint32) & 0xFFFF) << 8
    image = np.zeros((*numbers.shape, 3), np.uint8)
    for bit in range(8):
        for channel in range(3):
            image[..., channel] |= ((numbers >> (3 * bit + channel) & 1) << (7 - bit)).astype(np.uint8)
    return image
