"""What all sensors have in common: a place on a link, a stamp, and noise from a stream of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.seeds import Seeds
from nrp_core.world.engine import Engine
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.std_msgs import Header
from nrp_core.world.part import Part
from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.sensing import Sensor
from nrp_core.world.topics import Direction, TopicInfo


class SensorPart(Part):
    """A sensor on a link.

    Args:
        sensor: what it is.
        model: its model.
        link: its link.
        engine: measures.
    """

    def __init__(self, sensor: Sensor, model: str, link: str, engine: Engine) -> None:
        self._place = (model, link)
        self._frame = f"{model}/{link}"
        self._engine = engine
        self._imperfect = sensor

    def _served(self, topic: str, kind: type, what: str) -> TopicInfo:
        """Return what is known of a topic of this sensor."""
        sensor = self._imperfect
        return TopicInfo(
            topic, kind, Direction.OUT, sensor.rate_hz, what, delay=sensor.delay, drop_out=sensor.drop_out
        )

    def _header(self, now_ns: int) -> Header:
        return Header(Time.from_ns(now_ns), self._frame)

    def _noise(self, topic: str, now_ns: int, shape: Any) -> npt.NDArray[np.float64] | float:
        """Return noise for numbers of a shape; equal times of equal runs, equal noise."""
        noise = self._imperfect.noise
        if not noise:
            return 0.0
        stream = Seeds(self._engine.seed).child("world/noise").stream(f"{topic}@{now_ns}")
        return np.asarray(stream.normal(noise.mean, noise.stddev, shape))

    def _noisy(self, topic: str, now_ns: int, *vectors: Vector) -> list[Vector]:
        """Return vectors with noise."""
        numbers = np.array(vectors) + self._noise(topic, now_ns, (len(vectors), 3))
        return [(x, y, z) for x, y, z in numbers.tolist()]
