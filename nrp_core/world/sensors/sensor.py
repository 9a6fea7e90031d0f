"""The base classes of sensors: their data in a file, and the part of a world that publishes them.

A sensor is a subclass of :class:`Sensor` and a subclass of :class:`SensorPart`, in one module. It is found by
entry points in the group ``nrp_core.sensors``: their names are the types of ``<sensor>`` that it reads, or
``plugin.`` and the name of a ``<plugin>`` of a model.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import NS_PER_S
from nrp_core.messages.base import Time
from nrp_core.messages.std_msgs import Header
from nrp_core.scene.devices import Imperfection, MountedSensor, Noise
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts
from nrp_core.scene.reading.sensors import Mount
from nrp_core.scene.rigid import Vector
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.sensors.errors import Errors
from nrp_core.world.topics import Direction, TopicInfo


def with_imperfection(
    scene: Scene,
    topic: str,
    *,
    noise: Noise | None = None,
    delay: float | None = None,
    drop_out: float | None = None,
) -> Scene:
    """Return a scene with changed properties of a topic; None keeps the value of a sensor's file.

    The topic of a sensor gets them in its sensor, any other in :attr:`.Scene.imperfections`.

    Args:
        scene: the scene.
        topic: its absolute topic.
        noise: noise on every number.
        delay: delay of messages, s.
        drop_out: share of lost messages.
    """
    given: dict[str, Any] = {"noise": noise, "delay": delay, "drop_out": drop_out}
    changes = {name: value for name, value in given.items() if value is not None}
    served = [each for _, link in scene.links() for sensor in link.sensors for each in sensor.topics]
    if topic not in served:
        imperfection = replace(dict(scene.imperfections).get(topic, Imperfection()), **changes)
        others = tuple(each for each in scene.imperfections if each[0] != topic)
        return replace(scene, imperfections=(*others, (topic, imperfection)))

    def changed(model: Model) -> Model:
        if all(topic not in sensor.topics for link in model.links for sensor in link.sensors):
            return model
        links = []
        for link in model.links:
            sensors = [_with(each, changes) if topic in each.topics else each for each in link.sensors]
            links.append(replace(link, sensors=tuple(sensors)))
        return replace(model, links=tuple(links))

    return replace(scene, models=tuple(map(changed, scene.models)))


def _with(sensor: MountedSensor, changes: dict[str, Any]) -> MountedSensor:
    """Return a sensor with other properties; noise on every number replaces that of some of them."""
    own: dict[str, Any] = dict.fromkeys(sensor.noises) if "noise" in changes else {}
    return replace(sensor, **changes, **own)


class Sensor(MountedSensor, ABC):
    """The data of a sensor; a subclass is a frozen dataclass with slots whose fields are its parameters.

    Attributes:
        on_joint: whether its ``<sensor>`` is in a ``<joint>`` instead of a ``<link>``.
    """

    __slots__ = ()

    on_joint: ClassVar[bool] = False

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Sensor:
        """Read a ``<sensor>``; needed if the sensor is registered for a type.

        Args:
            sensor: the element.
            mount: the link or joint that holds it.
            reading: receives warnings and resolves topics.
        """
        raise NotImplementedError(f"{cls.__name__} cannot be read from a <sensor>")

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, Sensor]:
        """Read a ``<plugin>`` of a model; needed if the sensor is registered for a plugin.

        Returns:
            The link that it measures, and the sensor.
        """
        raise NotImplementedError(f"{cls.__name__} cannot be read from a <plugin>")

    @abstractmethod
    def part(self, model: Model, link: str, engine: Engine) -> SensorPart:
        """Return the part that publishes the sensor on a link of a model."""


class SensorPart(Part):
    """The part of a world that publishes a sensor on a link.

    Args:
        sensor: its data.
        model: its model.
        link: its link.
        engine: the engine that is measured.
    """

    def __init__(self, sensor: Sensor, model: str, link: str, engine: Engine) -> None:
        self._place = (model, link)
        self._frame = sensor.frame_on(model, link)
        self._engine = engine
        self._imperfect = sensor
        self._errors = Errors(lambda: engine.seed)

    def _served(self, topic: str, kind: type, what: str) -> TopicInfo:
        """Return the description of a topic of this sensor."""
        sensor = self._imperfect
        rate_hz = sensor.rate_hz or NS_PER_S / self._engine.step_ns
        return TopicInfo(
            topic, kind, Direction.OUT, rate_hz, what, delay=sensor.delay, drop_out=sensor.drop_out
        )

    def _header(self, now_ns: int) -> Header:
        return Header(Time.from_ns(now_ns), self._frame)

    def _measured(self, topic: str, now_ns: int, numbers: Any, noise: Noise | None = None) -> FloatArray:
        """Return numbers with the errors of the sensor, or with another noise; they have a common bias."""
        noise = self._imperfect.noise if noise is None else noise
        numbers = np.asarray(numbers, np.float64)
        return self._errors.on(topic, now_ns, numbers, noise) if noise else numbers

    def _noise(self, topic: str, now_ns: int, shape: Any) -> FloatArray:
        """Return the errors of numbers of a shape; they depend on the seed, the topic and the time."""
        return self._measured(topic, now_ns, np.zeros(shape))

    def _noisy(
        self, topic: str, now_ns: int, *vectors: Vector, own: Sequence[Noise | None] = ()
    ) -> list[Vector]:
        """Return vectors with errors; ``own`` is the noise of each, None for the noise of all numbers."""
        noises = [self._imperfect.noise if one is None else one for one in own or (None,) * len(vectors)]
        if not any(noises):
            return list(vectors)
        each = [axis for noise in noises for axis in noise.on(3)]
        numbers = self._errors.on(topic, now_ns, np.array(vectors), each)
        return [(x, y, z) for x, y, z in numbers.tolist()]

    def reset(self) -> None:
        self._errors.biases.clear()

    def save(self) -> object:
        return dict(self._errors.biases)

    def restore(self, saved: Any) -> None:
        self._errors.biases = dict(saved)
