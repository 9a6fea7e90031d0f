"""Services of ``controller_manager`` and of ``simulation_interfaces`` in ROS 2."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from queue import Empty, Queue
from typing import Any
from urllib.parse import urlparse

from nrp_core.errors import NrpError
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose, Quaternion, Twist, Vector3
from nrp_core.world import Model, World

from nrp_world_ros.ros2.actions import GRIPPER, Publish, actions_of
from nrp_world_ros.ros2.node import Ros2Node

SIMULATOR = "/nrp_body/"
"""The services of the simulator are below the name of the node."""


@dataclass(frozen=True, slots=True)
class _Request:
    """A call that waits for the world."""

    answer: Callable[[Any, Any], None]
    request: Any
    response: Any
    coming: Future[Any] = field(default_factory=Future)


class Standard:
    """Offers actions and services to controllers; they act between two steps.

    Args:
        world: the world.
        node: in ROS.
        publish: publishes a message in the world.
    """

    def __init__(self, world: World, node: Ros2Node, publish: Publish) -> None:
        self._world, self._node = world, node
        self._waiting: Queue[_Request] = Queue()
        self._goals = list(actions_of(world, node, publish))
        for model in world.scene.models:
            if listed := list(_controllers(model)):
                place = f"/{model.name}/controller_manager/"
                kind = "controller_manager_msgs/srv/"
                self._offer(place, kind, "ListControllers", partial(self._list, listed))
                self._offer(place, kind, "SwitchController", partial(_switch, {name for name, *_ in listed}))
        for answer in (
            self._get_simulator_features, self._get_simulation_state, self._set_simulation_state,
            self._reset_simulation, self._get_entities, self._get_entity_state, self._set_entity_state,
            self._spawn_entity, self._delete_entity,
        ):  # fmt: skip
            short = answer.__name__.title().replace("_", "")
            self._offer(SIMULATOR, "simulation_interfaces/srv/", short, answer)

    def _offer(self, place: str, package: str, short: str, answer: Callable[[Any, Any], None]) -> None:
        name = place + re.sub(r"(?<!^)([A-Z])", r"_\1", short).lower()

        def ask(request: Any, response: Any) -> Future[Any]:
            call = _Request(answer, request, response)
            self._waiting.put(call)
            return call.coming

        self._node.offer(name, package + short, ask)

    def step(self) -> None:
        """Answer waiting calls and follow goals."""
        while True:
            try:
                call = self._waiting.get_nowait()
            except Empty:
                break
            if call.coming.set_running_or_notify_cancel():
                try:
                    call.answer(call.request, call.response)
                except NrpError as error:
                    _refuse(call.response, 4, str(error))
                call.coming.set_result(call.response)
        for goals in self._goals:
            goals.step()

    # -- controllers

    def _list(self, listed: list[tuple[str, str, list[str]]], _request: Any, response: Any) -> None:
        kind = self._node.types.named("controller_manager_msgs/msg/ControllerState")
        response.controller = [
            kind(name=name, state="active", type=type_, claimed_interfaces=claimed,
                 required_command_interfaces=claimed)
            for name, type_, claimed in listed
        ]  # fmt: skip

    # -- the simulator, by simulation_interfaces

    def _get_simulator_features(self, _request: Any, response: Any) -> None:
        known = type(response.features)
        names = (
            "SPAWNING DELETING SPAWNING_RESOURCE_STRING ENTITY_STATE_GETTING ENTITY_STATE_SETTING "
            "SIMULATION_RESET SIMULATION_RESET_STATE SIMULATION_STATE_GETTING "
            "SIMULATION_STATE_SETTING SIMULATION_STATE_PAUSE"
        )
        response.features.features.extend(getattr(known, name) for name in names.split())
        response.features.spawn_formats = ["sdf", "urdf"]

    def _get_simulation_state(self, _request: Any, response: Any) -> None:
        response.state.state = 2 if self._world.paused else 1
        response.result.result = 1

    def _set_simulation_state(self, request: Any, response: Any) -> None:
        wanted = request.state.state
        if wanted not in (1, 2):
            return _refuse(response, 0, "the world can only be paused and continued")
        if (wanted == 2) == self._world.paused:
            return _refuse(response, response.ALREADY_IN_TARGET_STATE, "")
        self._world.call("/gazebo/pause_physics" if wanted == 2 else "/gazebo/unpause_physics")
        response.result.result = 1
        return None

    def _reset_simulation(self, request: Any, response: Any) -> None:
        if request.scope not in (request.SCOPE_DEFAULT, request.SCOPE_STATE):
            return _refuse(response, 0, "only the state of the models can be reset")
        self._world.call("/gazebo/reset_world")
        response.result.result = 1
        return None

    def _get_entities(self, request: Any, response: Any) -> None:
        names = [model.name for model in self._world.scene.models]
        if request.filters.categories or request.filters.tags.tags or request.filters.bounds.type:
            return _refuse(response, 0, "entities can be chosen by their names only")
        try:
            response.entities = [name for name in names if re.search(request.filters.filter, name)]
        except re.error as error:
            return _refuse(response, 4, f"the filter is not a regular expression: {error}")
        response.result.result = 1
        return None

    def _get_entity_state(self, request: Any, response: Any) -> None:
        if self._has(request.entity, response):
            motion, state = self._world.model_motion(request.entity), response.state
            _fill(state.pose.position, motion.pose.position)
            _fill(state.pose.orientation, motion.pose.orientation)
            _fill(state.twist.linear, motion.linear)
            _fill(state.twist.angular, motion.angular)
            state.header.frame_id = "world"
            state.header.stamp.sec, state.header.stamp.nanosec = divmod(self._world.now_ns, 10**9)

    def _set_entity_state(self, request: Any, response: Any) -> None:
        if not self._has(request.entity, response):
            return None
        if request.set_acceleration or request.state.header.frame_id not in ("", "world"):
            return _refuse(response, 0, "only poses and velocities in the frame 'world' can be set")
        motion, given = self._world.model_motion(request.entity), request.state
        pose = (
            _pose(given.pose)
            if request.set_pose
            else Pose(Point(*motion.pose.position), Quaternion(*motion.pose.orientation))
        )
        twist = Twist(Vector3(*motion.linear), Vector3(*motion.angular))
        if request.set_twist:
            twist = self._node.ours(given.twist, Twist)
        answer = self._world.call("/gazebo/set_model_state", ModelState(request.entity, pose, twist))
        if not answer.success:
            _refuse(response, response.INVALID_POSE, answer.status_message)
        return None

    def _spawn_entity(self, request: Any, response: Any) -> None:
        resource, names = request.entity_resource, {model.name for model in self._world.scene.models}
        name = request.name
        if name in names:
            if not request.allow_renaming:
                return _refuse(response, response.NAME_NOT_UNIQUE, f"there already is a model '{name}'")
            name = next(each for i in range(1, 10**6) if (each := f"{request.name}_{i}") not in names)
        text = resource.resource_string
        if not text:
            try:
                text = Path(urlparse(resource.uri).path).read_text()
            except (OSError, UnicodeDecodeError) as error:
                return _refuse(response, response.NO_RESOURCE, str(error))
        pose = _pose(request.initial_pose.pose)
        answer = self._world.call(
            "/gazebo/spawn_sdf_entity", name, text, request.entity_namespace, pose, "world"
        )
        if not answer.success:
            return _refuse(response, response.RESOURCE_PARSE_ERROR, answer.status_message)
        response.entity_name, response.result.result = name, 1
        return None

    def _delete_entity(self, request: Any, response: Any) -> None:
        if self._has(request.entity, response):
            answer = self._world.call("/gazebo/delete_model", request.entity)
            if not answer.success:
                _refuse(response, 4, answer.status_message)

    def _has(self, entity: str, response: Any) -> bool:
        """Return whether a model exists, as the result of a response."""
        found = any(model.name == entity for model in self._world.scene.models)
        response.result.result = 1 if found else 2
        response.result.error_message = "" if found else f"there is no model '{entity}'"
        return found


def _refuse(response: Any, code: int, why: str) -> None:
    response.result.result, response.result.error_message = code, why


def _switch(active: set[str], request: Any, response: Any) -> None:
    unknown = {*request.activate_controllers, *request.deactivate_controllers} - active
    if unknown:
        response.message = f"there is no controller {', '.join(sorted(unknown))}"
    elif request.deactivate_controllers:
        response.message = "controllers cannot be deactivated: the last command of a joint decides"
    response.ok = not response.message


def _controllers(model: Model) -> Iterator[tuple[str, str, list[str]]]:
    """Yield name, type and command interfaces of the controllers of a robot."""
    for follower in model.trajectory_controllers:
        claimed = [f"{joint}/position" for joint in follower.joints]
        yield follower.name, "joint_trajectory_controller/JointTrajectoryController", claimed
    for group in model.group_controllers:
        claimed = [f"{joint}/{group.kind}" for joint in group.joints]
        yield group.name, "forward_command_controller/ForwardCommandController", claimed
    for controller in model.controllers:
        if controller.topic.endswith(GRIPPER):
            name = controller.topic.split("/")[-2]
            yield name, "position_controllers/GripperActionController", [f"{controller.joint}/position"]


def _pose(given: Any) -> Pose:
    p, q = given.position, given.orientation
    return Pose(Point(p.x, p.y, p.z), Quaternion(q.x, q.y, q.z, q.w))


def _fill(target: Any, values: Any) -> None:
    for name, value in zip("xyzw", values, strict=False):
        setattr(target, name, float(value))
