"""Shapes, contact properties and loops of joints in PyBullet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, combinations, product
from math import isfinite, sqrt
from typing import Any

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Findings
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.loops import Tie
from nrp_core.scene.merged_bodies import Body, body_of
from nrp_core.scene.model import (
    Box,
    Capsule,
    Collision,
    ConcaveMesh,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Model,
    Plane,
    Scene,
    Sphere,
)
from nrp_core.scene.origin import Native
from nrp_core.scene.rigid import Pose, Vector
from nrp_world_pybullet.library import bullet

Place = tuple[int, int]
"""A multi-body and a link of it."""
Placed = Sequence[tuple[Body, Place]]
"""The bodies of a model, each with its place in PyBullet."""
_NOBODY: Place = (-1, -1)
_ALONG: Vector = (0.0, 0.0, 0.0)


def close_loops(model: Model, placed: Placed, client: int) -> None:
    """Keep the links of loops together at the points where they meet with all joints at 0.

    Args:
        model: the model.
        placed: its bodies.
        client: the client of PyBullet.
    """
    for loop in model.loops:
        for point in loop.points:
            child, parent = (_end(model, placed, link, Pose(point)) for link in (loop.child, loop.parent))
            if child[0] != parent[0]:  # or they are one body already
                _connect(child, parent, client)


def tie_models(scene: Scene, placed: Mapping[str, Placed], client: int, warnings: Findings) -> None:
    """Hold models together by their ties; the bodies that these connect do not collide.

    Args:
        scene: the models.
        placed: the bodies of each.
        client: the client of PyBullet.
        warnings: receives a finding for each feature that PyBullet lacks.
    """
    for tie in scene.ties:
        if lacking := _lacking(tie):
            message = f"the joint '{tie.name}' between two models is {tie.kind}: PyBullet {lacking}"
            warnings.add(Code.NRP260, message, subject=tie.name)
        slides = _slides(tie)
        if tie.freedoms and not slides:
            continue
        points = [(tie.in_parent, tie.in_child)] if slides else _poses(tie)
        for there, here in points:
            child, parent = (
                _end(scene.model(name), placed[name], link, at)
                for (name, link), at in ((tie.child, here), (tie.parent, there))
            )
            if slides:
                _slide(parent, child, tie.freedoms[0].axis, client)
            else:
                _connect(child, parent, client)
            pair, links = zip(child[0], parent[0], strict=True)
            bullet.setCollisionFilterPair(*pair, *links, 0, physicsClientId=client)


def _poses(tie: Tie) -> list[tuple[Pose, Pose]]:
    return [(Pose(there), Pose(here)) for there, here in tie.points]


def _slides(tie: Tie) -> bool:
    return [freedom.kind for freedom in tie.freedoms] == ["prismatic"]


def _lacking(tie: Tie) -> str:
    """Return the features of a tie that PyBullet lacks; empty if it has all."""
    if tie.freedoms and not _slides(tie):
        return "leaves them apart"
    bounded = (isfinite(each.lower) or isfinite(each.upper) for each in tie.freedoms)
    slowed = (each.damping or each.friction or each.stiffness for each in tie.freedoms)
    return "lets them slide without limits, damping, friction and springs" if any((*bounded, *slowed)) else ""


def _end(model: Model, placed: Placed, link: str, at: Pose) -> tuple[Place, Pose]:
    """Return a body, and a pose in the frame of the model in that of its centre of mass."""
    if link == WORLD:
        return _NOBODY, model.pose @ at
    body, place = placed[body_of([body for body, _ in placed], link)]
    centre = Pose() if body.inertial is None else body.inertial.pose
    return place, (body.in_model @ centre).inverse() @ at


def _connect(child: tuple[Place, Pose], parent: tuple[Place, Pose], client: int) -> None:
    (held, here), (holder, there) = child, parent
    ends, kind = (here.position, there.position), bullet.JOINT_POINT2POINT
    bullet.createConstraint(*held, *holder, kind, _ALONG, *ends, physicsClientId=client)


def _slide(parent: tuple[Place, Pose], child: tuple[Place, Pose], axis: Vector, client: int) -> None:
    """Let a body move along an axis of another one; the frames of both keep their directions."""
    (holder, there), (held, here) = parent, child
    bullet.createConstraint(
        *holder,
        *held,
        bullet.JOINT_PRISMATIC,
        axis,
        there.position,
        here.position,
        there.orientation,
        here.orientation,
        physicsClientId=client,
    )


_ANCHOR = "friction_anchor"
"""An element without a value."""
_ARGUMENTS = {
    "lateral_friction": "lateralFriction",
    "rolling_friction": "rollingFriction",
    "spinning_friction": "spinningFriction",
    "restitution": "restitution",
    "stiffness": "contactStiffness",
    "damping": "contactDamping",
}
_UNUSED = ("contact_cfm", "contact_erp", "inertia_scaling")
"""Elements of PyBullet's reader that cannot be set in a world that was not read by it."""


