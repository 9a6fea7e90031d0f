"""A row of a diagram: a transfer function, its devices and its topics."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

CODE_WIDTH = 76
"""The number of characters of code that fit into a line."""


def wrapped(code: str) -> list[str]:
    """Return a line of code as lines that fit."""
    return textwrap.wrap(code, CODE_WIDTH, subsequent_indent="    ")


@dataclass(frozen=True, slots=True)
class Device:
    """A device as it is shown.

    Args:
        name: the function's parameter for the device.
        kind: the device type, as transfer functions name it.
        neurons: the selected neurons, as source text.
        population: the names of the populations of these neurons.
        is_written: whether the function drives the device; otherwise it reads it.
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
        name: the name of the topic.
        type: the message type, ``geometry_msgs/Twist``; empty if only the world knows it.
        is_written: whether the function publishes on it; otherwise it subscribes.
    """

    name: str
    type: str
    is_written: bool


@dataclass(frozen=True, slots=True)
class Row:
    """A transfer function, or a piece of Python with any number of them.

    Args:
        title: the heading of the card.
        lines: the function's actions, one a line.
        devices, topics: its connections.
    """

    title: str
    lines: Sequence[str]
    devices: Sequence[Device] = ()
    topics: Sequence[Topic] = ()
