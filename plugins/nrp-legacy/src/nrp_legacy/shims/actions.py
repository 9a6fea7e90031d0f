"""``actionlib`` and ``dynamic_reconfigure``: only actions with joint trajectories have a server."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import isfinite
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core.clock import from_seconds
from nrp_core.errors import NrpError, TopicError
from nrp_core.findings import Code
from nrp_core.messages.base import ns_of
from nrp_core.messages.std_msgs import Float64
from nrp_core.messages.trajectory_msgs import JointTrajectoryPoint
from nrp_core.world import Model
from nrp_core.world.controllers.trajectory import JointPath, Knot, knots_of
from nrp_legacy.shims.graph import Graph, absolute
from nrp_legacy.shims.modules import OpenMessage, bound, module
from nrp_legacy.shims.smach import State
from nrp_legacy.shims.steps import Task
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
                    Code.NRP280, f"a callback of an action raised {type(error).__name__}: {error}"
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
    return ns_of(value) if hasattr(value, "nanosec") else from_seconds(float(value))


_STATES = {
    "PENDING": 0, "ACTIVE": 1, "PREEMPTED": 2, "SUCCEEDED": 3, "ABORTED": 4, "REJECTED": 5, "PREEMPTING": 6,
    "RECALLING": 7, "RECALLED": 8, "LOST": 9,
}  # fmt: skip
_OUTCOMES = {
    _STATES["SUCCEEDED"]: "succeeded",
    _STATES["ABORTED"]: "aborted",
    _STATES["PREEMPTED"]: "preempted",
}


class SimpleActionClient:
    """Moves joints along trajectories; other goals do not have a server and are lost.

    Args:
        graph: the graph of the run.
        name: the name of the action.
        kind: its type.
    """

    def __init__(self, graph: Graph, name: str, kind: Any = None, *_values: Any, **options: Any) -> None:
        self._graph, self._name = graph, absolute(name)
        self._is_served = is_trajectory(options.get("ActionSpec", kind))
        self._movement: Movement | None = None
        self._is_cancelled = False
        if not self._is_served:
            graph.warn(
                Code.NRP212, f"the action '{self._name}' does not have a server: its goals are ignored"
            )

    def wait_for_server(self, *_values: Any, **_options: Any) -> bool:
        """Return whether the world accepts goals."""
        return self._is_served and self._graph.has_begun

    def send_goal(
        self, goal: Any, done_cb: Any = None, active_cb: Any = None, *_values: Any, **_options: Any
    ) -> None:
        """Start a goal, which replaces the previous one."""
        if self._movement is not None:
            self._movement.drop()
        self._movement, self._is_cancelled = None, False
        if not self.wait_for_server():
            return
        done = None if done_cb is None else lambda: done_cb(self.get_state(), self.get_result())
        self._movement = Movement(self._graph, self._name, goal, done)
        if active_cb is not None and not self._movement.is_over:
            active_cb()

    def send_goal_and_wait(self, goal: Any, *values: Any, **options: Any) -> int:
        """Send a goal and return its final state."""
        self.send_goal(goal)
        if not self.wait_for_result(*values[:1], **options) and Task.here() is not None:
            self.cancel_goal()
        return self.get_state()

    def wait_for_result(self, timeout: Any = None, **options: Any) -> bool:
        """Wait in simulated time and return whether the goal is done; transfer functions do not wait."""
        limit_s = float(options.get("execute_timeout", timeout) or 0.0)
        end_ns = self._graph.now_ns + from_seconds(limit_s) if isfinite(limit_s) and limit_s else None
        task = Task.here()
        while task is not None and self._moves and (end_ns is None or self._graph.now_ns < end_ns):
            task.wait_until(0)
        return self._movement is not None and self._movement.is_over

    def get_state(self) -> int:
        """Return the state of the goal."""
        if self._moves:
            return _STATES["ACTIVE"]
        if self._movement is None:
            return _STATES["LOST"]
        if self._movement.has_succeeded:
            return _STATES["SUCCEEDED"]
        return _STATES["PREEMPTED" if self._is_cancelled else "ABORTED"]

    def get_result(self) -> OpenMessage | None:
        """Return the result, None before there is one."""
        if self._movement is None or self._moves:
            return None
        return OpenMessage(error_code=0 if self._movement.has_succeeded else -1, error_string="")

    def cancel_goal(self, *_values: Any) -> None:
        """Cancel a goal."""
        if self._movement is not None and self._moves:
            self._is_cancelled = True
            self._movement.stop()

    cancel_all_goals = cancel_goal

    def stop_tracking_goal(self) -> None:
        """Stop tracking a goal, which continues."""
        self._movement = None

    def get_goal_status_text(self) -> str:
        """Return the status of the goal."""
        return "there is no server" if self._movement is None else ""

    @property
    def _moves(self) -> bool:
        return self._movement is not None and not self._movement.is_over


class SimpleActionServer:
    """A server without clients."""

    def __init__(self, *_values: Any, **_options: Any) -> None:
        """Do nothing."""

    def start(self, *_values: Any) -> None:
        """Do nothing."""

    set_succeeded = set_aborted = set_preempted = publish_feedback = accept_new_goal = start
    register_goal_callback = register_preempt_callback = start

    def is_preempt_requested(self) -> bool:
        """Return False, because goals do not exist here."""
        return False

    is_active = is_new_goal_available = is_preempt_requested


class SimpleActionState(State):
    """A state that sends a goal and waits for its end.

    Args:
        graph: the graph of the run.
        name: the name of the action.
        kind: its type.
        goal: the goal; or ``goal_cb`` makes it from the user data and an empty goal, or ``goal_key`` is its
            key in the user data.
        result_cb: called with the user data, the status and the result; it may return an outcome.
        outcomes: those of ``result_cb``.
    """

    def __init__(
        self,
        graph: Graph,
        name: str,
        kind: Any = None,
        goal: Any = None,
        goal_key: str | None = None,
        goal_cb: Callable[..., Any] | None = None,
        result_cb: Callable[..., Any] | None = None,
        outcomes: Iterable[str] = (),
        **_more: Any,
    ) -> None:
        super().__init__((*_OUTCOMES.values(), *outcomes))
        self._graph, self._name, self._kind = graph, name, kind
        self._goal, self._goal_key, self._goal_cb, self._result_cb = goal, goal_key, goal_cb, result_cb

    def execute(self, userdata: Any) -> str:
        client = SimpleActionClient(self._graph, self._name, self._kind)
        status = client.send_goal_and_wait(self._made(userdata))
        outcome = None
        if self._result_cb is not None and client.get_result() is not None:
            outcome = self._result_cb(userdata, status, client.get_result())
        return outcome or _OUTCOMES.get(status, "aborted")

    def _made(self, userdata: Any) -> Any:
        if self._goal_key is not None:
            return userdata[self._goal_key]
        goal = OpenMessage() if self._goal is None else self._goal
        return goal if self._goal_cb is None else self._goal_cb(userdata, goal) or goal


class SettingsClient:
    """Stores settings, which have no effect."""

    def __init__(self, *_values: Any, **_options: Any) -> None:
        self._settings: dict[str, Any] = {}

    def update_configuration(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Store settings."""
        self._settings |= changes
        return self._settings

    def get_configuration(self, *_values: Any, **_options: Any) -> dict[str, Any]:
        """Return the stored settings."""
        return self._settings


def action_modules(graph: Graph) -> dict[str, ModuleType]:
    """Return the modules for one experiment."""
    return {
        "actionlib": module(
            "actionlib",
            SimpleActionClient=bound(SimpleActionClient, graph),
            SimpleActionServer=SimpleActionServer,
            GoalStatus=module("GoalStatus", **_STATES),
            SimpleGoalState=module("SimpleGoalState", PENDING=0, ACTIVE=1, DONE=2),
        ),
        "dynamic_reconfigure.client": module("dynamic_reconfigure.client", Client=SettingsClient),
    }
