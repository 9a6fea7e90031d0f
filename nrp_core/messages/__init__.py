"""ROS message types without ROS: the ROS names and fields as plain dataclasses.

Their constructors work as in ROS 1 (no arguments, positional, keywords, ints for floats); arrays are NumPy
arrays. Inside experiment files ``import geometry_msgs.msg`` finds them, see
:mod:`nrp_core.dsl.loading`. Any dataclass can be a message type: :func:`message` names it. To add one, write
it in the module of its package, and its stub with ``scripts/generate_stubs.py``.
"""

from __future__ import annotations

from nrp_core.messages.base import TIME_ZERO, Time, message, type_name, type_of

__all__ = ["TIME_ZERO", "Time", "message", "type_name", "type_of"]
