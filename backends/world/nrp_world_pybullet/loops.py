"""Loops of joints, and ties of models: points that two links have in common, and rails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite

from nrp_core.findings import Code, Findings
from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.loops import Tie
from nrp_core.world.scene.merged_bodies import Body, body_of
from nrp_core.world.scene.model import Model, Scene
from nrp_world_pybullet.library import bullet

Place = tuple[int, int]
"""A multi-body and a link of it."""
Placed = Sequence[tuple[Body, Place]]
"""The bodies of a model, each with its place in PyBullet."""
_NOBODY: Place = (-1, -1)
_ALONG: Vector = (0.0, 0.0, 0.0)


def close_loops(model: Model, placed: Placed, client: int) -> None:
    """Keep the links of loops together at their points, as they are where all joints are at 0.

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
        warnings: receives what PyBullet does not have of them.
    """
    for tie in scene.ties:
        if lacking := _lacking(tie):
            message = f"the joint '{tie.name}' between two models is {tie.kind}: PyBullet {lacking}"
            warnings.add(Code.NRP345, message, subject=tie.name)
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
    """Return what PyBullet lacks of a tie; empty for nothing."""
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
    """Let a body move along an axis of another one, both of which have frames that keep their directions."""
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
