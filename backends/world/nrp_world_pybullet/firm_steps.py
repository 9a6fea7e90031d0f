"""The velocities of the motors of firm joints, in one compiled call."""

from __future__ import annotations

from typing import Any

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import jit
from nrp_core.world.engine_kit.firm_kinds import POSITION
from nrp_core.world.engine_kit.firm_paths import advance, velocities_to


@jit
def set_motor_targets(
    moving: bool,
    times_s: FloatArray,
    largest: float,
    positions: FloatArray,
    velocities: FloatArray,
    learnt: FloatArray,
    paths: Any,
) -> bool:
    """Compute the velocities that motors shall have at the end of a step.

    Args:
        moving: whether any path has not arrived.
        times_s: the physics step, and the time constants of the approach to a target, of the return to a
            path and of the learning of an error.
        largest: the largest error that is learnt.
        positions: of the joints now, shape ``(n,)``; they become those that the learnt errors suggest.
        velocities: of the joints now, shape ``(n,)``; needed while a path moves.
        learnt: the learnt errors, shape ``(n,)``.
        paths: the paths, of the type :data:`~nrp_core.world.engine_kit.firm_kinds.PATHS`.

    Returns:
        Whether any path has not arrived after the step.
    """
    step_s = times_s[0]
    if moving:
        moving = advance(step_s, times_s[1], positions, velocities, paths)
    for i in range(len(paths)):
        error = learnt[i] + (paths[i].path - positions[i]) * step_s / times_s[3]
        learnt[i] = min(max(error, -largest), largest) if paths[i].kind == POSITION else 0.0
        positions[i] -= learnt[i]
    velocities_to(step_s, times_s[2], positions, paths)
    return moving
