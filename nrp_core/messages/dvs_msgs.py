"""ROS package dvs_msgs: the events of cameras that see changes."""

from __future__ import annotations

from dataclasses import field

from nrp_core.messages.base import Time, message
from nrp_core.messages.std_msgs import Header


@message("dvs_msgs/msg/Event", "uint16 x\nuint16 y\nbuiltin_interfaces/Time ts\nbool polarity")
class Event:
    """A change of the brightness of one pixel; its polarity is true for brighter."""

    x: int = 0
    y: int = 0
    ts: Time = field(default_factory=Time)
    polarity: bool = False


@message(
    "dvs_msgs/msg/EventArray", "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] events"
)
class EventArray:
    """Events in the order of their times."""

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    events: list[Event] = field(default_factory=list)
