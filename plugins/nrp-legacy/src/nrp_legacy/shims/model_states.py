"""States of ``hbp_nrp_excontrol.nrp_states`` that add, move, scale and delete models."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from nrp_core.errors import NrpError
from nrp_core.findings import Code
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose, Quaternion, Vector3
from nrp_core.scene.materials import color_of
from nrp_core.scene.rigid import multiply
from nrp_core.world import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Link,
    Mesh,
    Model,
    Sphere,
    Vector,
    Visual,
)
from nrp_core.world import Pose as ScenePose
from nrp_core.world.model_states import pose_of
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.services import ServiceException, Services
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


def to_pose(position: Any, rotation: Any) -> Pose:
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


_MOMENT = 0.01
_SIZES = frozenset({"size", "radius", "length"})

_LINK, _VISUAL = "body", "visual"
"""The names of the parts of an object, by which machines change its look."""


def spawn(
    shape: Callable[[Any], Geometry],
    collides: bool,
    graph: Graph,
    model_name: Any,
    size: Any = None,
    position: Any = None,
    rotation: Any = None,
    can_collide: Any = None,
    gravity_factor: Any = 1.0,
    mass: float = 1.0,
    color: str = "Gazebo/Grey",
    **more: Any,
) -> ChangeState:
    """Return a state that adds an object with one shape; without gravity it does not move.

    Args:
        shape: creates the shape from its size.
        collides: whether it collides by default.
        graph: the graph of the run.
        model_name: name of the object.
        size: size of the shape, or the parameter with its own name (``radius``).
        position: position of its centre, m.
        rotation: its orientation.
        can_collide: whether it collides with other objects; None: the default of its shape.
        gravity_factor: 0 for a static object.
        mass: kg.
        color: name of a material.
        more: the size by its own name; ``use_gravity``, which ``gravity_factor`` followed;
            ``kinematic``, which has no effect.
    """
    more.pop("kinematic", None)
    gravity_factor = more.pop("use_gravity", gravity_factor)
    unknown = sorted(more.keys() - _SIZES) if size is None else list(more)
    if unknown:
        raise TypeError(f"a state that adds an object has no argument '{unknown[0]}'")
    given = size if size is not None else more
    name_of, position_of = Given(model_name), Given(position)
    geometry = shape(given)
    hits = collides if can_collide is None else bool(can_collide)
    link = Link(
        _LINK,
        inertial=Inertial(mass, inertia=(_MOMENT * mass,) * 3 + (0.0,) * 3) if gravity_factor else None,
        visuals=(Visual(_VISUAL, geometry, rgba=color_of(color)),),
        collisions=(Collision("collision", geometry),) if hits else (),
    )

    def change(userdata: Any) -> None:
        name, pose = name_of(userdata), pose_of(to_pose(position_of(userdata), rotation))
        if gravity_factor and not hits:
            message = (
                f"the object '{name}' falls through the floor: spheres and cylinders of state machines "
                "collide only with can_collide=True, and float with gravity_factor=0"
            )
            graph.warn(Code.NRP292, message, subject=name)
        graph.scales.pop(name, None)
        graph.world.spawn(Model(name, (link,), pose=pose, static=not gravity_factor))

    return ChangeState(graph, change)


def spawn_model(
    graph: Graph, services: Services, model_name: Any, geometry: str = "", *places: Any, **more: Any
) -> ChangeState:
    """Return a state that adds a model: a text in SDF, or the geometry of its only link.

    A pose, or position and rotation, may follow. For a geometry there are also ``can_collide``,
    ``gravity_factor`` (or ``use_gravity``), ``mass`` and ``color``.
    """
    names = ("xml", "sdf", "model_sdf", "model_xml")
    shape = {"gravity_factor": more.get("use_gravity", 1), **more}
    text = next((more[name] for name in names if name in more), geometry)
    named = [more.get("initial_pose", more.get("pose", more.get("position"))), more.get("rotation")]
    position, rotation = (*places, *named, None, None)[:2] if places else named
    name_of, position_of = Given(model_name), Given(position)

    def change(userdata: Any) -> None:
        name, pose = name_of(userdata), to_pose(position_of(userdata), rotation)
        xml = text if "<model" in text else _around(text, name, **shape)
        answer = services.call("/gazebo/spawn_sdf_entity", name, xml, "", pose, "")
        if not answer.success:
            raise ServiceException(answer.status_message)

    return ChangeState(graph, change)


def _around(
    geometry: str,
    name: str,
    *,
    can_collide: Any = True,
    gravity_factor: Any = 1,
    mass: float = 1.0,
    color: str = "Gazebo/Grey",
    **_more: Any,
) -> str:
    """Return a model in SDF around a geometry in SDF."""
    shape = geometry if "<geometry" in geometry else f"<geometry>{geometry}</geometry>"
    moment = _MOMENT * float(mass)
    inertia = "".join(f"<{axis}>{moment}</{axis}>" for axis in ("ixx", "iyy", "izz"))
    collision = f'<collision name="collision">{shape}</collision>' if can_collide else ""
    return (
        f'<sdf version="1.6"><model name="{name}"><static>{int(not gravity_factor)}</static>'
        f'<link name="{_LINK}">'
        f"<inertial><mass>{float(mass)}</mass><inertia>{inertia}</inertia></inertial>{collision}"
        f'<visual name="{_VISUAL}">{shape}<material><script><name>{color}</name></script></material></visual>'
        "</link></model></sdf>"
    )


def _box(size: Any) -> Geometry:
    return Box(numbers_of(size.get("size", (1, 1, 1)) if isinstance(size, dict) else size))


def _sphere(size: Any) -> Geometry:
    return Sphere(float(size.get("radius", 1.0) if isinstance(size, dict) else size))


def _cylinder(size: Any) -> Geometry:
    if isinstance(size, dict):
        return Cylinder(float(size.get("radius", 1.0)), float(size.get("length", 1.0)))
    return Cylinder(float(size), 1.0)


def spawn_states(graph: Graph, services: Services) -> dict[str, Callable[..., State]]:
    """Return the states by their names."""
    return {
        "SpawnBox": partial(spawn, _box, True, graph),
        "SpawnSphere": partial(spawn, _sphere, False, graph),
        "SpawnCylinder": partial(spawn, _cylinder, False, graph),
        "ModelSpawnServiceState": partial(spawn_model, graph, services),
    }


Part = TypeVar("Part", Visual, Collision)


def scale_model(model: Model, factors: Vector) -> Model:
    """Return a scale_model model; round shapes stay round, and masses do not change.

    Args:
        model: the model.
        factors: factors along x, y and z.
    """
    links = tuple(_link(link, factors) for link in model.links)
    joints = tuple(replace(joint, pose=_pose(joint.pose, factors)) for joint in model.joints)
    return replace(model, links=links, joints=joints)


def _link(link: Link, factors: Vector) -> Link:
    inertial = link.inertial
    return replace(
        link,
        pose=_pose(link.pose, factors),
        inertial=None if inertial is None else replace(inertial, pose=_pose(inertial.pose, factors)),
        visuals=tuple(_shape(visual, factors) for visual in link.visuals),
        collisions=tuple(_shape(collision, factors) for collision in link.collisions),
    )


def _shape(part: Part, factors: Vector) -> Part:
    return replace(part, pose=_pose(part.pose, factors), geometry=_geometry(part.geometry, factors))


def _pose(pose: ScenePose, factors: Vector) -> ScenePose:
    return ScenePose(_times(pose.position, factors), pose.orientation)


def _geometry(geometry: Geometry, factors: Vector) -> Geometry:
    x, _, z = factors
    if isinstance(geometry, Box):
        return Box(_times(geometry.size, factors))
    if isinstance(geometry, Sphere):
        return Sphere(geometry.radius * x)
    if isinstance(geometry, (Cylinder, Capsule)):
        return type(geometry)(geometry.radius * x, geometry.length * z)
    return (
        replace(geometry, scale=_times(geometry.scale, factors)) if isinstance(geometry, Mesh) else geometry
    )


def _times(vector: Vector, factors: Vector) -> Vector:
    (x, y, z), (a, b, c) = vector, factors
    return x * a, y * b, z * c


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
            return to_pose(
                now.position if place is None else place, now.orientation if turn is None else turn
            )

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
    turn = to_pose(None, x if hasattr(x, "x") else Vector3(x, y, z)).orientation

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
    world.spawn(replace(scale_model(model, factors), pose=now.pose))
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
