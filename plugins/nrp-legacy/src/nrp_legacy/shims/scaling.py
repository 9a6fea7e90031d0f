"""Models at another size."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from nrp_core.world.rigid import Pose, Vector
from nrp_core.world.scene.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Link,
    Mesh,
    Model,
    Sphere,
    Visual,
)

Part = TypeVar("Part", Visual, Collision)


def scaled(model: Model, factors: Vector) -> Model:
    """Return a scaled model; round shapes stay round, and masses do not change.

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


def _pose(pose: Pose, factors: Vector) -> Pose:
    return Pose(_times(pose.position, factors), pose.orientation)


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
