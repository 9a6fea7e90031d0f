"""Combined masses: parallel axes and principal axes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from nrp_core.world.rigid.matrices import rotation_matrix
from nrp_core.world.rigid.pose import Pose, Quaternion
from nrp_core.world.scene.model import Inertial

Matrix = npt.NDArray[np.float64]


def combined(inertials: Iterable[Inertial]) -> Inertial | None:
    """Return the inertial of rigidly joined masses, all given in one frame.

    Returns:
        Mass, centre of mass and inertia about the principal axes (the products of inertia are 0), or None if
        nothing has mass.
    """
    parts = [part for part in inertials if part.mass > 0]
    if not parts:
        return None
    masses = np.array([part.mass for part in parts])
    centres = np.array([part.pose.position for part in parts])
    mass = masses.sum()
    centre = masses @ centres / mass
    tensor = np.zeros((3, 3))
    for part, at in zip(parts, centres, strict=True):
        tensor += turned(part) + part.mass * _point_inertia(at - centre)
    moments, axes = _principal(tensor)
    pose = Pose((float(centre[0]), float(centre[1]), float(centre[2])), axes)
    return Inertial(float(mass), pose, (*moments, 0.0, 0.0, 0.0))


def turned(inertial: Inertial) -> Matrix:
    """Return the inertia about the centre of mass along the axes of the frame the pose is given in."""
    xx, yy, zz, xy, xz, yz = inertial.inertia
    rotation = rotation_matrix(inertial.pose.orientation)
    tensor: Matrix = rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ rotation.T
    return tensor


def _point_inertia(offset: Matrix) -> Matrix:
    return offset @ offset * np.eye(3) - np.outer(offset, offset)


def _principal(tensor: Matrix) -> tuple[tuple[float, float, float], Quaternion]:
    """Return the principal moments and the orientation of their axes."""
    off_diagonal = np.abs(tensor - np.diag(np.diag(tensor))).max()
    if off_diagonal <= 1e-12 * np.abs(tensor).max():  # keep the axes of the file if they are principal
        moments, axes = np.diag(tensor), np.eye(3)
    else:
        moments, axes = np.linalg.eigh(tensor)
        axes[:, 2] *= np.sign(np.linalg.det(axes))  # a rotation, not a reflection
    x, y, z = (float(moment) for moment in moments)
    return (x, y, z), _quaternion(axes)


def _quaternion(rotation: Matrix) -> Quaternion:
    """Return a rotation matrix as a quaternion, by its largest component (Shepperd 1978)."""
    m = rotation
    # squares of the components x, y, z, w, times 4
    squares = 1 + np.array([
        m[0, 0] - m[1, 1] - m[2, 2],
        m[1, 1] - m[0, 0] - m[2, 2],
        m[2, 2] - m[0, 0] - m[1, 1],
        m[0, 0] + m[1, 1] + m[2, 2],
    ])  # fmt: skip
    # row i: the products of component i with x, y, z, w, times 4
    products = np.array([
        [squares[0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
        [m[0, 1] + m[1, 0], squares[1], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
        [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[2], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]],
    ])  # fmt: skip
    row = products[int(squares.argmax())]
    x, y, z, w = (float(component) for component in row / np.linalg.norm(row))
    return x, y, z, w
