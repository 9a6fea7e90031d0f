"""Springs of joints: engines pull with the force at the start of a step, which suits all but the stiffest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from nrp_core.world.scene.joint_inertia import joint_inertias
from nrp_core.world.scene.merged_bodies import Body

STIFF = 0.5
"""``stiffness * step^2 / inertia`` of a spring from which on it is stiff; at 4 it would shake to pieces."""


def with_steady_springs(bodies: Sequence[Body], step_s: float) -> tuple[Body, ...]:
    """Return bodies whose springs no step is too long for.

    A stiff spring pulls as strongly as it will at the end of the step, by backward Euler: with
    ``stiffness * step`` as damping.

    Args:
        bodies: of one model.
        step_s: the physics step.
    """
    inertias = joint_inertias(bodies) if any(body.joint and body.joint.stiffness for body in bodies) else {}
    steady = []
    for body in bodies:
        joint = body.joint
        if joint and joint.stiffness * step_s**2 > STIFF * inertias.get(joint.name, 0.0):
            body = replace(body, joint=replace(joint, damping=joint.damping + joint.stiffness * step_s))
        steady.append(body)
    return tuple(steady)
