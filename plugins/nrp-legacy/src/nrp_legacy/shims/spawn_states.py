"""States of ``hbp_nrp_excontrol.nrp_states`` that add models."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nrp_core.findings import Code
from nrp_core.world.model_states import pose_of
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
from nrp_legacy.shims.change_states import ChangeState, Given, numbers_of, posed
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.services import ServiceException, Services
from nrp_legacy.shims.smach import State

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
        name, pose = name_of(userdata), pose_of(posed(position_of(userdata), rotation))
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
        name, pose = name_of(userdata), posed(position_of(userdata), rotation)
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
