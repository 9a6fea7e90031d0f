"""Trajectories that are the goals of actions: the joints that they name follow them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nrp_core.clock import NS_PER_S
from nrp_core.errors import NrpError, TopicError
from nrp_core.findings import Code
from nrp_core.world.controllers.trajectory import JointPath, Knot, knots_of
from nrp_core.world.messages.base import ns_of
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.messages.trajectory_msgs import JointTrajectoryPoint
from nrp_core.world.scene.model import Model
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.modules import OpenMessage
from nrp_legacy.shims.times import Duration


def is_trajectory(kind: Any) -> bool:
    """Return whether the goals of a type of action are trajectories of joints."""
    return "JointTrajectory" in getattr(kind, "__name__", "")


class Movement:
    """Moves joints from where they are through the points of a trajectory, in simulated time.

    Args:
        graph: the graph of the run.
        action: its name, which decides between models that have joints of the same name.
        goal: the goal with the trajectory.
        done: called when the movement is over.

    Attributes:
        is_over: whether the last point was reached, or the movement has ended early.
        has_succeeded: whether the last point was reached.
    """

    def __init__(self, graph: Graph, action: str, goal: Any, done: Callable[[], Any] | None = None) -> None:
        self._graph, self._action, self._done, trajectory = graph, action, done, goal.trajectory
        names = [str(name).rpartition("::")[2] for name in trajectory.joint_names]
        points = [point for point in trajectory.points if len(point.positions) == len(names)]
        owners = {name: owner for name in names if (owner := _owner(graph, action, name)) is not None}
        missing = [name for name in names if name not in owners]
        if missing:
            graph.warn(
                Code.NRP280, f"the action '{action}' moves joints that do not exist: {', '.join(missing)}"
            )
        if not points:
            graph.warn(
                Code.NRP280,
                f"a goal of the action '{action}' does not have points with one position per joint",
            )
        self.is_over = not points or not owners
        self.has_succeeded = False
        if self.is_over:
            return
        self._first_ns = graph.now_ns
        self._paths: list[tuple[Model, str, JointPath]] = []
        begin_ns = max(graph.now_ns, _ns(getattr(trajectory.header, "stamp", 0)))
        try:
            rows = knots_of(list(map(_point, points)), len(names), begin_ns, f"the action '{action}'")
        except TopicError as error:
            graph.warn(Code.NRP280, error.message)
            self.is_over = True
            return
        for number, name in enumerate(names):
            if name in owners:
                here = Knot(begin_ns, _position(graph, owners[name], name), 0.0, 0.0)
                ahead = [row[number] for row in rows if row[number].t_ns > begin_ns]
                path = JointPath((here, *ahead) if ahead else (rows[-1][number],))
                self._paths.append((owners[name], name, path))
        graph.attend(self)

    def deliver(self, graph: Graph) -> None:
        """Move the joints to their present targets."""
        now_ns = graph.now_ns
        if now_ns < self._first_ns:  # the run has been reset
            self.drop()
            return
        for model, joint, path in self._paths:
            knot = path.at(now_ns)
            try:
                if knot is not None:
                    self._move(model, joint, knot.position)
            except NrpError as error:
                graph.warn(Code.NRP280, f"the action '{self._action}' is aborted: {error}")
                self.stop()
                return
        if all(path.is_over(now_ns) for _, _, path in self._paths):
            self.has_succeeded = True
            self.stop()

    def stop(self) -> None:
        """Stop and report it."""
        self.drop()
        if self._done is not None:
            try:
                self._done()
            except Exception as error:  # noqa: BLE001 - a callback of a user may raise anything
                self._graph.warn(
                    Code.NRP281, f"a callback of an action raised {type(error).__name__}: {error}"
                )

    def drop(self) -> None:
        """Stop."""
        self.is_over = True
        self._graph.forget(self)

    def _move(self, model: Model, joint: str, position: float) -> None:
        """Command a joint's controller; a joint without one is set to its position."""
        for controller in model.controllers:
            if (controller.joint, controller.kind) == (joint, "position"):
                self._graph.publish(controller.topic, Float64, Float64(position))
                return
        self._graph.world.set_joints(model.name, {joint: position})


def _owner(graph: Graph, action: str, joint: str) -> Model | None:
    """Return the model with a movable joint; of several, the one that the action names."""
    models = graph.world.scene.models
    owners = [model for model in models if any(joint in j.coordinates for j in model.joints)]
    return min(owners, key=lambda model: f"/{model.name}/" not in action, default=None)


def _position(graph: Graph, model: Model, joint: str) -> float:
    joints = graph.world.joint_states(model.name)
    return float(joints.positions[joints.names.index(joint)])


def _point(point: Any) -> Any:
    """Return a point of a trajectory as a message, with any fields."""
    values_of = {name: getattr(point, name, ()) for name in ("positions", "velocities", "accelerations")}
    after = Duration(0, _ns(point.time_from_start))
    return JointTrajectoryPoint(
        **{name: np.array(list(value), float) for name, value in values_of.items()}, time_from_start=after
    )


def _ns(value: Any) -> int:
    """Return a time or a duration, which may be a message, one without a value, or seconds."""
    if isinstance(value, OpenMessage):
        value = Duration(vars(value).get("secs", 0), vars(value).get("nsecs", 0))
    return ns_of(value) if hasattr(value, "nanosec") else round(float(value) * NS_PER_S)
