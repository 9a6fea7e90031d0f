"""ROS package sensor_msgs; SI units."""

from __future__ import annotations

from dataclasses import field
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import array_field, message
from nrp_core.messages.geometry_msgs import Quaternion, Vector3
from nrp_core.messages.std_msgs import Header


@message("sensor_msgs/msg/Image")
class Image:
    """An image, rows from top to bottom.

    ``data`` from the simulator is read-only, shape ``(height, width, channels)``; any buffer of ``height *
    step`` bytes is accepted.
    """

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    encoding: str = "rgb8"
    is_bigendian: int = 0
    step: int = 0
    data: npt.NDArray[np.uint8] = array_field(np.uint8)


@message("sensor_msgs/msg/CompressedImage")
class CompressedImage:
    """An image as the bytes of an image file; ``format`` names the kind, ``jpeg`` or ``png``."""

    header: Header = field(default_factory=Header)
    format: str = ""
    data: npt.NDArray[np.uint8] = array_field(np.uint8)


@message("sensor_msgs/msg/JointState")
class JointState:
    """Positions (rad, m), velocities and efforts of named joints."""

    header: Header = field(default_factory=Header)
    name: list[str] = field(default_factory=list)
    position: npt.NDArray[np.float64] = array_field()
    velocity: npt.NDArray[np.float64] = array_field()
    effort: npt.NDArray[np.float64] = array_field()


@message("sensor_msgs/msg/LaserScan")
class LaserScan:
    """Distances (m) along rays, counter-clockwise from ``angle_min``; ``inf`` for a ray that hit nothing."""

    header: Header = field(default_factory=Header)
    angle_min: float = 0.0
    angle_max: float = 0.0
    angle_increment: float = 0.0
    time_increment: float = 0.0
    scan_time: float = 0.0
    range_min: float = 0.0
    range_max: float = 0.0
    ranges: npt.NDArray[np.float32] = array_field(np.float32)
    intensities: npt.NDArray[np.float32] = array_field(np.float32)


@message("sensor_msgs/msg/Range")
class Range:
    """The distance (m) to the nearest object in a cone; ``inf`` if the cone is empty."""

    ULTRASOUND: ClassVar[int] = 0
    INFRARED: ClassVar[int] = 1

    header: Header = field(default_factory=Header)
    radiation_type: int = 0
    field_of_view: float = 0.0
    min_range: float = 0.0
    max_range: float = 0.0
    range: float = 0.0
    variance: float = 0.0


@message("sensor_msgs/msg/PointField")
class PointField:
    """A field of the points of a cloud: its name, its offset in the point's bytes, and its type."""

    INT8: ClassVar[int] = 1
    UINT8: ClassVar[int] = 2
    INT16: ClassVar[int] = 3
    UINT16: ClassVar[int] = 4
    INT32: ClassVar[int] = 5
    UINT32: ClassVar[int] = 6
    FLOAT32: ClassVar[int] = 7
    FLOAT64: ClassVar[int] = 8

    name: str = ""
    offset: int = 0
    datatype: int = 0
    count: int = 0


@message("sensor_msgs/msg/PointCloud2")
class PointCloud2:
    """Points in the frame of the header, as bytes in the layout of ``fields``.

    :mod:`nrp_core.messages.point_cloud2` reads and makes them.
    """

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    fields: list[PointField] = field(default_factory=list)
    is_bigendian: bool = False
    point_step: int = 0
    row_step: int = 0
    data: npt.NDArray[np.uint8] = array_field(np.uint8)
    is_dense: bool = False


@message("sensor_msgs/msg/Imu")
class Imu:
    """Orientation in the world, turn rate (rad/s) and acceleration (m/s^2) in the sensor's frame.

    Acceleration is that of an accelerometer: gravity upwards at rest, zero in free fall. Covariances are 3x3,
    row by row.
    """

    header: Header = field(default_factory=Header)
    orientation: Quaternion = field(default_factory=Quaternion)
    orientation_covariance: npt.NDArray[np.float64] = array_field(size=9)
    angular_velocity: Vector3 = field(default_factory=Vector3)
    angular_velocity_covariance: npt.NDArray[np.float64] = array_field(size=9)
    linear_acceleration: Vector3 = field(default_factory=Vector3)
    linear_acceleration_covariance: npt.NDArray[np.float64] = array_field(size=9)


@message("sensor_msgs/msg/RegionOfInterest")
class RegionOfInterest:
    """A region of an image; all 0 for the whole image."""

    x_offset: int = 0
    y_offset: int = 0
    height: int = 0
    width: int = 0
    do_rectify: bool = False


@message("sensor_msgs/msg/CameraInfo")
class CameraInfo:
    """The optics of a camera: ``k`` projects from its frame (z ahead, x right, y down) to pixels.

    ``k`` and ``r`` are 3x3, ``p`` is 3x4, row by row.
    """

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    distortion_model: str = "plumb_bob"
    d: npt.NDArray[np.float64] = array_field()
    k: npt.NDArray[np.float64] = array_field(size=9)
    r: npt.NDArray[np.float64] = array_field(size=9)
    p: npt.NDArray[np.float64] = array_field(size=12)
    binning_x: int = 0
    binning_y: int = 0
    roi: RegionOfInterest = field(default_factory=RegionOfInterest)
