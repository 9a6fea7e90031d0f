"""ROS package event_camera_msgs: the events of cameras that see changes, in a compact form."""

from __future__ import annotations

from dataclasses import field

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import array_field, message
from nrp_core.messages.std_msgs import Header

_PACKET = """std_msgs/Header header
uint32 height
uint32 width
uint64 seq
uint64 time_base
string encoding
bool is_bigendian
uint8[] events"""


@message("event_camera_msgs/msg/EventPacket", _PACKET)
class EventPacket:
    """Events in a compact form.

    In the encoding ``mono`` an event is 64 bits: 32 of the time in ns since ``time_base``, 16 of x, 15 of y,
    and 1 of the polarity.
    """

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    seq: int = 0
    time_base: int = 0
    encoding: str = "mono"
    is_bigendian: bool = False
    events: npt.NDArray[np.uint8] = array_field(np.uint8)
