"""States of ``hbp_nrp_excontrol.nrp_states`` that move, add and delete models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from nrp_core.errors import NrpError
from nrp_core.world.messages.gazebo_msgs import ModelState
from nrp_core.world.messages.geometry_msgs import Point, Pose, Quaternion, Vector3
from nrp_core.world.pose_messages import pose_of
from nrp_core.world.rigid.pose import multiply
from nrp_core.world.scene.materials import color_of
from nrp_core.world.scene.model import (
    Box,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Link,
    Model,
    Sphere,
    Visual,
)
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.scaling import scaled
from nrp_legacy.shims.services import ServiceException, Services
from nrp_legacy.shims.smach import State

OUTCOMES = ("succeeded", "aborted", "preempted")
HEAVY_KG, MOMENT = 1.0, 0.01

Change = Callable[[], None]


class ChangeState(State):
    """Changes the scene once; what cannot be done is reported, and the state is aborted.

    Args:
        graph: of the run.
        change: does it.
    """

    def __init__(self, graph: Graph, change: Change) -> None:
        super().__init__(OUTCOMES)
        self._graph, self._change = graph, change

    def execute(self, userdata: Any) -> str:
        try:
            self._change()
        except (NrpError, ServiceException) as error:
            self._graph.warn(str(error))
            return "aborted"
        return "succeeded"


def spawn(
    shape: Callable[[Any], Geometry],
    graph: Graph,
    model_name: str,
    size: Any = None,
    position: Any = None,
    rotation: Any = None,
    *,
    gravity_factor: float = 1.0,
    color: str = "Gazebo/Grey",
    **more: Any,
) -> ChangeState:
    """Return a state that adds a thing of one shape; without gravity it stays where it is put.

    Args:
        shape: makes the shape from what gives its size.
        graph: of the run.
        model_name: of the thing.
        size: of the shape, or by the name that goes with it (``radius``).
        position: of its centre.
        rotation: its orientation.
        gravity_factor: 0 for a thing that nothing moves.
        color: name of a material.
        more: the size by its own name.
    """
    given = size if size is not None else more

    def change() -> None:
        geometry = shape(given)
        inertial = Inertial(HEAVY_KG, inertia=(MOMENT, MOMENT, MOMENT, 0.0, 0.0, 0.0))
        link = Link(
            "link",
            inertial=inertial if gravity_factor else None,
            visuals=(Visual("visual", geometry, rgba=color_of(color)),),
            collisions=(Collision("collision", geometry),),
        )
        pose = pose_of(_pose(position, rotation))
        graph.world.spawn(Model(model_name, (link,), pose=pose, static=not gravity_factor))

    return ChangeState(graph, change)


def set_pose(
    graph: Graph, services: Services, model_name: str, position: Any = None, rotation: Any = None
) -> ChangeState:
    """Return a state that puts a model somewhere; ``position`` may be a whole pose."""
    return _moving(graph, services, model_name, lambda _now: _pose(position, rotation))


def translate(
    graph: Graph, services: Services, model_name: str, x: Any = 0.0, y: float = 0.0, z: float = 0.0
) -> ChangeState:
    """Return a state that moves a model by a vector."""
    dx, dy, dz = (x.x, x.y, x.z) if hasattr(x, "x") else (x, y, z)

    def moved(now: Pose) -> Pose:
        p = now.position
        return Pose(Point(p.x + dx, p.y + dy, p.z + dz), now.orientation)

    return _moving(graph, services, model_name, moved)


def rotate(
    graph: Graph, services: Services, model_name: str, x: Any = 0.0, y: float = 0.0, z: float = 0.0
) -> ChangeState:
    """Return a state that turns a model: by angles about the axes of the world, or by a quaternion."""
    turn = _pose(None, x if hasattr(x, "x") else Vector3(x, y, z)).orientation

    def moved(now: Pose) -> Pose:
        before = now.orientation
        turned = multiply((turn.x, turn.y, turn.z, turn.w), (before.x, before.y, before.z, before.w))
        return Pose(now.position, Quaternion(*turned))

    return _moving(graph, services, model_name, moved)


def scale(graph: Graph, model_name: str, x: Any = 1.0, y: float = 1.0, z: float = 1.0) -> ChangeState:
    """Return a state that puts a model of another size in the place of one."""
    factors = _numbers(x) if hasattr(x, "x") else (float(x), float(y), float(z))

    def change() -> None:
        world = graph.world
        model, now = world.scene.model(model_name), world.model_motion(model_name)
        world.delete(model.name)
        world.spawn(replace(scaled(model, factors), pose=now.pose))

    return ChangeState(graph, change)


def spawn_model(
    graph: Graph, services: Services, model_name: str, model_xml: str = "", *places: Any, **more: Any
) -> ChangeState:
    """Return a state that adds a model of a text in SDF; a pose, or position and rotation, may follow."""
    xml = next((more[name] for name in ("xml", "sdf", "model_sdf") if name in more), model_xml)
    named = [more.get("initial_pose", more.get("pose", more.get("position"))), more.get("rotation")]
    position, rotation = (*places, *named, None, None)[:2] if places else named

    def change() -> None:
        answer = services.call("/gazebo/spawn_sdf_entity", model_name, xml, "", _pose(position, rotation), "")
        if not answer.success:
            raise ServiceException(answer.status_message)

    return ChangeState(graph, change)


def destroy(graph: Graph, model_name: str) -> ChangeState:
    """Return a state that takes a model out."""
    return ChangeState(graph, lambda: graph.world.delete(model_name))


def _moving(graph: Graph, services: Services, name: str, moved: Callable[[Pose], Pose]) -> ChangeState:
    def change() -> None:
        now = services.call("/gazebo/get_model_state", name)
        if not now.success:
            raise ServiceException(now.status_message)
        services.call("/gazebo/set_model_state", ModelState(name, moved(now.pose)))

    return ChangeState(graph, change)


def _pose(position: Any, rotation: Any) -> Pose:
    if isinstance(position, Pose):
        return position
    point = Point(*_numbers(position)) if position is not None else Point()
    if rotation is None:
        return Pose(point)
    if isinstance(rotation, Vector3):
        from nrp_core.world.rigid.pose import Pose as ScenePose

        turned = ScenePose.from_rpy((0.0, 0.0, 0.0), rotation.x, rotation.y, rotation.z)
        return Pose(point, Quaternion(*turned.orientation))
    return Pose(point, rotation if isinstance(rotation, Quaternion) else Quaternion(*rotation))


def _numbers(value: Any) -> tuple[float, float, float]:
    x, y, z = (value.x, value.y, value.z) if hasattr(value, "x") else value
    return float(x), float(y), float(z)


def _box(size: Any) -> Geometry:
    return Box(_numbers(size.get("size", (1, 1, 1)) if isinstance(size, dict) else size))


def _sphere(size: Any) -> Geometry:
    return Sphere(float(size.get("radius", 0.5) if isinstance(size, dict) else size))


def _cylinder(size: Any) -> Geometry:
    if isinstance(size, dict):
        return Cylinder(float(size.get("radius", 0.5)), float(size.get("length", 1.0)))
    return Cylinder(float(size), 1.0)


def model_states(graph: Graph, services: Services) -> dict[str, Callable[..., State]]:
    """Return the states by their names."""
    put = partial(set_pose, graph, services)
    return {
        "SpawnBox": partial(spawn, _box, graph),
        "SpawnSphere": partial(spawn, _sphere, graph),
        "SpawnCylinder": partial(spawn, _cylinder, graph),
        "DestroyModel": partial(destroy, graph),
        "SetModelPose": put,
        "SetModelServiceState": put,
        "SetPose": put,
        "TranslateModelState": partial(translate, graph, services),
        "RotateModelState": partial(rotate, graph, services),
        "ScaleModelState": partial(scale, graph),
        "ModelSpawnServiceState": partial(spawn_model, graph, services),
    }