def set_contacts(model: Model, links: Mapping[str, tuple[int, int]], client: int, warnings: Findings) -> None:
    """Set the properties of contacts that a model has for PyBullet.

    Args:
        model: the model.
        links: the multi-body and index of each link.
        client: the physics client.
        warnings: receives the elements that are valid and not used.

    Raises:
        SceneError: an element is invalid; the message names its file and line.
    """
    for element in model.native:
        if element.namespace == "pybullet":
            if element.tag != "contact":
                hint = did_you_mean(element.tag, ("contact",))
                raise element.error(f"not an element that is used here{hint}")
            link = element.attribute("link")
            if link is None or link not in links:
                wanted = 'it needs link="..."' if link is None else f"the model has no link '{link}'"
                raise element.error(f"{wanted}{did_you_mean(link or '', links)}")
            for each in (each for each in element.children if each.tag in _UNUSED):
                message = f"<{each.tag}> of the <contact> of '{link}' is not used"
                warnings.add(Code.NRP383, message, subject=each.tag, path=each.path, line=each.line or None)
            used = [each for each in element.children if each.tag not in (*_UNUSED, _ANCHOR)]
            values = dict(map(_value, used))
            if any(each.tag == _ANCHOR for each in element.children):
                bullet.changeDynamics(*links[link], frictionAnchor=1, physicsClientId=client)
            if ("contactStiffness" in values) != ("contactDamping" in values):
                raise element.error("stiffness and damping only act together; give both")
            bullet.changeDynamics(*links[link], **values, physicsClientId=client)


def _value(element: Native) -> tuple[str, float]:
    """Return PyBullet's argument and the value for an element such as ``<stiffness value="1000"/>``."""
    if element.tag not in _ARGUMENTS:
        hint = did_you_mean(element.tag, _ARGUMENTS)
        raise element.error(f"not a property that can be set{hint}")
    text = element.attribute("value") or ""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not (isfinite(value) and value >= 0):
        raise element.error(f"its value must be a number of 0 or more, not '{text}'")
    return _ARGUMENTS[element.tag], value


def friction_factors(
    scene: Scene, bodies: Mapping[str, Sequence[Body]], warnings: Findings
) -> Mapping[float, float]:
    """Return the factor for each coefficient of friction of a scene.

    A contact has the smaller of two coefficients. PyBullet multiplies those of a pair, so it gets factors
    ``min(mu, m) / sqrt(m)``. Their product is the smaller one if one is at least ``m`` and the
    other at most ``m``; ``m`` is the coefficient of the scene with the smallest error.

    Args:
        scene: the models.
        bodies: the simulated bodies of each model.
        warnings: receives the pair of two models with the largest error.
    """
    kinds = Counter(
        (model.static, frozenset(shape.friction for each in links for shape in each.collisions))
        for model in scene.models
        for links in [[link for body in bodies[model.name] for link in body.links]]
    )
    twice = [kind for kind, count in kinds.items() for _ in range(min(count, 2))]
    touching = (
        product(one, other) for (still, one), (fixed, other) in combinations(twice, 2) if not still & fixed
    )
    pairs = sorted(set(chain.from_iterable(touching)))
    values = {mu for _, each in kinds for mu in each}
    choices = sorted(values - {0.0}, reverse=True) or [1.0]
    wrongs = [max((_product_error(*pair, most), *pair) for pair in [*pairs, (0.0, 0.0)]) for most in choices]
    (wrong, one, other), most = min(zip(wrongs, choices, strict=True), key=lambda each: each[0][0])
    if wrong > 1e-9:
        message = (
            f"PyBullet multiplies coefficients of friction: that of a contact of {one:g} and {other:g} is "
            f"wrong by {wrong:.2g}, because others are up to {choices[0]:g}"
        )
        warnings.add(Code.NRP264, message, subject="friction")
    return {mu: min(mu, most) / sqrt(most) for mu in values}


