"""Springs of joints. Engines apply the force at the start of a step, which is unstable for stiff springs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from nrp_core.world.scene.joint_inertia import joint_inertias
from nrp_core.world.scene.merged_bodies import Body

STIFF = 0.5
"""``stiffness * step^2 / (inertia + damping * step)`` above which a spring is stiff; engines take dampers at
the end of a step, so that the limit of stability is at least 2."""


def with_steady_springs(bodies: Sequence[Body], step_s: float) -> tuple[Body, ...]:
    """Return bodies whose springs are stable with the step.

    A stiff spring gets ``stiffness * step`` as additional damping, which is backward Euler. One that the
    damper of its joint holds acts as it is.

    Args:
        bodies: the bodies of one model.
        step_s: the physics step.
    """
    inertias = joint_inertias(bodies) if any(body.joint and body.joint.stiffness for body in bodies) else {}
    steady = []
    for body in bodies:
        joint = body.joint
        if joint and joint.stiffness:
            held = inertias.get(joint.name, 0.0) + joint.damping * step_s
            if joint.stiffness * step_s**2 > STIFF * held:
                body = replace(body, joint=replace(joint, damping=joint.damping + joint.stiffness * step_s))
        steady.append(body)
    return tuple(steady)
