"""Services of ``controller_manager`` and of ``simulation_interfaces`` in ROS 2."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse

from nrp_core import world
from nrp_core.errors import NrpError, SceneError
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose, Quaternion, Twist, Vector3
from nrp_core.world import Model, Scene, World, read_model

from nrp_world_ros.ros2.actions import GRIPPER, Goals, Publish, controllers_of
from nrp_world_ros.ros2.node import Ros2Node

Ask = Callable[[str, Callable[[], Any]], Future[Any]]

SIMULATOR = "/nrp_body/"
"""The services of the simulator are below the name of the node."""


class Standard:
    """Offers actions and services to controllers; they act between two steps.

    Args:
        world: the world.
        node: in ROS.
        publish: publishes a message in the world.
        ask: takes the name of a service and a function that returns its response between two steps.
        folders: those whose files may be spawned.
    """

    def __init__(
        self, world: World, node: Ros2Node, publish: Publish, ask: Ask, folders: Collection[Path]
    ) -> None:
        self._world, self._node, self._publish = world, node, publish
        self._ask, self._folders = ask, folders
        self._goals: dict[str, Goals] = {}
        self._managed: set[str] = set()
        self._followed: Scene | None = None
        self._follow()
        for answer in (
            self._get_simulator_features, self._get_simulation_state, self._set_simulation_state,
            self._reset_simulation, self._get_entities, self._get_entity_state, self._set_entity_state,
            self._spawn_entity, self._delete_entity,
        ):  # fmt: skip
            short = answer.__name__.title().replace("_", "")
            self._offer(SIMULATOR, "simulation_interfaces/srv/", short, answer)

    def _offer(self, place: str, package: str, short: str, answer: Callable[[Any, Any], None]) -> None:
        name = place + re.sub(r"(?<!^)([A-Z])", r"_\1", short).lower()

        def answered(request: Any, response: Any) -> Any:
            try:
                answer(request, response)
            except NrpError as error:
                _refuse(response, 4, str(error))
            return response

        self._node.offer(name, package + short, lambda *given: self._ask(name, partial(answered, *given)))

    def _follow(self) -> None:
        """Offer the interfaces of the robots in the current scene, which may have new models."""
        scene, kind = self._world.scene, "controller_manager_msgs/srv/"
        for model in scene.models if scene is not self._followed else ():
            for name, cls, controller in controllers_of(model):
                if name in self._goals:
                    self._goals[name].lead(controller)
                else:
                    given = self._world, self._node, name, model.name, self._publish, controller
                    self._goals[name] = cls(*given)
            if model.name not in self._managed and any(_controllers(model)):
                self._managed.add(model.name)
                for short, answer in (("ListControllers", self._list), ("SwitchController", self._switch)):
                    place = f"/{model.name}/controller_manager/"
                    self._offer(place, kind, short, partial(answer, model.name))
        self._followed = scene

    def step(self) -> None:
        """Follow goals, and add the interfaces of new robots."""
        self._follow()
        for goals in self._goals.values():
            goals.step()

    # -- controllers

    def _controllers(self, robot: str) -> Iterator[tuple[str, str, list[str]]]:
        for model in self._world.scene.models:
            if model.name == robot:
                yield from _controllers(model)

    def _list(self, robot: str, _request: Any, response: Any) -> None:
        kind = self._node.types.named("controller_manager_msgs/msg/ControllerState")
        response.controller = [
            kind(name=name, state="active", type=type_, claimed_interfaces=claimed,
                 required_command_interfaces=claimed)
            for name, type_, claimed in self._controllers(robot)
        ]  # fmt: skip

    def _switch(self, robot: str, request: Any, response: Any) -> None:
        active = {name for name, *_ in self._controllers(robot)}
        unknown = {*request.activate_controllers, *request.deactivate_controllers} - active
        if unknown:
            response.message = f"there is no controller {', '.join(sorted(unknown))}"
        elif request.deactivate_controllers:
            response.message = "controllers cannot be deactivated: a joint follows its last command"
        response.ok = not response.message

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
        except (re.error, OverflowError, RecursionError) as error:
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
        pose = Pose(Point(*motion.pose.position), Quaternion(*motion.pose.orientation))
        twist = Twist(Vector3(*motion.linear), Vector3(*motion.angular))
        if request.set_pose:
            pose = self._node.ours(given.pose, Pose)
        if request.set_twist:
            twist = self._node.ours(given.twist, Twist)
        answer = self._world.call("/gazebo/set_model_state", ModelState(request.entity, pose, twist))
        if not answer.success:
            _refuse(response, response.INVALID_POSE, answer.status_message)
        return None

    def _spawn_entity(self, request: Any, response: Any) -> None:
        resource, names = request.entity_resource, {model.name for model in self._world.scene.models}
        if request.entity_namespace or request.initial_pose.header.frame_id not in ("", "world"):
            return _refuse(response, 0, "only models without a namespace can be added, in the frame 'world'")
        if not request.name and not request.allow_renaming:
            return _refuse(response, response.NAME_INVALID, "a model needs a name")
        name = wanted = request.name or "entity"
        if name in names:
            if not request.allow_renaming:
                return _refuse(response, response.NAME_NOT_UNIQUE, f"there already is a model '{name}'")
            name = next(each for i in range(1, 10**6) if (each := f"{wanted}_{i}") not in names)
        pose = self._node.ours(request.initial_pose.pose, Pose)
        try:
            if resource.resource_string:
                self._spawn_text(name, resource.resource_string, pose)
            else:
                self._world.spawn(read_model(self._allowed(resource.uri), name=name, pose=_at(pose)))
        except OSError as error:
            return _refuse(response, response.NO_RESOURCE, str(error))
        except NrpError as error:
            return _refuse(response, response.RESOURCE_PARSE_ERROR, str(error))
        response.entity_name, response.result.result = name, 1
        return None

    def _spawn_text(self, name: str, text: str, pose: Pose) -> None:
        answer = self._world.call("/gazebo/spawn_sdf_entity", name, text, "", pose, "world")
        if not answer.success:
            raise SceneError(answer.status_message)

    def _allowed(self, uri: str) -> Path:
        """Return the file of a model.

        Raises:
            OSError: it does not exist, or is not in a folder of models.
        """
        try:
            path = Path(unquote(urlparse(uri).path)).resolve(strict=True)
        except ValueError as error:  # an invalid URI, or a null byte
            raise FileNotFoundError(f"'{uri}' is not a file: {error}") from error
        if not any(path.is_relative_to(folder.resolve()) for folder in self._folders):
            places = ", ".join(map(str, self._folders)) or "no folder"
            raise PermissionError(f"'{path}' is not in {places}")
        return path

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


def _at(pose: Pose) -> world.Pose:
    p, q = pose.position, pose.orientation
    return world.Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def _fill(target: Any, values: Any) -> None:
    for name, value in zip("xyzw", values, strict=False):
        setattr(target, name, float(value))
