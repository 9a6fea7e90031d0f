"""What stands side by side in a diagram: a transfer function, its devices and its topics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Device:
    """A device as it is shown.

    Args:
        name: the parameter that stands for it.
        kind: what transfer functions call it.
        neurons: what it is on, as it is written.
        population: the names of the populations that these are of.
        is_written: whether the function drives it; else it reads it.
    """

    name: str
    kind: str
    neurons: str
    population: str
    is_written: bool


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic as it is shown.

    Args:
        name: of the topic.
        type: of its messages, ``geometry_msgs/Twist``; empty where only the world knows.
        is_written: whether the function publishes on it; else it subscribes.
    """

    name: str
    type: str
    is_written: bool


@dataclass(frozen=True, slots=True)
class Row:
    """A transfer function, or a piece of Python with any number of them.

    Args:
        title: what it is called.
        lines: what it does.
        devices, topics: what it is connected to.
    """

    title: str
    lines: Sequence[str]
    devices: Sequence[Device] = ()
    topics: Sequence[Topic] = ()
