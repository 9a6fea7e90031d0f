"""Delay, noise and drop-outs of all messages of the world; sensors have their own."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import NS_PER_S
from nrp_core.messages.geometry_msgs import Quaternion
from nrp_core.scene.devices import Imperfection
from nrp_core.seeds import Seeds
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part, PartProxy
from nrp_core.world.topics import Direction, TopicInfo

Draw = Callable[[int], FloatArray]
"""Returns this many random numbers."""


class ImperfectPart(PartProxy):
    """A part whose messages are noisy, late, or get lost.

    The value of a topic without a rate is sampled at each physics step if it is late or gets lost; its last
    sample that has arrived is then the value.

    Args:
        inner: the part.
        imperfections: those of its topics, by name.
        engine: the engine, with the seed and the physics step.
    """

    def __init__(self, inner: Part, imperfections: Mapping[str, Imperfection], engine: Engine) -> None:
        super().__init__(inner)
        self._imperfections, self._engine = imperfections, engine
        self.topics = tuple(map(self._describe, inner.topics))

    def _describe(self, topic: TopicInfo) -> TopicInfo:
        given = self._imperfections.get(topic.name)
        if given is None:
            return topic
        rate_hz = topic.rate_hz
        if rate_hz is None and (given.delay or given.drop_out):
            rate_hz = NS_PER_S / self._engine.step_ns
        return replace(topic, rate_hz=rate_hz, delay=given.delay, drop_out=given.drop_out)

    def read(self, topic: str, now_ns: int) -> Any:
        message = self.inner.read(topic, now_ns)
        given = self._imperfections.get(topic)
        if given is None or given.noise is None:
            return message
        mean, stddev = given.noise.mean, given.noise.stddev
        stream = Seeds(self._engine.seed).child("world/noise").stream(f"{topic}@{now_ns}")
        return with_noise(message, lambda n: np.asarray(stream.normal(mean, stddev, n)))


def imperfect(part: Part, engine: Engine) -> Part:
    """Return a part with the imperfections that a scene gives to its topics."""
    given = dict(engine.scene.imperfections)
    own = {
        topic.name: given[topic.name]
        for topic in part.topics
        if topic.name in given and topic.direction & Direction.OUT and topic.name not in part.pushed_topics
    }
    return ImperfectPart(part, own, engine) if own else part


def with_noise(message: Any, draw: Draw) -> Any:
    """Return a message with noise on every number but its stamps and covariances.

    An orientation turns by three angles about its own axes, rad.

    Args:
        message: a message, or a value in one.
        draw: returns the noise of some numbers, in the order of the fields.
    """
    if isinstance(message, Quaternion):
        return _turned(message, draw(3))
    if isinstance(message, float):
        return message + float(draw(1)[0])
    if isinstance(message, np.ndarray) and message.dtype.kind == "f":
        return message + draw(message.size).reshape(message.shape)
    if isinstance(message, list):
        return [with_noise(each, draw) for each in message]
    if not dataclasses.is_dataclass(message) or isinstance(message, type):
        return message
    names = [field.name for field in dataclasses.fields(message)]
    noisy = [name for name in names if name not in ("header", "stamp") and "covariance" not in name]
    return replace(message, **{name: with_noise(getattr(message, name), draw) for name in noisy})


def _turned(q: Quaternion, angles: FloatArray) -> Quaternion:
    """Return an orientation that is turned about its own axes by angles, rad, shape ``(3,)``."""
    angle = float(np.linalg.norm(angles))
    x, y, z = (angles * (np.sin(angle / 2) / angle if angle else 0.5)).tolist()
    w = float(np.cos(angle / 2))
    return Quaternion(
        q.w * x + q.x * w + q.y * z - q.z * y,
        q.w * y - q.x * z + q.y * w + q.z * x,
        q.w * z + q.x * y - q.y * x + q.z * w,
        q.w * w - q.x * x - q.y * y - q.z * z,
    )
