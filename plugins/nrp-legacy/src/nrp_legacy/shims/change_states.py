"""States that change the scene, and the forms in which their arguments come."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nrp_core.errors import NrpError
from nrp_core.findings import Code
from nrp_core.world.messages.geometry_msgs import Point, Pose, Quaternion
from nrp_core.world.rigid import Pose as ScenePose
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.services import ServiceException
from nrp_legacy.shims.smach import State

OUTCOMES = ("succeeded", "aborted", "preempted")

Change = Callable[[Any], None]


class Given:
    """An argument of a state: a value, or a function of the user data and the value of the last time.

    Args:
        value: the value or function.
    """

    def __init__(self, value: Any) -> None:
        self._value = value
        self._last: Any = None

    def __call__(self, userdata: Any) -> Any:
        """Return the value for this time."""
        if callable(self._value):
            self._last = self._value(userdata, self._last)
            return self._last
        return self._value


class ChangeState(State):
    """Changes the scene once; if this fails, the error is reported and the state is aborted.

    Args:
        graph: the graph of the run.
        change: makes the change, given the user data.
    """

    def __init__(self, graph: Graph, change: Change) -> None:
        super().__init__(OUTCOMES)
        self._graph, self._change = graph, change

    def execute(self, userdata: Any) -> str:
        try:
            self._change(userdata)
        except (NrpError, ServiceException) as error:
            self._graph.warn(Code.NRP280, str(error))
            return "aborted"
        return "succeeded"


def posed(position: Any, rotation: Any) -> Pose:
    """Return a pose; its parts are given in any form, or the whole pose as the position."""
    if isinstance(position, Pose):
        return position
    point = Point(*numbers_of(position)) if position is not None else Point()
    return Pose(point) if rotation is None else Pose(point, _orientation(rotation))


def _orientation(rotation: Any) -> Quaternion:
    """Return a rotation that is given as a quaternion or as three angles, in any form."""
    if isinstance(rotation, Quaternion):
        return rotation
    if isinstance(rotation, Mapping) and "w" in rotation:
        rotation = [rotation[axis] for axis in "xyzw"]
    if isinstance(rotation, Sequence) and len(rotation) == len("xyzw"):
        return Quaternion(*map(float, rotation))
    return Quaternion(*ScenePose.from_rpy((0.0, 0.0, 0.0), *numbers_of(rotation)).orientation)


def numbers_of(value: Any) -> tuple[float, float, float]:
    """Return three numbers that are given as a message, a dictionary or a sequence."""
    if isinstance(value, Mapping):
        value = [value[axis] for axis in "xyz"]
    x, y, z = (value.x, value.y, value.z) if hasattr(value, "x") else value
    return float(x), float(y), float(z)
