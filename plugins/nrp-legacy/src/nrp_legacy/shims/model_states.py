"""States of ``hbp_nrp_excontrol.nrp_states`` that move and delete models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from nrp_core.world.messages.gazebo_msgs import ModelState
from nrp_core.world.messages.geometry_msgs import Point, Pose, Quaternion, Vector3
from nrp_core.world.rigid import Vector, multiply
from nrp_legacy.shims.change_states import ChangeState, Given, numbers_of, posed
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.scaling import scaled
from nrp_legacy.shims.services import ServiceException, Services
from nrp_legacy.shims.smach import State
from nrp_legacy.shims.spawn_states import spawn_states


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
            return posed(now.position if place is None else place, now.orientation if turn is None else turn)

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
    turn = posed(None, x if hasattr(x, "x") else Vector3(x, y, z)).orientation

    def moved(now: Pose) -> Pose:
        before = now.orientation
        turned = multiply((turn.x, turn.y, turn.z, turn.w), (before.x, before.y, before.z, before.w))
        return Pose(now.position, Quaternion(*turned))

    return _moving(graph, services, model_name, moved)


def scale(graph: Graph, model_name: str, x: Any = 1.0, y: float = 1.0, z: float = 1.0) -> ChangeState:
    """Return a state that multiplies the size of a model."""
    factors = numbers_of(x) if hasattr(x, "x") else (float(x), float(y), float(z))
    return ChangeState(graph, lambda _userdata: _resize(graph, model_name, factors))


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
    return (float(value),) * 3 if isinstance(value, (int, float)) else numbers_of(value)


def model_states(graph: Graph, services: Services) -> dict[str, Callable[..., State]]:
    """Return the states by their names."""
    put = partial(set_pose, graph, services)
    return {
        "DestroyModel": partial(destroy, graph),
        "ModelDestroyServiceState": partial(destroy, graph),
        "SetModelPose": put,
        "SetModelServiceState": put,
        "SetPose": put,
        "TranslateModelState": partial(translate, graph, services),
        "RotateModelState": partial(rotate, graph, services),
        "ScaleModelState": partial(scale, graph),
        **spawn_states(graph, services),
    }
