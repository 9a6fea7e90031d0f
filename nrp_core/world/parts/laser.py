"""Laser scanners."""

from __future__ import annotations

import numpy as np

from nrp_core.world.messages.sensor_msgs import LaserScan
from nrp_core.world.parts.base import Engine
from nrp_core.world.parts.sensor import SensorPart
from nrp_core.world.scene.sensing import Laser


class LaserPart(SensorPart):
    """Serves the scans of one laser: what its rays meet of the collision shapes of everything else."""

    def __init__(self, laser: Laser, model: str, link: str, engine: Engine) -> None:
        super().__init__(laser, model, link, engine)
        self._laser = laser
        self.topics = (self._served(laser.topic, LaserScan, f"laser {laser.name}, {laser.samples} rays"),)

    def read(self, topic: str, now_ns: int) -> LaserScan:
        laser = self._laser
        ranges = self._engine.scan(*self._place, laser)
        if laser.noise:
            ranges = np.clip(ranges + self._noise(topic, now_ns, ranges.shape), 0.0, None)
        step = (laser.angle_max - laser.angle_min) / max(1, laser.samples - 1)
        return LaserScan(
            self._header(now_ns), laser.angle_min, laser.angle_max, step, 0.0, 0.0,
            laser.range_min, laser.range_max, ranges.astype(np.float32),
        )  # fmt: skip
