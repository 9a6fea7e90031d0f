"""ROS package std_msgs."""

from __future__ import annotations

from dataclasses import field

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import Time, array_field, message


@message("std_msgs/msg/Header")
class Header:
    """Stamp and frame of a measurement."""

    stamp: Time = field(default_factory=Time)
    frame_id: str = ""

    @property
    def seq(self) -> int:
        """The number that ROS 1 gave to each message: always 0."""
        return 0

    @seq.setter
    def seq(self, value: int) -> None:
        """Ignore the value."""


@message("std_msgs/msg/Empty")
class Empty:
    """A message without fields."""


@message("std_msgs/msg/Bool")
class Bool:
    """A truth value."""

    data: bool = False


@message("std_msgs/msg/String")
class String:
    """A text."""

    data: str = ""


@message("std_msgs/msg/Int32")
class Int32:
    """An integer."""

    data: int = 0


@message("std_msgs/msg/Float32")
class Float32:
    """A number."""

    data: float = 0.0


@message("std_msgs/msg/Float64")
class Float64:
    """A number."""

    data: float = 0.0


@message("std_msgs/msg/ColorRGBA")
class ColorRGBA:
    """A colour, each channel 0..1."""

    r: float = 0.0
    g: float = 0.0
    b: float = 0.0
    a: float = 1.0


@message("std_msgs/msg/MultiArrayDimension")
class MultiArrayDimension:
    """Name and extent of one axis of an array; ``stride`` counts the elements from this axis on."""

    label: str = ""
    size: int = 0
    stride: int = 0


@message("std_msgs/msg/MultiArrayLayout")
class MultiArrayLayout:
    """How an array lies in memory, outermost axis first; without axes it is a plain list."""

    dim: list[MultiArrayDimension] = field(default_factory=list)
    data_offset: int = 0


@message("std_msgs/msg/Float64MultiArray")
class Float64MultiArray:
    """Numbers; the layout is empty for a plain list."""

    layout: MultiArrayLayout = field(default_factory=MultiArrayLayout)
    data: npt.NDArray[np.float64] = array_field()
