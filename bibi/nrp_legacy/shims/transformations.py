"""``tf.transformations``: the functions that experiments call; quaternions are x, y, z, w."""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.pose import Pose, multiply
from nrp_legacy.shims.modules import module

_FIXED_AXES = "sxyz"
_ORIGIN = (0.0, 0.0, 0.0)


def _require_fixed_axes(axes: str) -> None:
    if axes != _FIXED_AXES:
        raise NotImplementedError(f"angles are about the fixed axes, '{_FIXED_AXES}', not '{axes}'")


def quaternion_from_euler(
    ai: float, aj: float, ak: float, axes: str = _FIXED_AXES
) -> npt.NDArray[np.float64]:
    """Return the quaternion of roll, pitch and yaw."""
    _require_fixed_axes(axes)
    return np.array(Pose.from_rpy(_ORIGIN, ai, aj, ak).orientation)


def euler_from_quaternion(quaternion: Sequence[float], axes: str = _FIXED_AXES) -> tuple[float, ...]:
    """Return roll, pitch and yaw of a quaternion."""
    _require_fixed_axes(axes)
    x, y, z, w = _unit(quaternion)
    return Pose(_ORIGIN, (x, y, z, w)).rpy


def quaternion_multiply(q1: Sequence[float], q0: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return the turn that is ``q0`` followed by ``q1``."""
    (ax, ay, az, aw), (bx, by, bz, bw) = q1, q0
    return np.array(multiply((ax, ay, az, aw), (bx, by, bz, bw)))


def quaternion_conjugate(quaternion: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return the turn back of a unit quaternion."""
    return np.array(quaternion) * (-1, -1, -1, 1)


def quaternion_inverse(quaternion: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return the inverse of a quaternion."""
    inverse: npt.NDArray[np.float64] = quaternion_conjugate(quaternion) / np.dot(quaternion, quaternion)
    return inverse


def quaternion_matrix(quaternion: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return the homogeneous matrix of a quaternion, shape ``(4, 4)``."""
    x, y, z, w = _unit(quaternion)
    pose = Pose(_ORIGIN, (x, y, z, w))
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([pose.rotate(axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]).T
    return matrix


def euler_matrix(ai: float, aj: float, ak: float, axes: str = _FIXED_AXES) -> npt.NDArray[np.float64]:
    """Return the homogeneous matrix of roll, pitch and yaw, shape ``(4, 4)``."""
    return quaternion_matrix(list(quaternion_from_euler(ai, aj, ak, axes)))


def translation_matrix(direction: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return the homogeneous matrix of a shift, shape ``(4, 4)``."""
    matrix = np.eye(4)
    matrix[:3, 3] = direction[:3]
    return matrix


def unit_vector(data: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return a vector of length 1."""
    unit: npt.NDArray[np.float64] = np.asarray(data, dtype=float) / np.linalg.norm(data)
    return unit


def _unit(quaternion: Sequence[float]) -> list[float]:
    values: list[float] = unit_vector(quaternion).tolist()
    return values


def transformations_module() -> ModuleType:
    """Return the module."""
    functions: dict[str, Any] = {
        function.__name__: function
        for function in (
            quaternion_from_euler, euler_from_quaternion, quaternion_multiply, quaternion_conjugate,
            quaternion_inverse, quaternion_matrix, euler_matrix, translation_matrix, unit_vector,
        )
    }  # fmt: skip
    return module("transformations", **functions)
