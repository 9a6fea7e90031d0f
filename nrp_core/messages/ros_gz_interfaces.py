"""ROS package ros_gz_interfaces: messages of gz-sim's sensors."""

from __future__ import annotations

from dataclasses import field

from nrp_core.messages.base import message
from nrp_core.messages.std_msgs import Header


@message("ros_gz_interfaces/msg/Altimeter")
class Altimeter:
    """Height (m) above a reference, vertical velocity (m/s), and the height of the reference in the world."""

    header: Header = field(default_factory=Header)
    vertical_position: float = 0.0
    vertical_velocity: float = 0.0
    vertical_reference: float = 0.0
