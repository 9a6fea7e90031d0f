"""The contacts of a step as touches of bodies at points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from nrp_core.scene.rigid import BodyPath, Touch
from nrp_core.world import FloatArray


def touches_in(
    results: Any, owners: Mapping[Any, BodyPath], fields: Mapping[Any, tuple[float, float]]
) -> Iterator[Touch]:
    """Yield the contacts of a step.

    Args:
        results: Drake's contact results.
        owners: model and body of each geometry.
        fields: extent (m) and modulus (Pa) of the pressure field of each geometry.
    """
    for number in range(results.num_point_pair_contacts()):
        info = results.point_pair_contact_info(number)
        pair = info.point_pair()
        bodies = owners[pair.id_A], owners[pair.id_B]
        yield _touch(bodies, info.contact_point(), pair.nhat_BA_W, float(pair.depth), -info.contact_force())
    for number in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(number)
        surface = info.contact_surface()
        pair = surface.id_M(), surface.id_N()
        areas = np.array([surface.area(face) for face in range(surface.num_faces())])
        normal = areas @ [surface.face_normal(face) for face in range(surface.num_faces())]  # out of N
        normal /= np.linalg.norm(normal) or 1.0
        force, torque = info.F_Ac_W().translational(), info.F_Ac_W().rotational()
        pressure = float(force.dot(normal)) / areas.sum()
        depth = sum(pressure / modulus * extent for extent, modulus in map(fields.__getitem__, pair))
        corners = _corners(surface)
        for corner, share in zip(
            corners, _shares(corners - surface.centroid(), normal, force, torque), strict=True
        ):
            yield _touch((owners[pair[0]], owners[pair[1]]), corner, normal, depth, share * force)


def _corners(surface: Any) -> FloatArray:
    """Return at most four points of a patch between which it lies, shape ``(n, 3)``."""
    mesh = surface.tri_mesh_W() if surface.is_triangle() else surface.poly_mesh_W()
    points = np.array([mesh.vertex(number) for number in range(mesh.num_vertices())])
    first = points[_farthest(points - surface.centroid())]
    second = points[_farthest(points - first)]
    along = (second - first) / (np.linalg.norm(second - first) or 1.0)
    beside = points - first - np.outer((points - first) @ along, along)
    third = points[_farthest(beside)]
    away = beside[_farthest(beside)]
    fourth = points[int(np.argmin(beside @ away))]
    return np.unique([first, second, third, fourth], axis=0)


def _farthest(arrows: FloatArray) -> int:
    return int(np.argmax((arrows * arrows).sum(axis=1)))


def _shares(arms: FloatArray, normal: FloatArray, force: FloatArray, torque: FloatArray) -> FloatArray:
    """Return the shares of a force that points carry, so that they have its torque about axes in the patch.

    Args:
        arms: the points from the place of the force, shape ``(n, 3)``.
        normal: of the patch.
        force: on the body, N.
        torque: on the body, N m.
    """
    turns = np.cross(arms, force) - np.outer(np.cross(arms, force) @ normal, normal)
    rows = np.vstack([np.ones(len(arms)), turns.T])
    wanted = np.concatenate([[1.0], torque - torque.dot(normal) * normal])
    even = np.full(len(arms), 1.0 / len(arms))
    change: FloatArray = np.linalg.lstsq(rows, wanted - rows @ even, rcond=1e-9)[0]
    return even + change


def _touch(
    bodies: tuple[BodyPath, BodyPath], at: FloatArray, normal: FloatArray, depth: float, force: FloatArray
) -> Touch:
    (x, y, z), (nx, ny, nz), (fx, fy, fz) = at.tolist(), normal.tolist(), force.tolist()
    return Touch(bodies, (x, y, z), (nx, ny, nz), depth, (fx, fy, fz))
