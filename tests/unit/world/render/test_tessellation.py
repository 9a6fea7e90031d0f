"""Shapes as triangles."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from nrp_core.scene.tessellation import triangles_of

TETRAHEDRON = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the volume that triangles enclose; negative where they are seen from inside."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def is_closed(faces: np.ndarray, vertices: np.ndarray) -> bool:
    """Return whether every edge is passed once in each direction."""
    points = [tuple(np.round(vertex, 9)) for vertex in vertices]
    edges = [(points[f[i]], points[f[(i + 1) % 3]]) for f in faces for i in range(3)]
    edges = [(a, b) for a, b in edges if a != b]
    return sorted(edges) == sorted((b, a) for a, b in edges)


@pytest.mark.parametrize(
    ("shape", "exact"),
    [
        (Box((1.0, 2.0, 3.0)), 6.0),
        (Sphere(0.5), pi / 6),
        (Cylinder(0.5, 2.0), pi / 2),
        (Capsule(0.5, 2.0), pi / 2 + pi / 6),
    ],
)
def test_a_solid_is_closed_seen_from_outside_and_of_its_volume(shape, exact):
    vertices, faces = triangles_of(shape)
    assert is_closed(faces, vertices)
    assert volume(vertices, faces) == pytest.approx(exact, rel=0.02)


def test_a_plane_is_seen_from_above():
    vertices, faces = triangles_of(Plane((2.0, 4.0)))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert np.ptp(vertices, axis=0).tolist() == [2.0, 4.0, 0.0]


@pytest.mark.parametrize("scale", [(2.0, 1.0, 1.0), (-1.0, 2.0, 1.0)])
def test_a_scaled_or_mirrored_mesh_is_still_seen_from_outside(tmp_path, scale):
    path = tmp_path / "thing.stl"
    write_stl(path, np.array(TETRAHEDRON, float)[list(map(list, FACES))])
    vertices, faces = triangles_of(Mesh(path, scale))
    assert len(vertices) == 4
    assert volume(vertices, faces) == pytest.approx(2 / 6)
