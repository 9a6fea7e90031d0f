"""Bodies as SDF, for models that have no file of their own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import expm1, isfinite
from typing import Any, TypeAlias, cast

from lxml import etree

from nrp_core.scene.inertia import inertia_tensor
from nrp_core.scene.merged_bodies import Body
from nrp_core.world import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    Mesh,
    Model,
    Plane,
    Pose,
    Sphere,
)

FIXED = "nrp_fixed"
"""The name of the link that is fixed to the world."""
_KINDS = {"continuous": "revolute"}
_UNLIMITED = 1e16
Xml: TypeAlias = Any
"""An element of lxml, which has no types."""


def element(tag: str, *children: Xml, text: str = "", **attributes: str) -> Xml:
    """Return an element."""
    made = etree.Element(tag, attributes)
    made.text = text or None
    made.extend(children)
    return made


def numbers(tag: str, *values: float) -> Xml:
    """Return an element with numbers, which are read again without loss."""
    return element(tag, text=" ".join(map(repr, map(float, values))))


def pose_element(pose: Pose) -> Xml:
    """Return a pose as position and roll, pitch, yaw."""
    return numbers("pose", *pose.position, *pose.rpy)


def model_element(model: Model, bodies: Sequence[Body], step_s: float) -> Xml:
    """Return a model at the origin of its frame.

    Args:
        model: the model.
        bodies: its bodies.
        step_s: the physics step.
    """
    made = element("model", name=model.name)
    made.append(element("static", text=str(int(model.static))))
    made.append(element("allow_auto_disable", text="0"))
    for number, body in enumerate(bodies):
        made.append(_link(body, number, step_s))
        if body.fixed and not model.static:
            made.append(_held(FIXED))
        if body.joint is not None and body.parent is not None:
            made.append(_joint(body.joint, link_name(bodies[body.parent]), link_name(body)))
    return made


def link_name(body: Body) -> str:
    """Return the name of a body's link."""
    return FIXED if body.fixed else body.name


def _link(body: Body, number: int, step_s: float) -> Xml:
    made = element("link", pose_element(body.in_model), name=link_name(body))
    if body.inertial is not None:
        made.append(_inertial(body.inertial))
    if any(body.decay):  # the shares of velocities that Gazebo takes in each step
        shares = zip(("linear", "angular"), (-expm1(-rate * step_s) for rate in body.decay), strict=True)
        made.append(element("velocity_decay", *(numbers(*share) for share in shares)))
    for link in body.links:
        for visual in link.visuals:
            for part, shape in _shapes(visual.geometry, link.pose @ visual.pose, visual.name):
                made.append(element("visual", *shape, _material(visual.rgba), name=f"{link.name}/{part}"))
        for collision in link.collisions:
            for part, shape in _shapes(collision.geometry, link.pose @ collision.pose, collision.name):
                name = f"{number}/{link.name}/{part}"
                made.append(element("collision", *shape, _surface(collision), name=name))
    return made


def _inertial(inertial: Inertial) -> Xml:
    tensor = inertia_tensor(inertial)
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    moments = [numbers(name, float(tensor[place])) for name, place in names.items()]
    return element(
        "inertial",
        pose_element(Pose(inertial.pose.position)),
        numbers("mass", inertial.mass),
        element("inertia", *moments),
    )


def _material(rgba: tuple[float, float, float, float]) -> Xml:
    return element("material", numbers("ambient", *rgba), numbers("diffuse", *rgba))


def _surface(collision: Collision) -> Xml:
    friction = [numbers(name, collision.friction) for name in ("mu", "mu2")]
    rubbing = element("friction", element("ode", *friction))
    if collision.torsion:  # of a patch with a coefficient of 1
        rubbing.append(element("torsional", numbers("patch_radius", collision.patch_radius)))
    surface = element("surface", rubbing)
    if collision.is_selective:
        bits = {"collide_bitmask": collision.touched, "category_bitmask": collision.category}
        surface.append(element("contact", *(element(tag, text=str(each)) for tag, each in bits.items())))
    return surface


def _shapes(geometry: Geometry, pose: Pose, name: str) -> Iterator[tuple[str, list[Xml]]]:
    """Yield name and elements of the shapes of a geometry; SDF of Gazebo 11 has no capsule."""
    if not isinstance(geometry, Capsule):
        yield name, [pose_element(pose), element("geometry", _geometry(geometry))]
        return
    half = geometry.length / 2
    ends = [Pose((0.0, 0.0, height)) for height in (-half, half)]
    middle = Cylinder(geometry.radius, geometry.length)
    yield from _shapes(middle, pose, name)
    for number, end in enumerate(ends):
        yield from _shapes(Sphere(geometry.radius), pose @ end, f"{name}/end{number}")


def _geometry(geometry: Geometry) -> Xml:
    if isinstance(geometry, Box):
        return element("box", numbers("size", *geometry.size))
    if isinstance(geometry, Cylinder):
        return element("cylinder", numbers("radius", geometry.radius), numbers("length", geometry.length))
    if isinstance(geometry, Sphere):
        return element("sphere", numbers("radius", geometry.radius))
    if isinstance(geometry, Plane):
        return element("plane", numbers("normal", 0, 0, 1), numbers("size", *geometry.size))
    mesh = cast("Mesh", geometry)
    return element("mesh", element("uri", text=f"file://{mesh.path}"), numbers("scale", *mesh.scale))


def _held(link: str) -> Xml:
    parts = [element("parent", text="world"), element("child", text=link)]
    return element("joint", *parts, name=f"{link}_to_world", type="fixed")


def _joint(joint: Joint, parent: str, child: str) -> Xml:
    kind = _KINDS.get(joint.kind, joint.kind)
    made = element(
        "joint", element("parent", text=parent), element("child", text=child), name=joint.name, type=kind
    )
    if kind == "fixed":
        return made
    dynamics = {
        "damping": joint.damping,
        "friction": joint.friction,
        "spring_reference": joint.rest,
        "spring_stiffness": joint.stiffness,
    }
    lower, upper = (_UNLIMITED, _UNLIMITED) if joint.kind == "continuous" else (-joint.lower, joint.upper)
    made.append(
        element(
            "axis",
            numbers("xyz", *joint.axis),
            element("limit", numbers("lower", -_finite(lower)), numbers("upper", _finite(upper))),
            element("dynamics", *(numbers(name, value) for name, value in dynamics.items())),
        )
    )
    return made


def _finite(limit: float) -> float:
    return limit if isfinite(limit) else _UNLIMITED
