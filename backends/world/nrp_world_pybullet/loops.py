"""Loops of joints, and ties of models: points that two links have in common."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.merged_bodies import Body, body_of
from nrp_core.world.scene.model import Model, Scene
from nrp_world_pybullet.library import bullet

Place = tuple[int, int]
"""A multi-body and a link of it."""
_NOBODY: Place = (-1, -1)


def close_loops(model: Model, placed: Sequence[tuple[Body, Place]], client: int) -> None:
    """Keep the links of loops together at their points, as they are where all joints are at 0.

    Args:
        model: the model.
        placed: its bodies, each with its place in PyBullet.
        client: the client of PyBullet.
    """
    for loop in model.loops:
        for point in loop.points:
            child, parent = (_end(model, placed, link, point) for link in (loop.child, loop.parent))
            if child[0] != parent[0]:  # or they are one body already
                _connect(child, parent, client)


def tie_models(scene: Scene, placed: Mapping[str, Sequence[tuple[Body, Place]]], client: int) -> None:
    """Hold models together at the points of their ties; the bodies that these connect do not collide.

    Args:
        scene: the models.
        placed: the bodies of each, each with its place in PyBullet.
        client: the client of PyBullet.
    """
    for tie in scene.ties:
        for there, here in tie.points:
            child, parent = (
                _end(scene.model(name), placed[name], link, point)
                for (name, link), point in ((tie.child, here), (tie.parent, there))
            )
            _connect(child, parent, client)
            pair, links = zip(child[0], parent[0], strict=True)
            bullet.setCollisionFilterPair(*pair, *links, 0, physicsClientId=client)


def _end(
    model: Model, placed: Sequence[tuple[Body, Place]], link: str, point: Vector
) -> tuple[Place, Vector]:
    """Return a body, and a point of the model in the frame of its centre of mass."""
    if link == WORLD:
        return _NOBODY, (model.pose @ Pose(point)).position
    body, place = placed[body_of([body for body, _ in placed], link)]
    centre = Pose() if body.inertial is None else body.inertial.pose
    there = (body.in_model @ centre).inverse() @ Pose(point)
    return place, there.position


def _connect(child: tuple[Place, Vector], parent: tuple[Place, Vector], client: int) -> None:
    (held, here), (holder, there) = child, parent
    bullet.createConstraint(
        *held, *holder, bullet.JOINT_POINT2POINT, (0, 0, 0), here, there, physicsClientId=client
    )
