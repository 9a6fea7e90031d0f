"""What a firm joint follows, and the state of its path."""

from __future__ import annotations

from typing import Final

import numpy as np

FREE, VELOCITY, POSITION = 0, 1, 2
"""Nothing, a velocity or a position."""

_FIELDS = [
    ("kind", np.int64),  # what the joint follows
    ("smooth", np.int64),  # whether its path is not given by points
    ("fresh", np.int64),  # whether its path begins now
    ("target", np.float64),
    ("rate", np.float64),  # the speed at the target, if the path is given by points
    ("path", np.float64),  # the position of the path at the end of the next step
    ("speed", np.float64),  # its velocity then
    ("wanted", np.float64),  # the velocity that takes the joint to it
    ("braking", np.float64),  # the acceleration with which the joint can brake
    ("limit", np.float64),  # its largest speed
    ("lowest", np.float64),  # the ends of its range
    ("highest", np.float64),
]
PATHS: Final = np.dtype((np.record, _FIELDS))
"""The path of a joint, in rad or m and s."""
