"""Joints as elements of MuJoCo, and how hard their constraints are."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

from nrp_core.world.scene.loops import Freedom
from nrp_core.world.scene.model import Joint
from nrp_world_mujoco.library import mujoco

FAR_AWAY = 1e9
SMALLEST = 1e-12  # MuJoCo refuses an empty range
HARD = [0.999, 0.999, 0.001, 0.5, 2.0]  # impedance of stiff constraints: couplings, joints that rub or stop
FIRMEST = [0.9999, 0.9999, 0.001, 0.5, 2.0]  # of joints that no load moves off their paths
_TYPES = {"prismatic": mujoco.mjtJoint.mjJNT_SLIDE, "ball": mujoco.mjtJoint.mjJNT_BALL}


def shortest(spec: Any) -> list[float]:
    """Return the shortest time constant (s) of a constraint, with the damping ratio."""
    return [2 * spec.option.timestep, 1.0]


def add_joint(element: Any, name: str, joint: Joint | Freedom, stiff: Sequence[float]) -> Any:
    """Add a joint to a body; it rubs and stops as hard as the step allows."""
    limited = joint.kind != "continuous" and (isfinite(joint.lower) or isfinite(joint.upper))
    return element.add_joint(
        name=name,
        type=_TYPES.get(joint.kind, mujoco.mjtJoint.mjJNT_HINGE),
        axis=joint.axis,
        limited=limited,
        range=_range(joint) if limited else [0, 0],
        damping=[joint.damping, 0, 0],
        frictionloss=joint.friction,
        stiffness=[joint.stiffness, 0, 0],
        springref=joint.rest,
        solref_friction=stiff,
        solimp_friction=HARD,
        solref_limit=stiff,
        solimp_limit=HARD,
    )


def _range(joint: Joint | Freedom) -> list[float]:
    lower = max(joint.lower, -FAR_AWAY)
    return [lower, max(min(joint.upper, FAR_AWAY), lower + SMALLEST)]
