"""Sensors as a scene carries them: the data that files, engines and renderers need of any sensor.

Each sensor is a class of its own in :mod:`nrp_core.world.sensors`, or in a package of somebody else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar, Self

from nrp_core.world.rigid.pose import Pose


@dataclass(frozen=True, slots=True)
class Noise:
    """Gaussian noise on every number that a sensor gives.

    Args:
        mean: of the noise, in the unit of the measurement (for images, 1 is full brightness).
        stddev: likewise.
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
        horizontal_fov: radians.
        width, height: pixels.
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
        rate_hz: messages a second.
        noise: on every number that it gives.
        delay: from the measurement, which is the time in the stamp, to the arrival of its message, s.
        drop_out: share of the messages that get lost.

    Attributes:
        needs: what it needs of an engine, by fields of
            :class:`~nrp_core.world.capabilities.WorldCapabilities`.
        tag: names the kind of sensor in digests of scenes.
    """

    noise: Noise = field(default=Noise(), kw_only=True)
    delay: float = field(default=0.0, kw_only=True)
    drop_out: float = field(default=0.0, kw_only=True)
    name: str
    topic: str
    rate_hz: float

    needs: ClassVar[tuple[str, ...]] = ()
    tag: ClassVar[str] = ""

    @property
    def view(self) -> View | None:
        """The images that it is made of; None for a sensor that does not see."""
        return None

    @property
    def measured_joints(self) -> tuple[str, ...]:
        """The joints of its model whose forces it measures."""
        return ()

    @property
    def is_odometry(self) -> bool:
        """Whether it repeats the odometry of a drive on the same topic."""
        return False

    def renamed(self, named: Callable[[str], str]) -> Self:
        """Return the sensor of a model whose links and joints have other names."""
        del named  # only sensors that name joints differ
        return self
