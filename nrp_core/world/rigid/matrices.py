"""Rotations and poses as matrices."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.rigid.pose import Pose, Quaternion


def rotation_matrix(orientation: Quaternion) -> FloatArray:
    """Return the rotation matrix of a quaternion."""
    pose = Pose(orientation=orientation)
    return np.array([pose.rotate(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]).T


def matrix_of(pose: Pose) -> FloatArray:
    """Return a pose as rotation and translation, shape ``(3, 4)``."""
    return np.column_stack([rotation_matrix(pose.orientation), pose.position])
