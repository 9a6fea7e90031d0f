"""``tf.transformations``: the module, and its matrices beyond those of rotations."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from nrp_legacy.shims.modules import module
from nrp_legacy.shims.transformations import (
    concatenate_matrices,
    euler_from_matrix,
    euler_from_quaternion,
    euler_matrix,
    quaternion_about_axis,
    quaternion_conjugate,
    quaternion_from_euler,
    quaternion_from_matrix,
    quaternion_inverse,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
    rotation_matrix,
    translation_from_matrix,
    translation_matrix,
    unit_vector,
)

Array: TypeAlias = npt.NDArray[np.float64]
Vector: TypeAlias = Sequence[float]

_SHEARED = ((0, 0, 1), (1, 2, 2))
"""Rows and columns of the shear of x and y, x and z, and y and z."""


def compose_matrix(
    scale: Vector | None = None,
    shear: Vector | None = None,
    angles: Vector | None = None,
    translate: Vector | None = None,
    perspective: Vector | None = None,
) -> Array:
    """Return the matrix that scales, shears, rotates, translates and projects, in this order."""
    matrix: Array = np.eye(4)
    if perspective is not None:
        matrix[3] = perspective[:4]
    if translate is not None:
        matrix = matrix @ translation_matrix(translate)
    if angles is not None:
        matrix = matrix @ euler_matrix(angles[0], angles[1], angles[2])
    if shear is not None:
        sheared = np.eye(4)
        sheared[_SHEARED] = shear
        matrix = matrix @ sheared
    if scale is not None:
        matrix = matrix @ np.diag([*scale[:3], 1.0])
    matrix /= matrix[3, 3]
    return matrix


def decompose_matrix(matrix: Any) -> tuple[Array, list[float], tuple[float, ...], Array, Array]:
    """Return scale, shear, angles, translation and perspective of a matrix."""
    whole: Array = np.array(matrix, dtype=float)
    whole /= whole[3, 3]
    affine = whole.copy()
    affine[3] = 0.0, 0.0, 0.0, 1.0
    turned, upper = np.linalg.qr(affine[:3, :3])
    signs = np.sign(np.diag(upper))
    turned, upper = turned * signs, upper * signs[:, None]
    if np.linalg.det(turned) < 0:
        turned, upper = -turned, -upper
    scale: Array = np.diag(upper).copy()
    shear: list[float] = (upper / scale)[_SHEARED].tolist()
    return scale, shear, euler_from_matrix(turned), affine[:3, 3], whole[3] @ np.linalg.inv(affine)


def scale_matrix(factor: float, origin: Vector | None = None, direction: Vector | None = None) -> Array:
    """Return the matrix that scales from a point, in all directions or in one."""
    matrix: Array = np.eye(4)
    along = np.eye(3) if direction is None else np.outer(*(unit_vector(direction[:3]),) * 2)
    matrix[:3, :3] += (factor - 1) * along
    if origin is not None:
        matrix[:3, 3] = (1 - factor) * along @ np.asarray(origin[:3])
    return matrix


def reflection_matrix(point: Vector, normal: Vector) -> Array:
    """Return the matrix that reflects at a plane."""
    return scale_matrix(-1.0, point, normal)


def rotation_from_matrix(matrix: Any) -> tuple[float, Array, Array]:
    """Return angle, axis, and a point on the axis, of a rotation."""
    whole: Array = np.asarray(matrix, dtype=float)
    x, y, z, w = quaternion_from_matrix(whole)
    sine = float(np.linalg.norm((x, y, z)))
    axis = np.array((x, y, z)) / sine if sine else np.array((0.0, 0.0, 1.0))
    point = np.linalg.lstsq(np.eye(3) - whole[:3, :3], whole[:3, 3], rcond=None)[0]
    return 2 * float(np.arctan2(sine, w)), axis, np.append(point, 1.0)


def is_same_transform(matrix0: Any, matrix1: Any) -> bool:
    """Return whether two matrices do the same."""
    one, other = (np.array(each, dtype=float) for each in (matrix0, matrix1))
    return bool(np.allclose(one / one[3, 3], other / other[3, 3]))


def transformations_module() -> ModuleType:
    """Return the module."""
    functions: dict[str, Any] = {
        function.__name__: function
        for function in (
            quaternion_from_euler, euler_from_quaternion, quaternion_multiply, quaternion_conjugate,
            quaternion_inverse, quaternion_matrix, euler_matrix, translation_matrix, unit_vector,
            quaternion_about_axis, rotation_matrix, quaternion_from_matrix, euler_from_matrix,
            translation_from_matrix, concatenate_matrices, quaternion_slerp, compose_matrix,
            decompose_matrix, scale_matrix, reflection_matrix, rotation_from_matrix, is_same_transform,
        )
    }  # fmt: skip
    plain = {
        "inverse_matrix": np.linalg.inv,
        "vector_norm": np.linalg.norm,
        "identity_matrix": partial(np.eye, 4),
    }
    return module("transformations", **functions, **plain)
