"""Sensors in a scene: the data that files, engines and renderers need of any sensor.

Each sensor is a class in :mod:`nrp_core.world.sensors` or in another package.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import ClassVar, Self

from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.digest import LATER


@dataclass(frozen=True, slots=True)
class Noise:
    """Gaussian noise on every number of a sensor.

    Args:
        mean: mean of the noise, in the unit of the measurement (for images, 1 is full brightness).
        stddev: standard deviation, in the same unit.
    """

    mean: float = 0.0
    stddev: float = 0.0

    def __bool__(self) -> bool:
        return bool(self.mean or self.stddev)


@dataclass(frozen=True, slots=True)
class View:
    """The images that an engine draws for a sensor: along x of its pose, z up.

    Args:
        pose: in the frame of the sensor's link.
        horizontal_fov: horizontal field of view, rad.
        width, height: size, pixels.
        near, far: clip distances in m.
    """

    pose: Pose
    horizontal_fov: float
    width: int
    height: int
    near: float
    far: float


@dataclass(frozen=True, slots=True)
class MountedSensor:
    """A sensor on a link.

    Args:
        name: unique on its link.
        topic: absolute topic of its messages. Further fields whose names end in ``topic`` are topics as well.
        rate_hz: messages per second.
        noise: noise on every number.
        delay: from the measurement, which is the time in the stamp, to the arrival of its message, s.
        drop_out: share of lost messages.
        frame_name: the frame of its messages in its model, a link or one of its own; empty for the usual one.

    Attributes:
        needs: the capabilities that it needs, fields of
            :class:`~nrp_core.world.capabilities.WorldCapabilities`.
        tag: name of the kind of sensor in digests of scenes.
        frame_suffix: what a frame of its own has after the name of the sensor.
        noises: fields with the noise of some of the numbers in place of ``noise``; None is none of their own.
    """

    noise: Noise = field(default=Noise(), kw_only=True)
    delay: float = field(default=0.0, kw_only=True)
    drop_out: float = field(default=0.0, kw_only=True)
    frame_name: str = field(default="", kw_only=True, metadata=LATER)
    name: str
    topic: str
    rate_hz: float

    needs: ClassVar[tuple[str, ...]] = ()
    tag: ClassVar[str] = ""
    frame_suffix: ClassVar[str] = ""
    noises: ClassVar[tuple[str, ...]] = ()

    @property
    def topics(self) -> list[str]:
        """Its topics: it may publish several forms of its measurement."""
        return list(self.topics_by_field.values())

    @property
    def topics_by_field(self) -> dict[str, str]:
        """Its topics by the names of its fields."""
        given = {one.name: getattr(self, one.name) for one in fields(self) if one.name.endswith("topic")}
        return {name: topic for name, topic in given.items() if topic}

    @property
    def view(self) -> View | None:
        """The images that it consists of; None for a sensor without images."""
        return None

    @property
    def views(self) -> Mapping[str, View]:
        """All images that an engine draws for it, by names that are unique on its link: usually its own."""
        return {} if self.view is None else {self.name: self.view}

    @property
    def offset(self) -> Pose | None:
        """The pose of the frame of its messages in that of its link; None: the link's own."""
        return None

    def frame_on(self, model: str, link: str) -> str:
        """Return the name of the frame of its messages: ``model/link``, or its own, ``model/link/sensor``."""
        if self.frame_name:
            return f"{model}/{self.frame_name}"
        own = f"{self.name}{self.frame_suffix}"
        return f"{model}/{link}" if self.offset in (None, Pose()) else f"{model}/{link}/{own}"

    @property
    def measured_joints(self) -> tuple[str, ...]:
        """The joints of its model in which it measures forces."""
        return ()

    @property
    def is_odometry(self) -> bool:
        """Whether it repeats the odometry of a drive on the same topic."""
        return False

    def renamed(self, named: Callable[[str], str]) -> Self:
        """Return the same sensor for a model whose links and joints are renamed."""
        return replace(self, frame_name=named(self.frame_name)) if self.frame_name else self
