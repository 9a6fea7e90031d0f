"""``tf.transformations``: the functions that experiments call; quaternions are x, y, z, w."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from nrp_core.scene.rigid import multiply
from nrp_core.world import Pose
from nrp_legacy.shims.modules import module

Array: TypeAlias = npt.NDArray[np.float64]

_FIXED_AXES = "sxyz"
_ORIGIN = (0.0, 0.0, 0.0)


def _sequence(axes: str) -> str:
    """Return axes as SciPy names them: ``sxyz`` are fixed ones, ``rzyx`` turn with the body."""
    return axes[1:] if axes.startswith("s") else axes[1:].upper()


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = _FIXED_AXES) -> Array:
    """Return the quaternion of roll, pitch and yaw."""
    if axes == _FIXED_AXES:
        return np.array(Pose.from_rpy(_ORIGIN, ai, aj, ak).orientation)
    quaternion: Array = _rotation().from_euler(_sequence(axes), [ai, aj, ak]).as_quat()
    return quaternion


def euler_from_quaternion(quaternion: Sequence[float], axes: str = _FIXED_AXES) -> tuple[float, ...]:
    """Return roll, pitch and yaw of a quaternion."""
    if axes != _FIXED_AXES:
        return tuple(_rotation().from_quat(quaternion).as_euler(_sequence(axes)).tolist())
    x, y, z, w = _unit(quaternion)
    return Pose(_ORIGIN, (x, y, z, w)).rpy


def quaternion_multiply(q1: Sequence[float], q0: Sequence[float]) -> Array:
    """Return the product of quaternions ``q0 * q1``."""
    (ax, ay, az, aw), (bx, by, bz, bw) = q1, q0
    return np.array(multiply((ax, ay, az, aw), (bx, by, bz, bw)))


def quaternion_conjugate(quaternion: Sequence[float]) -> Array:
    """Return the conjugate of a quaternion."""
    return np.array(quaternion) * (-1, -1, -1, 1)


def quaternion_inverse(quaternion: Sequence[float]) -> Array:
    """Return the inverse of a quaternion."""
    inverse: Array = quaternion_conjugate(quaternion) / np.dot(quaternion, quaternion)
    return inverse


def quaternion_matrix(quaternion: Sequence[float]) -> Array:
    """Return the homogeneous matrix of a quaternion, shape ``(4, 4)``."""
    x, y, z, w = _unit(quaternion)
    pose = Pose(_ORIGIN, (x, y, z, w))
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([pose.rotate(axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]).T
    return matrix


def euler_matrix(ai: float, aj: float, ak: float, axes: str = _FIXED_AXES) -> Array:
    """Return the homogeneous matrix of roll, pitch and yaw, shape ``(4, 4)``."""
    return quaternion_matrix(list(quaternion_from_euler(ai, aj, ak, axes)))


def translation_matrix(direction: Sequence[float]) -> Array:
    """Return the homogeneous matrix of a translation, shape ``(4, 4)``."""
    matrix = np.eye(4)
    matrix[:3, 3] = direction[:3]
    return matrix


def quaternion_about_axis(angle: float, axis: Sequence[float]) -> Array:
    """Return the quaternion of a rotation about an axis."""
    quaternion: Array = _rotation().from_rotvec(angle * unit_vector(axis)).as_quat()
    return quaternion


def rotation_matrix(angle: float, direction: Sequence[float], point: Any = None) -> Array:
    """Return the homogeneous matrix of a rotation about an axis through a point, shape ``(4, 4)``."""
    matrix = quaternion_matrix(quaternion_about_axis(angle, direction).tolist())
    if point is not None:
        matrix[:3, 3] = np.asarray(point[:3]) - matrix[:3, :3] @ np.asarray(point[:3])
    return matrix


def quaternion_from_matrix(matrix: Any) -> Array:
    """Return the quaternion of a homogeneous matrix."""
    quaternion: Array = _rotation().from_matrix(np.asarray(matrix)[:3, :3]).as_quat()
    return quaternion


def euler_from_matrix(matrix: Any, axes: str = _FIXED_AXES) -> tuple[float, ...]:
    """Return the angles of a homogeneous matrix."""
    return euler_from_quaternion(quaternion_from_matrix(matrix).tolist(), axes)


def translation_from_matrix(matrix: Any) -> Array:
    """Return the translation in a homogeneous matrix."""
    return np.array(matrix, dtype=float)[:3, 3]


def concatenate_matrices(*matrices: Any) -> Array:
    """Return the product of homogeneous matrices."""
    product = np.eye(4)
    for matrix in matrices:
        product = product @ np.asarray(matrix)
    return product


def compose_matrix(
    scale: Sequence[float] | None = None,
    shear: Sequence[float] | None = None,
    angles: Sequence[float] | None = None,
    translate: Sequence[float] | None = None,
    perspective: Sequence[float] | None = None,
) -> Array:
    """Return the matrix that scales, shears (xy, xz, yz), rotates, translates and projects, in this order."""
    scaled = np.diag([*((1.0, 1.0, 1.0) if scale is None else scale), 1.0])
    sheared, projected = np.eye(4), np.eye(4)
    sheared[[0, 0, 1], [1, 2, 2]] = 0.0 if shear is None else shear
    projected[3] = projected[3] if perspective is None else perspective
    roll, pitch, yaw = _ORIGIN if angles is None else angles
    place = _ORIGIN if translate is None else translate
    moved, turned = translation_matrix(place), euler_matrix(roll, pitch, yaw)
    matrix = concatenate_matrices(projected, moved, turned, sheared, scaled)
    matrix /= matrix[3, 3]
    return matrix


def quaternion_slerp(quat0: Sequence[float], quat1: Sequence[float], fraction: float) -> Array:
    """Return a quaternion between two, on the shorter way."""
    from scipy.spatial.transform import Slerp

    between: Array = Slerp([0.0, 1.0], _rotation().from_quat([quat0, quat1]))(fraction).as_quat()
    return between


def unit_vector(data: Sequence[float], axis: int | None = None) -> Array:
    """Return a vector of length 1, or several along an axis."""
    values = np.asarray(data, dtype=float)
    unit: Array = values / np.linalg.norm(values, axis=axis, keepdims=axis is not None)
    return unit


def _rotation() -> Any:
    from scipy.spatial.transform import Rotation

    return Rotation


def _unit(quaternion: Sequence[float]) -> list[float]:
    values: list[float] = unit_vector(quaternion).tolist()
    return values


class LookupException(Exception):  # noqa: N818 - the name that users catch
    """This frame is not published."""


class TransformListener:
    """A listener without frames, because none are published."""

    def __init__(self, *_values: Any, **_fields: Any) -> None:
        """Do nothing."""

    def __getattr__(self, name: str) -> Any:
        def refuse(*_values: Any, **_fields: Any) -> None:
            raise LookupException(f"{name}: frames are not published")

        return refuse


class TransformBroadcaster:
    """A broadcaster without effect."""

    def sendTransform(self, *_values: Any, **_fields: Any) -> None:  # noqa: N802 - its name
        """Do nothing."""


def tf_module() -> ModuleType:
    """Return ``tf``."""
    errors = ("LookupException", "ConnectivityException", "ExtrapolationException", "Exception")
    return module(
        "tf", TransformListener=TransformListener, TransformBroadcaster=TransformBroadcaster,
        **dict.fromkeys(errors, LookupException),
    )  # fmt: skip


def transformations_module() -> ModuleType:
    """Return the module."""
    functions: dict[str, Any] = {
        function.__name__: function
        for function in (
            quaternion_from_euler, euler_from_quaternion, quaternion_multiply, quaternion_conjugate,
            quaternion_inverse, quaternion_matrix, euler_matrix, translation_matrix, unit_vector,
            quaternion_about_axis, rotation_matrix, quaternion_from_matrix, euler_from_matrix,
            translation_from_matrix, concatenate_matrices, compose_matrix, quaternion_slerp,
        )
    }  # fmt: skip
    plain = {
        "inverse_matrix": np.linalg.inv,
        "vector_norm": np.linalg.norm,
        "identity_matrix": partial(np.eye, 4),
    }
    return module("transformations", **functions, **plain)
