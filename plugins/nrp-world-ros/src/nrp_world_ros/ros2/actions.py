"""Actions of ROS 2 for the controllers of joints: trajectories and grippers.

As in ROS, a new goal replaces the one that a controller follows, and a cancelled one stops the joints where
they are. Goals arrive in a thread of ROS and are followed between two steps.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from queue import Empty, Queue
from typing import Any, ClassVar

from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import NrpError
from nrp_core.messages.base import ns_of
from nrp_core.messages.std_msgs import Float64
from nrp_core.messages.trajectory_msgs import JointTrajectory
from nrp_core.world import Model, Subscription, TrajectoryController, World

from nrp_world_ros.ros2.node import Ros2Node

FEEDBACK_NS = NS_PER_S // 20
"""Period of the feedback on a goal."""

GRIPPER = "/gripper_cmd"
"""The end of the name of the action of a gripper, and of the topic of its joint."""

Publish = Callable[[str, Any], None]


class Goals(ABC):
    """The goals of one action.

    Args:
        world: has the controller.
        node: in ROS.
        name: of the action.
        model: the name of the robot.
        publish: publishes a message in the world.
        controller: the controller.
    """

    kind: ClassVar[str]
    """The type of the action."""

    def __init__(
        self, world: World, node: Ros2Node, name: str, model: str, publish: Publish, controller: Any
    ) -> None:
        self._world, self._node, self._model, self._publish = world, node, model, publish
        self._new: Queue[Any] = Queue()
        self._goal: Any = None
        self._told_ns = 0
        self.lead(controller)
        self._server = node.act(name, self.kind, self.may_start, self._new.put)
        self._result = node.types.named(self.kind).Result
        self._feedback = node.types.named(self.kind).Feedback

    def lead(self, controller: Any) -> None:
        """Send goals to this controller, for example that of a robot that was spawned again."""
        self._controller = controller

    @abstractmethod
    def may_start(self, goal: Any) -> bool:
        """Return whether a goal is accepted."""

    @abstractmethod
    def start(self, goal: Any) -> None:
        """Send the commands for a goal to the controller."""

    @abstractmethod
    def outcome(self, goal: Any) -> tuple[bool, Any] | None:
        """Return whether a goal was reached, and its result; None while it is followed."""

    @abstractmethod
    def progress(self) -> Any:
        """Return the feedback on the goal."""

    @abstractmethod
    def stop(self) -> None:
        """Stop the joints where they are."""

    @abstractmethod
    def failed(self, reason: str) -> Any:
        """Return the result of a goal that was refused or replaced."""

    def step(self) -> None:
        """Begin, follow and end goals; called between two steps."""
        for goal in self._arrivals():
            if self._goal is not None:
                self._end("abort", self.failed("another goal has replaced it"))
            self._goal = goal
            self._node.begin(goal)
            try:
                self.start(goal.request)
            except NrpError as error:
                self._end("abort", self.failed(str(error)))
        if self._goal is not None:
            try:
                self._follow()
            except NrpError as error:  # as of a robot that was deleted
                self._end("abort", self.failed(str(error)))

    def _follow(self) -> None:
        if self._goal.is_cancel_requested:
            self.stop()
            self._end("canceled", self.failed("it was cancelled"))
        elif (found := self.outcome(self._goal.request)) is not None:
            self._end("succeed" if found[0] else "abort", found[1])
        elif self._world.now_ns >= self._told_ns + FEEDBACK_NS:
            self._told_ns = self._world.now_ns
            self._goal.publish_feedback(self.progress())

    def _arrivals(self) -> Iterator[Any]:
        while True:
            try:
                yield self._new.get_nowait()
            except Empty:
                return

    def _end(self, event: str, result: Any) -> None:
        goal, self._goal = self._goal, None
        getattr(goal, event)()
        self._server.notify_execute(goal, lambda _goal: result)  # which only answers

    def _state(self, joint: str) -> tuple[float, float]:
        """Return position and velocity of a joint."""
        states = self._world.joint_states(self._model)
        row = states.names.index(joint)
        return float(states.positions[row]), float(states.velocities[row])


class TrajectoryGoals(Goals):
    """Trajectories (``control_msgs/FollowJointTrajectory``) with tolerances on the path and at the goal.

    A tolerance of 0 is not checked. The joints may take any time to reach the goal, unless
    ``goal_time_tolerance`` limits it.
    """

    kind = "control_msgs/action/FollowJointTrajectory"

    _end_ns = 0
    _states: Subscription | None = None

    def lead(self, controller: TrajectoryController) -> None:
        super().lead(controller)
        if self._states is not None:
            self._world.unsubscribe(self._states)
        topic = controller.state_topic
        self._states = None if topic is None else self._world.subscribe(topic)

    def may_start(self, goal: Any) -> bool:
        names = list(goal.trajectory.joint_names)
        measured = self._states is not None or not goal.path_tolerance
        points = goal.trajectory.points
        whole = bool(points) and all(len(point.positions) == len(names) for point in points)
        return whole and set(names) <= set(self._controller.joints) and measured

    def start(self, goal: Any) -> None:
        trajectory: JointTrajectory = self._node.ours(goal.trajectory, JointTrajectory)
        self._publish(self._controller.command_topic, trajectory)
        begin_ns = ns_of(trajectory.header.stamp) or self._world.now_ns
        self._end_ns = begin_ns + ns_of(trajectory.points[-1].time_from_start)
        self._told_ns = self._world.now_ns

    def outcome(self, goal: Any) -> tuple[bool, Any] | None:
        if self._world.now_ns < self._end_ns:
            message = self._controlled()
            errors = dict(zip(message.joint_names, message.error.positions, strict=True)) if message else {}
            return self._violated(goal.path_tolerance, errors, self._result.PATH_TOLERANCE_VIOLATED)
        last = goal.trajectory.points[-1].positions
        aims = dict(zip(goal.trajectory.joint_names, last, strict=True))
        errors = {joint: aim - self._state(joint)[0] for joint, aim in aims.items()}
        violated = self._violated(goal.goal_tolerance, errors, self._result.GOAL_TOLERANCE_VIOLATED)
        if violated is None:
            return True, self._result()
        limit_ns = goal.goal_time_tolerance.sec * NS_PER_S + goal.goal_time_tolerance.nanosec
        return violated if limit_ns and self._world.now_ns > self._end_ns + limit_ns else None

    def _controlled(self) -> Any:
        """Return the last state of the controller, if it reports any."""
        latest = None if self._states is None else self._states.latest
        return None if latest is None else latest.message

    def _violated(self, limits: Any, errors: Mapping[str, float], code: int) -> tuple[bool, Any] | None:
        for limit in limits:
            error = abs(errors.get(limit.name, 0.0))
            if 0.0 < limit.position < error:
                text = f"joint '{limit.name}' is {error:.4g} off, above {limit.position:g}"
                return False, self._result(error_code=code, error_string=text)
        return None

    def progress(self) -> Any:
        feedback = self._feedback(joint_names=list(self._controller.joints))
        for joint in self._controller.joints:
            position, velocity = self._state(joint)
            feedback.actual.positions.append(position)
            feedback.actual.velocities.append(velocity)
        if (told := self._controlled()) is not None:
            feedback.desired.positions.extend(told.desired.positions)
            feedback.error.positions.extend(told.error.positions)
        feedback.header.stamp.sec, feedback.header.stamp.nanosec = divmod(self._world.now_ns, NS_PER_S)
        return feedback

    def stop(self) -> None:
        self._publish(self._controller.command_topic, JointTrajectory())

    def failed(self, reason: str) -> Any:
        return self._result(error_code=self._result.INVALID_GOAL, error_string=reason)


class GripperGoals(Goals):
    """Positions of a gripper (``control_msgs/GripperCommand``); its limit of effort has no effect.

    As by default in ROS, it has reached its goal within 0.01 m or rad, and is stalled when it is slower than
    0.001 m/s or rad/s for a second; then the goal is aborted.
    """

    kind = "control_msgs/action/GripperCommand"
    TOLERANCE, SLOW, STALLED_S = 0.01, 0.001, 1.0
    _moved_ns = 0

    def may_start(self, goal: Any) -> bool:
        return bool(abs(goal.command.position) < float("inf"))

    def start(self, goal: Any) -> None:
        self._publish(self._controller.topic, Float64(goal.command.position))
        self._moved_ns = self._told_ns = self._world.now_ns

    def outcome(self, goal: Any) -> tuple[bool, Any] | None:
        position, velocity = self._state(self._controller.joint)
        if abs(velocity) > self.SLOW:
            self._moved_ns = self._world.now_ns
        reached = abs(position - goal.command.position) < self.TOLERANCE
        stalled = seconds(self._world.now_ns - self._moved_ns) > self.STALLED_S
        if not (reached or stalled):
            return None
        return reached, self._result(position=position, stalled=not reached, reached_goal=reached)

    def progress(self) -> Any:
        return self._feedback(position=self._state(self._controller.joint)[0])

    def stop(self) -> None:
        self._publish(self._controller.topic, Float64(self._state(self._controller.joint)[0]))

    def failed(self, reason: str) -> Any:
        try:
            return self._result(position=self._state(self._controller.joint)[0])
        except NrpError:  # the robot was deleted
            return self._result()


def controllers_of(model: Model) -> Iterator[tuple[str, type[Goals], Any]]:
    """Yield the actions of a robot: their names, their classes, and the controllers."""
    for follower in model.trajectory_controllers:
        name = f"{follower.command_topic.rpartition('/')[0]}/follow_joint_trajectory"
        yield name, TrajectoryGoals, follower
    for controller in model.controllers:
        if controller.topic.endswith(GRIPPER):
            yield controller.topic, GripperGoals, controller
