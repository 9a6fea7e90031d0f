"""The number of iterations that PyBullet's solver needs for the motors of a chain of joints.

It takes one motor after the other (the Gauss-Seidel method), so each iteration leaves a share of the errors
of the velocities. It is small for most robots, and close to 1 where a light joint turns nearly as a heavy one
does, as at the wrists of many arms. The number is even: PyBullet goes through the constraints forward and
backward in turn, and after an odd one couplings of joints have the last word, and not the motors.
"""

from __future__ import annotations

from math import ceil, log
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray

USUAL: Final = 50
"""PyBullet's own number of iterations."""
_MOST: Final = 500
_LEFT: Final = 1e-6
"""The share of an error of a velocity that may be left after a step."""


def iterations_for(inertia: FloatArray) -> int:
    """Return the number of iterations for motors of joints.

    Args:
        inertia: the joint-space inertia that the motors move, ``(n, n)``.
    """
    try:
        coupling = np.linalg.inv(inertia)
        lower = np.tril(coupling)
        left = np.abs(np.linalg.eigvals(np.linalg.solve(lower, lower - coupling))).max()
    except np.linalg.LinAlgError:  # links without inertia
        return USUAL
    if not 0.0 < left < 1.0:
        return USUAL
    return min(max(USUAL, 2 * ceil(log(_LEFT) / log(left) / 2)), _MOST)
