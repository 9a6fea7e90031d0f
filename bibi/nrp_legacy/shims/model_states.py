"""States of ``hbp_nrp_excontrol.nrp_states`` that move, add and delete models."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from nrp_core.errors import NrpError
from nrp_core.findings import Code
from nrp_core.world.messages.gazebo_msgs import ModelState
from nrp_core.world.messages.geometry_msgs import Point, Pose, Quaternion, Vector3
from nrp_core.world.pose_messages import pose_of
from nrp_core.world.rigid.pose import Pose as ScenePose
from nrp_core.world.rigid.pose import Vector, multiply
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
_SIZES = frozenset({"size", "radius", "length"})

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


def spawn(
    shape: Callable[[Any], Geometry],
    graph: Graph,
    model_name: Any,
    size: Any = None,
    position: Any = None,
    rotation: Any = None,
    *,
    gravity_factor: float = 1.0,
    color: str = "Gazebo/Grey",
    **more: Any,
) -> ChangeState:
    """Return a state that adds an object with one shape; without gravity it does not move.

    Args:
        shape: creates the shape from its size.
        graph: the graph of the run.
        model_name: name of the object.
        size: size of the shape, or the parameter with its own name (``radius``).
        position: position of its centre, m.
        rotation: its orientation.
        gravity_factor: 0 for a static object.
        color: name of a material.
        more: the size by its own name.
    """
    unknown = sorted(more.keys() - _SIZES) if size is None else list(more)
    if unknown:
        raise TypeError(f"a state that adds an object has no argument '{unknown[0]}'")
    given = size if size is not None else more
    name_of, position_of = Given(model_name), Given(position)

    def change(userdata: Any) -> None:
        geometry = shape(given)
        inertial = Inertial(HEAVY_KG, inertia=(MOMENT, MOMENT, MOMENT, 0.0, 0.0, 0.0))
        link = Link(
            "link",
            inertial=inertial if gravity_factor else None,
            visuals=(Visual("visual", geometry, rgba=color_of(color)),),
            collisions=(Collision("collision", geometry),),
        )
        name, pose = name_of(userdata), pose_of(_pose(position_of(userdata), rotation))
        graph.scales.pop(name, None)
        graph.world.spawn(Model(name, (link,), pose=pose, static=not gravity_factor))

    return ChangeState(graph, change)


def set_pose(
    graph: Graph,
    services: Services,
    model_name: Any,
    position: Any = None,
    rotation: Any = None,
    scale: Any = None,
) -> ChangeState:
    """Return a state that moves a model; each argument may be a function of the user data and its last value.

    Args:
        graph: the graph of the run.
        services: the services of the run.
        model_name: name of the model.
        position: its new position, m, or a whole pose; None: it stays.
        rotation: its new orientation; None: it stays.
        scale: its new size, as a factor or factors of its size in its file; None: it stays.
    """
    name_of, position_of, rotation_of, scale_of = map(Given, (model_name, position, rotation, scale))

    def change(userdata: Any) -> None:
        name, place, turn = name_of(userdata), position_of(userdata), rotation_of(userdata)
        factors = scale_of(userdata)

        def moved(now: Pose) -> Pose:
            if isinstance(place, Pose):
                return place
            return _pose(now.position if place is None else place, now.orientation if turn is None else turn)

        _move(services, name, moved)
        if factors is not None:
            before = graph.scales.get(name, (1.0, 1.0, 1.0))
            x, y, z = (new / old for new, old in zip(_factors(factors), before, strict=True))
            _resize(graph, name, (x, y, z))

    return ChangeState(graph, change)


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
    """Return a state that multiplies the size of a model."""
    factors = _numbers(x) if hasattr(x, "x") else (float(x), float(y), float(z))
    return ChangeState(graph, lambda _userdata: _resize(graph, model_name, factors))


def spawn_model(
    graph: Graph, services: Services, model_name: Any, model_xml: str = "", *places: Any, **more: Any
) -> ChangeState:
    """Return a state that adds a model from a text in SDF; a pose, or position and rotation, may follow."""
    xml = next((more[name] for name in ("xml", "sdf", "model_sdf") if name in more), model_xml)
    named = [more.get("initial_pose", more.get("pose", more.get("position"))), more.get("rotation")]
    position, rotation = (*places, *named, None, None)[:2] if places else named
    name_of, position_of = Given(model_name), Given(position)

    def change(userdata: Any) -> None:
        pose = _pose(position_of(userdata), rotation)
        answer = services.call("/gazebo/spawn_sdf_entity", name_of(userdata), xml, "", pose, "")
        if not answer.success:
            raise ServiceException(answer.status_message)

    return ChangeState(graph, change)


def destroy(graph: Graph, model_name: Any) -> ChangeState:
    """Return a state that deletes a model; its name may be a function of the user data and the last name."""
    name_of = Given(model_name)

    def change(userdata: Any) -> None:
        name = name_of(userdata)
        graph.world.delete(name)
        graph.scales.pop(name, None)

    return ChangeState(graph, change)


def _moving(graph: Graph, services: Services, name: str, moved: Callable[[Pose], Pose]) -> ChangeState:
    return ChangeState(graph, lambda _userdata: _move(services, name, moved))


def _move(services: Services, name: str, moved: Callable[[Pose], Pose]) -> None:
    now = services.call("/gazebo/get_model_state", name)
    if not now.success:
        raise ServiceException(now.status_message)
    services.call("/gazebo/set_model_state", ModelState(name, moved(now.pose)))


def _resize(graph: Graph, name: str, factors: Vector) -> None:
    """Replace a model by one that is larger or smaller by some factors."""
    if factors == (1.0, 1.0, 1.0):
        return
    world = graph.world
    model, now = world.scene.model(name), world.model_motion(name)
    world.delete(name)
    world.spawn(replace(scaled(model, factors), pose=now.pose))
    x, y, z = (a * b for a, b in zip(graph.scales.get(name, (1.0, 1.0, 1.0)), factors, strict=True))
    graph.scales[name] = x, y, z


def _factors(value: Any) -> Vector:
    return (float(value),) * 3 if isinstance(value, (int, float)) else _numbers(value)


def _pose(position: Any, rotation: Any) -> Pose:
    if isinstance(position, Pose):
        return position
    point = Point(*_numbers(position)) if position is not None else Point()
    return Pose(point) if rotation is None else Pose(point, _orientation(rotation))


def _orientation(rotation: Any) -> Quaternion:
    """Return a rotation that is given as a quaternion or as three angles, in any form."""
    if isinstance(rotation, Quaternion):
        return rotation
    if isinstance(rotation, Mapping) and "w" in rotation:
        rotation = [rotation[axis] for axis in "xyzw"]
    if isinstance(rotation, Sequence) and len(rotation) == len("xyzw"):
        return Quaternion(*map(float, rotation))
    return Quaternion(*ScenePose.from_rpy((0.0, 0.0, 0.0), *_numbers(rotation)).orientation)


def _numbers(value: Any) -> tuple[float, float, float]:
    """Return three numbers that are given as a message, a dictionary or a sequence."""
    if isinstance(value, Mapping):
        value = [value[axis] for axis in "xyz"]
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
        "ModelDestroyServiceState": partial(destroy, graph),
        "SetModelPose": put,
        "SetModelServiceState": put,
        "SetPose": put,
        "TranslateModelState": partial(translate, graph, services),
        "RotateModelState": partial(rotate, graph, services),
        "ScaleModelState": partial(scale, graph),
        "ModelSpawnServiceState": partial(spawn_model, graph, services),
    }
