"""ROS packages dvs_msgs and event_camera_msgs: the events of cameras that see changes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from nrp_core.world.messages.base import Time, message
from nrp_core.world.messages.std_msgs import Header


@message("dvs_msgs/msg/Event", "uint16 x\nuint16 y\nbuiltin_interfaces/Time ts\nbool polarity")
@dataclass(slots=True)
class Event:
    """A change of the brightness of one pixel; its polarity is true for brighter."""

    x: int = 0
    y: int = 0
    ts: Time = field(default_factory=Time)
    polarity: bool = False


@message(
    "dvs_msgs/msg/EventArray", "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] events"
)
@dataclass(slots=True)
class EventArray:
    """Events in the order of their times."""

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    events: list[Event] = field(default_factory=list)


def _no_bytes() -> npt.NDArray[np.uint8]:
    return np.empty(0, np.uint8)


_PACKET = """std_msgs/Header header
uint32 height
uint32 width
uint64 seq
uint64 time_base
string encoding
bool is_bigendian
uint8[] events"""


@message("event_camera_msgs/msg/EventPacket", _PACKET)
@dataclass(slots=True)
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
    events: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)
