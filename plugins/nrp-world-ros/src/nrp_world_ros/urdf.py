"""Robots as URDF, for rviz and other programs: links with masses and shapes, below the frames of ``/tf``.

The frame of a link in URDF is that of its joint. In SDF they may differ; such a robot has no URDF.
See http://wiki.ros.org/urdf/XML.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from nrp_core.errors import SceneError
from nrp_core.world import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    Link,
    Mesh,
    Model,
    Plane,
    Pose,
    Scene,
    Sphere,
    Visual,
)

NAME = "robot_description"
_NO_LIMIT = 1e9
_THIN_M = 1e-3
_APART_M = 1e-6
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def described(scene: Scene) -> dict[str, Model]:
    """Return the robots of a scene by the names of their descriptions: a single one has the usual name."""
    robots = [model for model in scene.models if not model.static and (model.joints or model.drives)]
    if len(robots) == 1:
        return {f"/{NAME}": robots[0]}
    return {f"/{model.name}/{NAME}": model for model in robots}


def urdf(model: Model) -> str:
    """Return a robot as URDF, with the names of its frames on ``/tf``.

    Raises:
        SceneError: URDF cannot express its joints.
    """
    robot = Element("robot", name=model.name)
    for link in model.links:
        there = SubElement(robot, "link", name=_frame(model, link.name))
        if link.inertial is not None:
            _weigh(there, link.inertial)
        for visual in link.visuals:
            _draw(there, visual)
        for collision in link.collisions:
            _shape(there, "collision", collision)
    held: dict[str, Joint] = {}
    for joint in model.joints:
        if joint.parent != "world" and held.setdefault(joint.child, joint) is not joint:
            raise SceneError(f"two joints hold '{joint.child}' of '{model.name}', which URDF cannot say")
    base = model.links[0]
    if base.name in held:
        raise SceneError(f"the base '{base.name}' of '{model.name}' hangs on a joint, which URDF cannot say")
    for link in model.links[1:]:
        _join(
            robot,
            model,
            link,
            held.get(link.name, Joint(f"{link.name}_free", "floating", base.name, link.name)),
        )
    indent(robot)  # PyBullet does not read long lines
    return tostring(robot, encoding="unicode")


def _frame(model: Model, link: str) -> str:
    return f"{model.name}/{link}"


def _join(robot: Element, model: Model, link: Link, joint: Joint) -> None:
    """Add the joint that holds a link."""
    kind = "floating" if joint.kind == "ball" else joint.kind
    there = SubElement(robot, "joint", name=joint.name, type=kind)
    _place(there, model.link(joint.parent).pose.inverse() @ link.pose)
    SubElement(there, "parent", link=_frame(model, joint.parent))
    SubElement(there, "child", link=_frame(model, joint.child))
    if kind in ("fixed", "floating"):
        return
    offset = link.pose.inverse() @ joint.pose
    axis = offset.rotate(joint.axis)
    if kind != "prismatic" and np.linalg.norm(np.cross(offset.position, axis)) > _APART_M:
        raise SceneError(
            f"'{joint.name}' of '{model.name}' does not turn about the frame of its link, as in URDF"
        )
    SubElement(there, "axis", xyz=_text(axis))
    limits = {"effort": joint.effort, "velocity": joint.velocity}
    if kind != "continuous":
        limits |= {"lower": joint.lower, "upper": joint.upper}
    SubElement(there, "limit", {name: _text([limit]) for name, limit in limits.items()})
    if joint.mimic is not None:
        numbers = {"multiplier": _text([joint.mimic.multiplier]), "offset": _text([joint.mimic.offset])}
        SubElement(there, "mimic", numbers, joint=joint.mimic.leader)


def _weigh(link: Element, inertial: Inertial) -> None:
    there = SubElement(link, "inertial")
    _place(there, inertial.pose)
    SubElement(there, "mass", value=f"{inertial.mass:.12g}")
    values = dict(zip(_MOMENTS, inertial.inertia, strict=True))
    SubElement(there, "inertia", {name: f"{value:.12g}" for name, value in values.items()})


def _shape(link: Element, tag: str, shape: Visual | Collision) -> list[Element]:
    """Add a shape, and return its elements."""
    added = []
    for geometry, pose in _shapes(shape.geometry):
        there = SubElement(link, tag)
        _place(there, shape.pose @ pose)
        SubElement(SubElement(there, "geometry"), geometry.tag, geometry.attrib)
        added.append(there)
    return added


def _draw(link: Element, visual: Visual) -> None:
    for there in _shape(link, "visual", visual):
        material = SubElement(there, "material", name=" ".join(map(str, visual.rgba)))
        SubElement(material, "color", rgba=_text(visual.rgba))


def _shapes(geometry: Geometry) -> Iterator[tuple[Element, Pose]]:
    """Yield the shapes of URDF that make up one of a scene, which also has capsules and planes."""
    match geometry:
        case Box(size):
            yield Element("box", size=_text(size)), Pose()
        case Plane(size):
            yield Element("box", size=_text([*size, _THIN_M])), Pose()
        case Sphere(radius):
            yield Element("sphere", radius=_text([radius])), Pose()
        case Cylinder(radius, length):
            yield Element("cylinder", radius=_text([radius]), length=_text([length])), Pose()
        case Capsule(radius, length):
            yield from _shapes(Cylinder(radius, length))
            for z in (-length / 2, length / 2):
                yield Element("sphere", radius=_text([radius])), Pose((0.0, 0.0, z))
        case Mesh(path, scale):
            yield Element("mesh", filename=path.resolve().as_uri(), scale=_text(scale)), Pose()


def _place(there: Element, pose: Pose) -> None:
    SubElement(there, "origin", xyz=_text(pose.position), rpy=_text(pose.rpy))


def _text(numbers: Iterable[float]) -> str:
    """Return numbers as text, without what rounding adds to 0; URDF has no infinite ones."""
    finite = (round(min(max(each, -_NO_LIMIT), _NO_LIMIT), 12) + 0.0 for each in numbers)
    return " ".join(f"{each:.12g}" for each in finite)