def _product_error(one: float, other: float, most: float) -> float:
    return abs(min(one, most) * min(other, most) / most - min(one, other))


MAX_SHAPES = 16
"""PyBullet's limit of shapes in one link; beyond it the process crashes."""
NO_SHAPE = -1
GROUND_M, GROUND_DEPTH_M = 2000.0, 100.0


def collisions_of(body: Body) -> list[Sequence[Collision]]:
    """Return the collisions of a body in its frame, distributed to as many links as PyBullet needs.

    Those of a link have the same frictions and bits, which PyBullet sets for a whole link. There is
    at least one link, which may have none.
    """
    alike: dict[tuple[float, ...], list[Collision]] = {}
    for link in body.links:
        for collision in link.collisions:
            placed = replace(collision, pose=link.pose @ collision.pose)
            frictions = collision.friction, collision.torsion, collision.rolling
            alike.setdefault((*frictions, collision.category, collision.touched), []).append(placed)
    return [chunk for each in alike.values() for chunk in _chunks(each)] or [()]


def _chunks(items: Sequence[Collision]) -> Iterator[Sequence[Collision]]:
    return (items[start : start + MAX_SHAPES] for start in range(0, len(items), MAX_SHAPES))


def add_collisions(collisions: Sequence[Collision], client: int) -> int:
    """Load collision shapes as one compound and return its id."""
    if not collisions:
        return NO_SHAPE
    shapes = [_touched(collision.geometry, collision.pose) for collision in collisions]
    return int(bullet.createCollisionShapeArray(**_arguments(shapes), physicsClientId=client))


def _touched(geometry: Geometry, pose: Pose) -> tuple[Geometry, Pose]:
    """Return the collision geometry; for a plane a block, because boxes that slide on a plane rattle."""
    if not isinstance(geometry, Plane):
        return geometry, pose
    return Box((GROUND_M, GROUND_M, GROUND_DEPTH_M)), pose @ Pose((0.0, 0.0, -GROUND_DEPTH_M / 2))


def _arguments(shapes: Sequence[tuple[Geometry, Pose]]) -> dict[str, Any]:
    """Return the arguments of PyBullet's array function, which takes every size of every shape."""
    rows = [_row(geometry) for geometry, _ in shapes]
    return {
        **{name: [row[name] for row in rows] for name in rows[0]},
        "collisionFramePositions": [pose.position for _, pose in shapes],
        "collisionFrameOrientations": [pose.orientation for _, pose in shapes],
    }


def _row(geometry: Geometry) -> dict[str, Any]:
    unused = {
        "halfExtents": (1, 1, 1),
        "radii": 1,
        "lengths": 1,
        "fileNames": "",
        "meshScales": (1, 1, 1),
        "flags": 0,
    }
    match geometry:
        case Plane():
            raise AssertionError("planes are collided as blocks")
        case Box((x, y, z)):
            return unused | {"shapeTypes": bullet.GEOM_BOX, "halfExtents": (x / 2, y / 2, z / 2)}
        case Sphere(radius):
            return unused | {"shapeTypes": bullet.GEOM_SPHERE, "radii": radius}
        case Cylinder(radius, length):
            return unused | {"shapeTypes": bullet.GEOM_CYLINDER, "radii": radius, "lengths": length}
        case Capsule(radius, length):
            return unused | {"shapeTypes": bullet.GEOM_CAPSULE, "radii": radius, "lengths": length}
        case Heightmap(path, scale) | ConcaveMesh(path, scale):
            concave = {"shapeTypes": bullet.GEOM_MESH, "flags": bullet.GEOM_FORCE_CONCAVE_TRIMESH}
            return unused | concave | {"fileNames": str(path), "meshScales": scale}
        case Mesh(path, scale):
            return unused | {"shapeTypes": bullet.GEOM_MESH, "fileNames": str(path), "meshScales": scale}
