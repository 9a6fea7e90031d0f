"""The inertia that joints have to move, and gains with which they follow quickly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nrp_core.world.scene.acting import Pid
from nrp_core.world.scene.mass import combined, turned
from nrp_core.world.scene.merged_bodies import Body, tree_of
from nrp_core.world.scene.model import Inertial

STIFF_TIME_CONSTANT_S = 0.04
"""Time constant of joints without gains in their files, s."""


def joint_inertias(bodies: Sequence[Body]) -> Mapping[str, float]:
    """Return the inertia (kg m^2) or mass (kg) that each movable joint has to move, with all joints at 0.

    That of a ball joint is the one about the axis about which it is the largest.
    """
    return {
        body.joint.name: _inertia(index, bodies)
        for index, body in enumerate(bodies)
        if body.joint is not None
    }


def _inertia(index: int, bodies: Sequence[Body]) -> float:
    body = bodies[index]
    assert body.joint is not None
    to_joint = body.in_model.inverse()
    masses = [
        Inertial(part.inertial.mass, to_joint @ part.in_model @ part.inertial.pose, part.inertial.inertia)
        for part in (bodies[each] for each in tree_of(index, bodies))
        if part.inertial is not None
    ]
    whole = combined(masses)
    assert whole is not None  # movable bodies have mass
    if body.joint.kind == "prismatic":
        return whole.mass
    if body.joint.kind == "ball":
        to_centre = np.array(whole.pose.position)
        outer = to_centre @ to_centre * np.eye(3) - np.outer(to_centre, to_centre)
        return float(np.linalg.eigvalsh(turned(whole) + whole.mass * outer)[-1])
    axis = np.array(body.joint.axis)
    lever = np.cross(axis, whole.pose.position)
    return float(axis @ turned(whole) @ axis + whole.mass * lever @ lever)


def stiff_gains(inertia: float, *, velocity: bool = False) -> Pid:
    """Return gains with which a joint follows quickly with any load: critically damped."""
    rate = inertia / STIFF_TIME_CONSTANT_S
    return Pid(p=rate) if velocity else Pid(p=rate / STIFF_TIME_CONSTANT_S, d=2 * rate)
