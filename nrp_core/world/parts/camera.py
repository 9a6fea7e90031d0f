"""Cameras."""

from __future__ import annotations

from nrp_core.world.messages.base import Time
from nrp_core.world.messages.sensor_msgs import Image
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.parts.base import Engine, Part
from nrp_core.world.scene.model import Camera
from nrp_core.world.topics import Direction, TopicInfo


class CameraPart(Part):
    """Serves the pictures of one camera."""

    def __init__(self, camera: Camera, model: str, link: str, engine: Engine) -> None:
        self._path = (model, link, camera.name)
        self._engine = engine
        self._frame = f"{model}/{link}"
        what = f"camera {camera.name}, {camera.width}x{camera.height}"
        self.topics = (TopicInfo(camera.topic, Image, Direction.OUT, camera.rate_hz, what),)

    def read(self, topic: str, now_ns: int) -> Image:
        picture = self._engine.render(*self._path)
        height, width, channels = picture.shape
        header = Header(Time.from_ns(now_ns), self._frame)
        return Image(header, height, width, "rgb8", 0, width * channels, picture)
