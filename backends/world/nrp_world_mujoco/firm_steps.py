"""Physics steps with firm joints, all steps in one compiled call."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core._support.memory import address_at, call, integer_at, number_at, put_number
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.firm_paths import advance, velocities_to

_FIELDS = [
    ("position", np.int64),  # the addresses of its position,
    ("velocity", np.int64),  # its velocity
    ("guess", np.int64),  # and the acceleration with which the solver begins
    ("row", np.int64),  # its constraint, among those of dry friction; meaningless without a target
    ("effort", np.float64),  # in the last step, 0 without a target
]
LED: Final = np.dtype((np.record, _FIELDS))
"""A firm joint in MuJoCo's state."""
_NUMBER = 8
"""Size of a double, bytes."""


@jit
def lead(moving: bool, times_s: FloatArray, state: IntArray, joints: Any, paths: Any) -> bool:
    """Write the wanted velocities into the constraints between the two halves of a step.

    Args:
        moving: whether any path has not arrived.
        times_s: the physics step, and the time constants of the approach to a target and of the return to a
            path.
        state: the addresses of :class:`~.state_layout.StateLayout`.
        joints: the joints, of the type :data:`LED`, shape ``(n,)``.
        paths: their paths, of the type :data:`~nrp_core.world.engine_kit.firm_kinds.PATHS`.

    Returns:
        Whether any path has not arrived after the step.
    """
    positions, velocities = np.empty(len(joints)), np.empty(len(joints))
    for i in range(len(joints)):
        positions[i], velocities[i] = number_at(joints[i].position), number_at(joints[i].velocity)
    if moving:
        moving = advance(times_s[0], times_s[1], positions, velocities, paths)
    velocities_to(times_s[0], times_s[2], positions, paths)
    couplings, frictions = integer_at(state[0]), integer_at(state[1])
    rates, references = address_at(state[2]), address_at(state[3])
    for i in range(len(joints)):
        if paths[i].kind != FREE and joints[i].row < frictions:
            row = couplings + joints[i].row
            reference = references + _NUMBER * row
            rate = number_at(rates + _NUMBER * (4 * row + 1))  # at which it takes its velocity to 0
            acceleration = number_at(reference) + rate * paths[i].wanted
            put_number(reference, acceleration)
            put_number(joints[i].guess, acceleration)  # right, unless the force is at its bound
    return moving


@jit
def take_steps(
    steps: int, calls: IntArray, moving: bool, times_s: FloatArray, state: IntArray, joints: Any, paths: Any
) -> bool:
    """Take steps, and read the efforts of the last one.

    Args:
        steps: the number of steps.
        calls: the addresses of both halves of MuJoCo's step, of the model and of the state.
        moving: as for :func:`lead`.
        times_s: as there.
        state: as there.
        joints: as there.
        paths: as there.
    """
    first_half, second_half, model, data = calls
    for _ in range(steps):
        call(first_half, model, data)
        moving = lead(moving, times_s, state, joints, paths)
        call(second_half, model, data)
    couplings, frictions, forces = integer_at(state[0]), integer_at(state[1]), address_at(state[4])
    for i in range(len(joints)):
        acts = paths[i].kind != FREE and joints[i].row < frictions
        joints[i].effort = number_at(forces + _NUMBER * (couplings + joints[i].row)) if acts else 0.0
    return moving
