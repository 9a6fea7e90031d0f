"""ROS package std_msgs."""

from __future__ import annotations

from dataclasses import dataclass, field

from nrp_core.world.messages.base import Time, message


@message("std_msgs/msg/Header")
@dataclass(slots=True)
class Header:
    """Stamp and frame of a measurement."""

    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@message("std_msgs/msg/Bool")
@dataclass(slots=True)
class Bool:
    """A truth value."""

    data: bool = False


@message("std_msgs/msg/String")
@dataclass(slots=True)
class String:
    """A text."""

    data: str = ""


@message("std_msgs/msg/Int32")
@dataclass(slots=True)
class Int32:
    """An integer."""

    data: int = 0


@message("std_msgs/msg/Float32")
@dataclass(slots=True)
class Float32:
    """A number."""

    data: float = 0.0


@message("std_msgs/msg/Float64")
@dataclass(slots=True)
class Float64:
    """A number."""

    data: float = 0.0


@message("std_msgs/msg/ColorRGBA")
@dataclass(slots=True)
class ColorRGBA:
    """A colour, each channel 0..1."""

    r: float = 0.0
    g: float = 0.0
    b: float = 0.0
    a: float = 1.0
