"""Masses and inertias: their sums, those of shapes, and the repair of impossible ones."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import numpy.typing as npt

from nrp_core._support.small_matrices import length, principal_axes, product
from nrp_core.scene.meshes.shapes import kind_of_solid
from nrp_core.scene.meshes.stl import read_stl
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.model import Box, Capsule, Collision, Cylinder, Geometry, Inertial, Mesh, Sphere
from nrp_core.scene.rigid import Pose, Quaternion, Vector, rotation_matrix

Matrix = npt.NDArray[np.float64]


def sum_inertials(inertials: Iterable[Inertial]) -> Inertial | None:
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
    centre = product(masses, centres) / mass
    tensor = np.zeros((3, 3))
    for part, at in zip(parts, centres, strict=True):
        tensor += inertia_tensor(part) + part.mass * _point_inertia(at - centre)
    moments, axes = _principal_axes(tensor)
    pose = Pose((float(centre[0]), float(centre[1]), float(centre[2])), axes)
    return Inertial(float(mass), pose, (*moments, 0.0, 0.0, 0.0))


def inertia_tensor(inertial: Inertial) -> Matrix:
    """Return the inertia about the centre of mass along the axes of the frame the pose is given in."""
    xx, yy, zz, xy, xz, yz = inertial.inertia
    rotation = rotation_matrix(inertial.pose.orientation)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    turned: Matrix = product(product(rotation, tensor), rotation.T)
    return turned


def _point_inertia(offset: Matrix) -> Matrix:
    about: Matrix = product(offset, offset) * np.eye(3) - np.outer(offset, offset)
    return about


def _principal_axes(tensor: Matrix) -> tuple[tuple[float, float, float], Quaternion]:
    """Return the principal moments and the orientation of their axes."""
    off_diagonal = np.abs(tensor - np.diag(np.diag(tensor))).max()
    if off_diagonal <= 1e-12 * np.abs(tensor).max():  # keep the axes of the file if they are principal
        moments, axes = np.diag(tensor), np.eye(3)
    else:
        moments, axes = principal_axes(tensor)
        axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])  # a rotation, not a reflection
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
    x, y, z, w = (float(component) for component in row / length(row))
    return x, y, z, w


def solid_of(triangles: Triangles, density: float) -> Inertial | None:
    """Return the mass properties; None if the surface does not enclose a volume."""
    a, b, c = triangles.swapaxes(0, 1)
    sixfold = np.einsum("ij,ij->i", a, np.cross(b, c))
    volume = float(sixfold.sum()) / 6
    extent = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    if abs(volume) <= 1e-12 * extent**3:
        return None
    middle = product(sixfold, a + b + c) / 24 / volume
    corners = np.stack([a, b, c, a + b + c], axis=1)
    spread = np.einsum("i,ijk,ijl->kl", sixfold, corners, corners) / 120 - volume * np.outer(middle, middle)
    scale = density * (1.0 if volume > 0 else -1.0)  # a mirrored surface is seen from inside
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (scale * spread).tolist()
    x, y, z = middle.tolist()
    return Inertial(density * abs(volume), Pose((x, y, z)), (yy + zz, xx + zz, xx + yy, -xy, -xz, -yz))


WATER = 1000.0
"""Default density of shapes, kg/m^3: that of the SDF specification."""

LEAST_MOMENT = 1e-14
"""Minimum moment of inertia, kg m^2: a milligram 0.1 mm across; MuJoCo refuses moments below 1e-15."""
_CUBE = 0.05  # relative difference of the moments of a body whose principal axes mean nothing
_MARGIN = 1e-3  # margin of a repair from the limit, for rounding in engines


def shape_inertia(geometry: Geometry, density: float = WATER) -> Inertial | None:
    """Return the mass properties of a homogeneous solid, in its frame; None for planes.

    A mesh is the solid that it bounds, but ellipsoids and cones are those without facets.

    Raises:
        SceneError: the file of a mesh cannot be used.
    """
    centre = Pose()
    match geometry:
        case Box((x, y, z)):
            mass = density * x * y * z
            moments = (mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y))
        case Sphere(r):
            mass = density * 4 / 3 * pi * r**3
            moments = (0.4 * mass * r * r,) * 3
        case Cylinder(r, length):
            mass = density * pi * r * r * length
            across = mass / 12 * (3 * r * r + length * length)
            moments = (across, across, mass / 2 * r * r)
        case Capsule(r, length):
            barrel, caps = density * pi * r * r * length, density * 4 / 3 * pi * r**3
            mass = barrel + caps
            across = barrel / 12 * (3 * r * r + length * length)
            across += caps * (0.4 * r * r + 0.375 * r * length + length * length / 4)
            moments = (across, across, barrel / 2 * r * r + 0.4 * caps * r * r)
        case Mesh(path, (x, y, z)) if kind_of_solid(path) == "ellipsoid":
            mass = density * 4 / 3 * pi * x * y * z
            moments = (mass / 5 * (y * y + z * z), mass / 5 * (x * x + z * z), mass / 5 * (x * x + y * y))
        case Mesh(path, (r, _, z)) if kind_of_solid(path) == "cone":
            mass, centre = density / 3 * pi * r * r * z, Pose((0.0, 0.0, -z / 4))
            across = 3 / 80 * mass * (4 * r * r + z * z)
            moments = (across, across, 0.3 * mass * r * r)
        case Mesh(path, scale):
            return solid_of(read_stl(path) * scale, density)
        case _:
            return None
    return Inertial(mass, centre, (*moments, 0.0, 0.0, 0.0))


def collision_inertia(collisions: Iterable[tuple[Collision, float]]) -> Inertial | None:
    """Return the mass properties of collision shapes with their densities; None where none is solid."""
    solids = [
        (collision.pose, shape_inertia(collision.geometry, density)) for collision, density in collisions
    ]
    return sum_inertials(replace(solid, pose=pose @ solid.pose) for pose, solid in solids if solid)


def like_shape(solid: Inertial, given: Inertial) -> Inertial:
    """Return the inertia of a solid's shape, scaled to a mass and moved to a centre of mass."""
    xx, yy, zz, xy, xz, yz = (moment * given.mass / solid.mass for moment in solid.inertia)
    return Inertial(given.mass, replace(solid.pose, position=given.pose.position), (xx, yy, zz, xy, xz, yz))


