"""Shapes and mesh files as triangles."""

from __future__ import annotations

import struct
from math import pi

import numpy as np
import pytest

from nrp_core.errors import SceneError
from nrp_core.world.render.mesh_files import read_mesh
from nrp_core.world.render.tessellation import triangles_of
from nrp_core.world.scene.model import Box, Capsule, Cylinder, Mesh, Plane, Sphere

TETRAHEDRON = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the volume that triangles enclose; negative where they are seen from inside."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def is_closed(faces: np.ndarray, vertices: np.ndarray) -> bool:
    """Tell whether every edge is passed once in each direction."""
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


def obj() -> bytes:
    rows = [f"v {x} {y} {z}" for x, y, z in TETRAHEDRON] + ["vn 0 0 1", "# a comment", ""]
    rows += ["f 1/1/1 3/1/1 2/1/1", "f 1//1 2//1 4//1", "f -4 -1 -2", "f 2 3 4"]
    return "\n".join(rows).encode()


def binary_stl() -> bytes:
    rows = [struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in TETRAHEDRON[i]), 0) for face in FACES]
    return b"solid that begins like text".ljust(80) + struct.pack("<I", 4) + b"".join(rows)


def text_stl() -> bytes:
    corners = (["outer loop", *("vertex {} {} {}".format(*TETRAHEDRON[i]) for i in face)] for face in FACES)
    return "\n".join(["solid thing", *(row for face in corners for row in face), "endsolid"]).encode()


@pytest.mark.parametrize(
    ("name", "content"), [("a.obj", obj()), ("b.stl", binary_stl()), ("c.STL", text_stl())]
)
def test_a_mesh_file_is_read(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    vertices, faces = read_mesh(path)
    assert volume(vertices, faces) == pytest.approx(1 / 6)
    assert is_closed(faces, vertices)


def test_a_polygon_is_split_into_triangles(tmp_path):
    path = tmp_path / "square.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    assert read_mesh(path)[1].tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize("scale", [(2.0, 1.0, 1.0), (-1.0, 2.0, 1.0)])
def test_a_scaled_or_mirrored_mesh_is_still_seen_from_outside(tmp_path, scale):
    path = tmp_path / "thing.stl"
    path.write_bytes(binary_stl())
    assert volume(*triangles_of(Mesh(path, scale))) == pytest.approx(2 / 6)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.stl", b"solid nothing\nendsolid", "no triangles"),
        ("b.stl", b"\xff\xfe not a mesh", "cannot be read"),
        ("c.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 3\n", "names a vertex that is not there"),
        ("d.obj", b"v 0 0 zero\n", "cannot be read"),
        ("e.obj", b"", "no triangles"),
    ],
)
def test_a_mesh_that_cannot_be_used_is_refused_with_its_file(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(SceneError, match=message) as caught:
        read_mesh(path)
    assert caught.value.path == path


def test_a_mesh_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(SceneError, match="cannot be read"):
        read_mesh(tmp_path / "missing.stl")
