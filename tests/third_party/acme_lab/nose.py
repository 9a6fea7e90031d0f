"""A sensor with a state and noise: a nose in a plume, whose receptor adapts."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import dist, exp
from typing import Any, ClassVar

from nrp_core.messages import message
from nrp_core.messages.std_msgs import Header
from nrp_core.world import (
    Element,
    Engine,
    Model,
    Mount,
    Pose,
    Reading,
    Sensor,
    SensorPart,
    noise_of,
    rate_of,
    topic_of,
)


@message("acme_msgs/msg/Smell")
@dataclass(slots=True)
class Smell:
    """Concentration, from 0 to 1, and the response of a receptor that adapts to it."""

    header: Header = field(default_factory=Header)
    concentration: float = 0.0
    response: float = 0.0


@dataclass(frozen=True, slots=True)
class Nose(Sensor):
    """Measures a Gaussian plume around the origin of the world.

    Args:
        pose: in the frame of its link.
        width: standard deviation of the plume, m.
        tau: time constant of the adaptation, s.
    """

    needs: ClassVar[tuple[str, ...]] = ("links",)

    pose: Pose
    width: float
    tau: float

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Nose:
        own = sensor.section("acme_nose")
        name = sensor.attribute("name")
        return cls(
            name, topic_of(sensor, reading.topic_of(mount.name, name), {}, reading),
            rate_of(sensor, reading), mount.place(sensor),
            own.positive("width", 1.0), own.positive("tau", 0.5), noise=noise_of(own, reading),
        )  # fmt: skip

    def part(self, model: Model, link: str, engine: Engine) -> NosePart:
        return NosePart(self, model.name, link, engine)


class NosePart(SensorPart):
    """Publishes what one nose smells."""

    def __init__(self, sensor: Nose, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._nose, self._state = sensor, (0, 0.0)
        self.topics = (self._served(sensor.topic, Smell, f"smell at {model}/{link}"),)

    def read(self, topic: str, now_ns: int) -> Smell:
        place = self._engine.link_motion(*self._place).at(self._nose.pose).pose.position
        smell = exp(-((dist(place, (0.0, 0.0, 0.0)) / self._nose.width) ** 2) / 2)
        smell += float(self._noise(topic, now_ns, ()))
        then_ns, level = self._state
        level = smell + (level - smell) * exp((then_ns - now_ns) * 1e-9 / self._nose.tau)
        self._state = now_ns, level
        return Smell(self._header(now_ns), smell, smell - level)

    def reset(self) -> None:
        self._state = 0, 0.0

    def save(self) -> object:
        return self._state

    def restore(self, saved: Any) -> None:
        self._state = saved
