"""Report that no other node of ROS has found this one, which is otherwise silent about it."""

from __future__ import annotations

import time
from collections.abc import Callable

from nrp_world_ros.node import Node

_PATIENCE_S = 5.0
"""Time in which nodes that run already have found this one, s."""


class Audience:
    """Waits for a first subscriber or publisher in ROS.

    Args:
        node: in ROS.
        tell: is given the report, once.
    """

    def __init__(self, node: Node, tell: Callable[[str], None]) -> None:
        self._node, self._tell = node, tell
        self._until_s: float | None = time.monotonic() + _PATIENCE_S

    def look(self) -> None:
        """Report when the time is over; calling it often is cheap."""
        if self._until_s is None:
            return
        if self._node.met():
            self._until_s = None
        elif time.monotonic() > self._until_s:
            self._until_s = None
            self._tell(f"no other node listens or publishes here after {_PATIENCE_S:g} s; {self._node.reach}")
