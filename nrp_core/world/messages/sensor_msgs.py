"""ROS package sensor_msgs; SI units."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from nrp_core.world.messages.base import message
from nrp_core.world.messages.std_msgs import Header


def _no_bytes() -> npt.NDArray[np.uint8]:
    return np.empty(0, np.uint8)


@message("sensor_msgs/msg/Image")
@dataclass(slots=True)
class Image:
    """A picture, rows from top to bottom.

    ``data`` is read-only, of shape ``(height, width, channels)`` where the simulator made it; any
    buffer with ``height * step`` bytes is taken.
    """

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    encoding: str = "rgb8"
    is_bigendian: int = 0
    step: int = 0
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)


@message("sensor_msgs/msg/CompressedImage")
@dataclass(slots=True)
class CompressedImage:
    """A picture as the bytes of an image file; ``format`` names the kind, ``jpeg`` or ``png``."""

    header: Header = field(default_factory=Header)
    format: str = ""
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)


def _no_floats() -> npt.NDArray[np.float64]:
    return np.empty(0)


@message("sensor_msgs/msg/JointState")
@dataclass(slots=True)
class JointState:
    """Positions (rad, m), velocities and efforts of named joints."""

    header: Header = field(default_factory=Header)
    name: list[str] = field(default_factory=list)
    position: npt.NDArray[np.float64] = field(default_factory=_no_floats)
    velocity: npt.NDArray[np.float64] = field(default_factory=_no_floats)
    effort: npt.NDArray[np.float64] = field(default_factory=_no_floats)
