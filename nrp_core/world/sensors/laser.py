"""Laser scanners."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from nrp_core.world.engine import Engine
from nrp_core.world.messages.point_cloud2 import create_cloud
from nrp_core.world.messages.sensor_msgs import LaserScan, PointCloud2
from nrp_core.world.raycast.beams import directions
from nrp_core.world.scene.sensing import Laser
from nrp_core.world.sensors.sensor import SensorPart

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2")])
"""A point of a cloud in the frame of its link; its ring is its layer, from the lowest."""


class LaserPart(SensorPart):
    """Serves the scans of one laser: what its rays meet of the collision shapes of everything else."""

    def __init__(self, laser: Laser, model: str, link: str, engine: Engine) -> None:
        super().__init__(laser, model, link, engine)
        self._laser = laser
        rays = f"laser {laser.name}, {laser.samples} rays"
        self.topics = (self._served(laser.topic, LaserScan, rays),)
        if laser.points_topic is not None:
            layers = f"{rays} in {laser.layers} layer{'s' if laser.layers > 1 else ''}"
            self.topics += (self._served(laser.points_topic, PointCloud2, layers),)

    def read(self, topic: str, now_ns: int) -> LaserScan | PointCloud2:
        ranges = self._ranges(now_ns)
        return (
            self._points(ranges, now_ns) if topic == self._laser.points_topic else self._scan(ranges, now_ns)
        )

    def _ranges(self, now_ns: int) -> npt.NDArray[np.float64]:
        """Return the distances along all rays, shape ``(layers, samples)``."""
        laser = self._laser
        ranges = self._engine.scan(*self._place, laser).reshape(laser.layers, laser.samples)
        if laser.noise:
            ranges = np.clip(
                ranges + self._noise(laser.topic, now_ns, ranges.shape), 0.0, None
            )  # equal in all forms
        return ranges

    def _scan(self, ranges: npt.NDArray[np.float64], now_ns: int) -> LaserScan:
        right, left, step, nearest, farthest = _constants(self._laser)
        middle = ranges[self._laser.layers // 2].astype(np.float32)
        return LaserScan(self._header(now_ns), right, left, step, 0.0, 0.0, nearest, farthest, middle)

    def _points(self, ranges: npt.NDArray[np.float64], now_ns: int) -> PointCloud2:
        """Return a row of points for each layer; where nothing was met they are no numbers."""
        laser = self._laser
        points = np.zeros(ranges.shape, POINT)
        met = np.where(np.isfinite(ranges), ranges, np.nan)
        for axis, along, start in zip("xyz", _turned(laser).T, laser.pose.position, strict=True):
            points[axis] = along.reshape(ranges.shape) * met + start
        points["ring"] = np.arange(laser.layers)[:, None]
        return create_cloud(self._header(now_ns), points)


@cache
def _constants(laser: Laser) -> list[float]:
    """Return angles, the step between them, and reach: of single precision, as a message carries them."""
    step = (laser.angle_max - laser.angle_min) / max(1, laser.samples - 1)
    numbers = laser.angle_min, laser.angle_max, step, laser.range_min, laser.range_max
    return [float(np.float32(number)) for number in numbers]


@cache
def _turned(laser: Laser) -> npt.NDArray[np.float64]:
    """Return the directions in the frame of the link."""
    return np.array([laser.pose.rotate((x, y, z)) for x, y, z in directions(laser).tolist()])
