"""Loops of joints: points that two links have in common."""

from __future__ import annotations

from collections.abc import Sequence

from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.merged_bodies import Body, body_of
from nrp_core.world.scene.model import Model
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
    bodies = [body for body, _ in placed]

    def end(link: str, point: Vector) -> tuple[Place, Vector]:
        """Return a body, and a point of the model in the frame of its centre of mass."""
        if link == WORLD:
            return _NOBODY, (model.pose @ Pose(point)).position
        body, place = placed[body_of(bodies, link)]
        centre = Pose() if body.inertial is None else body.inertial.pose
        there = (body.in_model @ centre).inverse() @ Pose(point)
        return place, there.position

    for loop in model.loops:
        for point in loop.points:
            (child, here), (parent, there) = end(loop.child, point), end(loop.parent, point)
            if child != parent:  # or they are one body already
                bullet.createConstraint(
                    *child, *parent, bullet.JOINT_POINT2POINT, (0, 0, 0), here, there, physicsClientId=client
                )
