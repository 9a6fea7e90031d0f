"""ROS package builtin_interfaces: times and durations."""

from __future__ import annotations

from nrp_core.messages.base import Duration, Time

__all__ = ["Duration", "Time"]
