"""Trajectories that are the goals of actions: the joints that they name follow them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrp_core.clock import NS_PER_S
from nrp_core.errors import NrpError
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.scene.model import Model
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.modules import OpenMessage
from nrp_legacy.shims.times import Duration


def is_trajectory(kind: Any) -> bool:
    """Whether the goals of a type of action are trajectories of joints."""
    return "JointTrajectory" in getattr(kind, "__name__", "")


class Movement:
    """Moves joints from where they are through the points of a trajectory, in simulated time.

    Args:
        graph: of the run.
        action: its name, which decides between models that have joints of the same name.
        goal: has the trajectory.
        done: called when the movement is over.

    Attributes:
        is_over: whether the last point was reached, or the movement has ended early.
        has_succeeded: whether the last point was reached.
    """

    def __init__(self, graph: Graph, action: str, goal: Any, done: Callable[[], Any] | None = None) -> None:
        self._graph, self._action, self._done, trajectory = graph, action, done, goal.trajectory
        names = [str(name).rpartition("::")[2] for name in trajectory.joint_names]
        points = [point for point in trajectory.points if len(point.positions) == len(names)]
        owners = {name: _owner(graph, action, name) for name in names}
        self._columns = [(owner, i) for i, name in enumerate(names) if (owner := owners[name]) is not None]
        self._names = names
        missing = [name for name, owner in owners.items() if owner is None]
        if missing:
            graph.warn(f"the action '{action}' moves joints that no model has: {', '.join(missing)}")
        if not points:
            graph.warn(f"a goal of the action '{action}' has no points with a position for each joint")
        self.is_over = not points or not self._columns
        self.has_succeeded = False
        if self.is_over:
            return
        self._begin_ns = max(graph.now_ns, _ns(getattr(trajectory.header, "stamp", 0)))
        self._first_ns = graph.now_ns
        here = [0.0 if (o := owners[name]) is None else _position(graph, o, name) for name in names]
        self._times_ns = np.array([0, *(_ns(point.time_from_start) for point in points)])
        self._positions = np.array([here, *(list(map(float, point.positions)) for point in points)])
        graph.attend(self)

    def deliver(self, graph: Graph) -> None:
        """Move the joints to where they are to be now."""
        if graph.now_ns < self._first_ns:  # the run has begun anew
            self.drop()
            return
        elapsed_ns = graph.now_ns - self._begin_ns
        for model, i in self._columns:
            position = float(np.interp(elapsed_ns, self._times_ns, self._positions[:, i]))
            try:
                self._move(model, self._names[i], position)
            except NrpError as error:
                graph.warn(f"the action '{self._action}' is aborted: {error}")
                self.stop()
                return
        if elapsed_ns >= self._times_ns[-1]:
            self.has_succeeded = True
            self.stop()

    def stop(self) -> None:
        """Move no further, and tell so."""
        self.drop()
        if self._done is not None:
            try:
                self._done()
            except Exception as error:  # noqa: BLE001 - a callback of a user may raise anything
                self._graph.warn(f"a callback of an action raised {type(error).__name__}: {error}")

    def drop(self) -> None:
        """Move no further."""
        self.is_over = True
        self._graph.forget(self)

    def _move(self, model: Model, joint: str, position: float) -> None:
        """Command a joint's controller; what has none is put where it is to be."""
        for controller in model.controllers:
            if (controller.joint, controller.kind) == (joint, "position"):
                self._graph.publish(controller.topic, Float64, Float64(position))
                return
        self._graph.world.set_joints(model.name, {joint: position})


def _owner(graph: Graph, action: str, joint: str) -> Model | None:
    """Return the model that has a joint that moves; of several, the one that the action names."""
    models = graph.world.scene.models
    owners = [model for model in models if any(j.name == joint and j.kind != "fixed" for j in model.joints)]
    return min(owners, key=lambda model: f"/{model.name}/" not in action, default=None)


def _position(graph: Graph, model: Model, joint: str) -> float:
    joints = graph.world.joint_states(model.name)
    return float(joints.positions[joints.names.index(joint)])


def _ns(value: Any) -> int:
    """Return a time or a duration, which may be one of ROS 1, a message, one without a value, or seconds."""
    if isinstance(value, OpenMessage):
        value = vars(value)
        return _ns(Duration(value.get("secs", 0), value.get("nsecs", 0)))
    if isinstance(value, Duration):
        return value.ns
    if hasattr(value, "nanosec"):
        return int(value.sec) * NS_PER_S + int(value.nanosec)
    return round(float(value) * NS_PER_S)
