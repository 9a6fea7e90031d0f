"""What a robot senses with, as data; names and defaults are those of SDF.

Every sensor has a name, an absolute topic, a rate and a pose in the frame of its link; and each may be made
:class:`Imperfect`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from nrp_core.world.rigid.pose import Pose


@dataclass(frozen=True, slots=True)
class Noise:
    """Gaussian noise on every number that a sensor gives.

    Args:
        mean: of the noise, in the unit of what is measured (for pictures, 1 is full brightness).
        stddev: likewise.
    """

    mean: float = 0.0
    stddev: float = 0.0

    def __bool__(self) -> bool:
        return bool(self.mean or self.stddev)


@dataclass(frozen=True, slots=True, kw_only=True)
class Imperfect:
    """How a sensor differs from an ideal one.

    Args:
        noise: on every number that it gives.
        delay: from the measurement, which is what the stamp tells, to the arrival of its message, s.
        drop_out: share of the messages that get lost.
    """

    noise: Noise = Noise()
    delay: float = 0.0
    drop_out: float = 0.0


@dataclass(frozen=True, slots=True)
class Camera(Imperfect):
    """A colour camera that looks along x of its pose, z up; with a ``depth_topic`` it sees depth, too.

    Args:
        name: of the sensor.
        topic: absolute topic of its images.
        rate_hz: pictures a second.
        horizontal_fov: radians.
        width, height: pixels.
        near, far: clip distances in m.
        depth_topic: absolute topic of its depth images, None for a camera without.
        info_topic: absolute topic of its optics, None for none.
    """

    name: str
    topic: str
    rate_hz: float
    horizontal_fov: float
    width: int
    height: int
    near: float = 0.1
    far: float = 100.0
    pose: Pose = Pose()
    depth_topic: str | None = None
    info_topic: str | None = None


@dataclass(frozen=True, slots=True)
class Laser(Imperfect):
    """A scanner that measures distances, counter-clockwise from x of its pose, in one or several layers.

    Args:
        topic: absolute topic of the scans of its middle layer.
        angle_min, angle_max: of the first and last ray of a layer, rad.
        samples: number of rays of a layer, spread evenly from one to the other; a single one is at 0.
        range_min, range_max: distances that are measured, m.
        layers: how many, from the lowest; a single one is in the plane z = 0.
        elevation_min, elevation_max: of the first and last layer, rad, upwards from the plane.
        points_topic: absolute topic of the points of all layers, None for none.
    """

    name: str
    topic: str
    rate_hz: float
    samples: int = 640
    angle_min: float = -pi / 2
    angle_max: float = pi / 2
    range_min: float = 0.1
    range_max: float = 10.0
    pose: Pose = Pose()
    layers: int = 1
    elevation_min: float = 0.0
    elevation_max: float = 0.0
    points_topic: str | None = None


@dataclass(frozen=True, slots=True)
class Imu(Imperfect):
    """Orientation, turn rate and acceleration (that of free fall is 0) in the frame of its pose."""

    name: str
    topic: str
    rate_hz: float
    pose: Pose = Pose()


@dataclass(frozen=True, slots=True)
class ContactSensor(Imperfect):
    """Tells what touches its link; ``collisions`` names those that feel, by default all."""

    name: str
    topic: str
    rate_hz: float
    collisions: tuple[str, ...] = ()
    pose: Pose = Pose()


@dataclass(frozen=True, slots=True)
class ForceTorque(Imperfect):
    """The force and torque that a joint carries; the sensor belongs to the joint's child link.

    Args:
        joint: which joint of the model.
        frame: along whose axes: ``child``, ``parent`` or ``sensor``.
        onto_child: whether it is what the parent does to the child, or the reverse.
    """

    name: str
    topic: str
    rate_hz: float
    joint: str
    frame: str = "child"
    onto_child: bool = False
    pose: Pose = Pose()


@dataclass(frozen=True, slots=True)
class GroundTruth(Imperfect):
    """The true pose and velocity of its link (Gazebo's ``p3d``), in ``reference``, ``world`` or a model.

    Args:
        along_link: whether the velocities are told along the axes of the link.
    """

    name: str
    topic: str
    rate_hz: float
    pose: Pose = Pose()
    reference: str = "world"
    along_link: bool = False


Sensor = Camera | Laser | Imu | ContactSensor | ForceTorque | GroundTruth