def equivalent_box(inertial: Inertial) -> tuple[Box, Pose]:
    """Return the homogeneous box with these mass properties, at least 1 mm thick, and its centre.

    The box of nearly equal moments has the axes of the file, because its principal axes are arbitrary.
    """
    principal = _principal(inertial)
    moments = principal.inertia[:3]
    is_cube = max(moments) - min(moments) < _CUBE * max(moments)
    pose = inertial.pose if is_cube else principal.pose
    x, y, z = (
        max(sqrt(max(6 / inertial.mass * (sum(moments) - 2 * moment), 0.0)), 1e-3) for moment in moments
    )
    return Box((x, y, z)), pose


def repair_inertia(inertial: Inertial) -> tuple[Inertial, str]:
    """Make an inertia physically possible: positive, and each moment at most the sum of the other two.

    Returns:
        The inertia, unchanged if it is valid; and the error, empty if it is valid.
    """
    principal = _principal(inertial)
    moments = principal.inertia[:3]
    listed = ", ".join(f"{moment:.3g}" for moment in moments)
    if min(moments) < LEAST_MOMENT:
        floor = max(_MARGIN * max(*moments, 1e-6 * inertial.mass), 2 * LEAST_MOMENT)
        raised = _balance(tuple(max(moment, floor) for moment in moments))
        wrong = f"its moments ({listed}) are not all {'large enough' if min(moments) > 0 else 'positive'}"
        return replace(principal, inertia=(*raised, 0.0, 0.0, 0.0)), wrong
    if 2 * max(moments) > sum(moments) * (1 + 1e-9):
        wrong = f"its moments ({listed}) break the triangle inequality, so no distribution of mass has them"
        return replace(principal, inertia=(*_balance(moments), 0.0, 0.0, 0.0)), wrong
    return inertial, ""


def _balance(moments: tuple[float, ...]) -> Vector:
    """Raise the two smaller of three moments, by the same amount, until their sum exceeds the largest."""
    largest = max(range(3), key=moments.__getitem__)
    lacking = max(2 * moments[largest] * (1 + _MARGIN) - sum(moments), 0.0)
    x, y, z = (moment if i == largest else moment + lacking / 2 for i, moment in enumerate(moments))
    return x, y, z


def _principal(inertial: Inertial) -> Inertial:
    principal = sum_inertials([inertial])
    assert principal is not None, "only bodies with mass have an inertia"
    return principal
