"""Cameras: pictures, depth, optics."""

from __future__ import annotations

from math import tan
from typing import Any

import numpy as np

from nrp_core.world.engine import Engine
from nrp_core.world.messages.sensor_msgs import CameraInfo, Image
from nrp_core.world.render.cameras import ImageArray
from nrp_core.world.scene.sensing import Camera
from nrp_core.world.sensors.sensor import SensorPart


class CameraPart(SensorPart):
    """Serves one camera."""

    def __init__(self, camera: Camera, model: str, link: str, engine: Engine) -> None:
        super().__init__(camera, model, link, engine)
        self._camera = camera
        self._is_noisy = bool(camera.noise)
        self._path = (model, link, camera.name)
        size = f"{camera.name}, {camera.width}x{camera.height}"
        topics = [self._served(camera.topic, Image, f"camera {size}")]
        if camera.depth_topic is not None:
            topics.append(self._served(camera.depth_topic, Image, f"depth of {size}, m"))
        if camera.info_topic is not None:
            topics.append(self._served(camera.info_topic, CameraInfo, f"optics of {size}"))
        self.topics = tuple(topics)

    def read(self, topic: str, now_ns: int) -> Any:
        if topic == self._camera.info_topic:
            return self._info(now_ns)
        header = self._header(now_ns)
        if topic == self._camera.depth_topic:
            depth = self._engine.depth(*self._path)
            if self._is_noisy:
                depth = depth + np.asarray(self._noise(topic, now_ns, depth.shape), np.float32)
                depth.flags.writeable = False
            height, width = depth.shape
            return Image(header, height, width, "32FC1", 0, 4 * width, depth)  # type: ignore[arg-type]
        picture = self._engine.render(*self._path)
        if self._is_noisy:
            picture = self._with_noise(picture, topic, now_ns)
        height, width, channels = picture.shape
        return Image(header, height, width, "rgb8", 0, width * channels, picture)

    def _with_noise(self, picture: ImageArray, topic: str, now_ns: int) -> ImageArray:
        noisy = picture + 255 * self._noise(topic, now_ns, picture.shape)
        result: ImageArray = np.rint(noisy).clip(0, 255).astype(np.uint8)
        result.flags.writeable = False
        return result

    def _info(self, now_ns: int) -> CameraInfo:
        height, width = self._engine.picture_size(*self._path)
        focal = width / 2 / tan(self._camera.horizontal_fov / 2)
        k = np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])
        p = np.column_stack([k, np.zeros(3)])
        size = self._header(now_ns), height, width
        return CameraInfo(*size, d=np.zeros(5), k=k.ravel(), r=np.eye(3).ravel(), p=p.ravel())
