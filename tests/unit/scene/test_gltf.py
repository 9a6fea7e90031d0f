"""Meshes in glTF: where their corners are, how they look, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from square_gltf import CORNERS, GREEN, ORDER, binary_file, document, text_file

from nrp_core.errors import SceneError
from nrp_core.scene.meshes import mesh_pieces
from nrp_core.scene.meshes.convert import Wanted
from nrp_core.scene.meshes.stl import read_coordinates, read_stl


@pytest.mark.parametrize(("name", "data"), [("a.gltf", text_file({})), ("a.glb", binary_file({}))])
def test_a_square_has_its_corners_its_places_and_the_image_inside_of_the_file(
    tmp_path: Path, name: str, data: bytes
) -> None:
    (tmp_path / name).write_bytes(data)
    (piece,) = mesh_pieces(tmp_path / name, Wanted("colored"))
    triangles, places = read_stl(piece.path), read_coordinates(piece.path)
    assert (triangles == CORNERS[ORDER].reshape(-1, 3, 3)).all()
    assert places == pytest.approx(triangles[..., [0, 2]] / (2, 1))  # from the lower left
    assert piece.rgba == pytest.approx((0, 1, 0, 1))
    assert piece.image is not None
    assert piece.image.read_bytes() == GREEN


def test_a_node_is_where_it_is_turned_and_scaled_to(tmp_path: Path) -> None:
    half = 0.5**0.5
    turned = {"translation": [1, 2, 3], "rotation": [0, 0, half, half], "scale": [1, 1, -3]}
    below = {"nodes": [{"children": [1], "translation": [10, 0, 0]}, {"mesh": 0} | turned]}
    (tmp_path / "a.gltf").write_bytes(text_file({}, **below))
    (piece,) = mesh_pieces(tmp_path / "a.gltf", Wanted("whole"))
    triangles = read_stl(piece.path)
    assert set(map(tuple, triangles.reshape(-1, 3).round(5).tolist())) == {
        (11, 2, 3), (11, 4, 3), (11, 4, 0), (11, 2, 0),
    }  # fmt: skip
    a, b, c = triangles[0]
    assert np.cross(b - a, c - a)[0] > 0  # a mirrored face still shows the side that it showed, turned to x


@pytest.mark.parametrize(("order", "mode"), [([0, 1, 3, 2], 5), ([0, 1, 2, 3], 6)])
def test_strips_and_fans_are_triangles_that_face_the_same_way(
    tmp_path: Path, order: list[int], mode: int
) -> None:
    (tmp_path / "a.gltf").write_bytes(text_file({}, order=np.array(order, "<u2"), mode=mode))
    (piece,) = mesh_pieces(tmp_path / "a.gltf", Wanted("whole"))
    a, b, c = read_stl(piece.path).swapaxes(0, 1)
    areas = np.cross(b - a, c - a) / 2
    assert areas == pytest.approx(np.array([(0, -1, 0), (0, -1, 0)]))


@pytest.mark.parametrize(
    "data",
    [
        text_file({}, extensionsRequired=["KHR_draco_mesh_compression"]),
        text_file({}).replace(b'"count": 4', b'"count": 4000'),
        text_file({})[:200],
        json.dumps(document({})[0] | {"buffers": [{"uri": "a.bin"}]}).encode(),
        text_file({}).replace(b'"mesh": 0', b'"mesh": 7'),
        text_file({"children": [0, 0]}),
        text_file({"scale": [0, 0, 0]}),
        b"glTF\2\0\0\0",
    ],
)
def test_an_unreadable_file_is_refused_with_the_reason(tmp_path: Path, data: bytes, golden: Golden) -> None:
    (tmp_path / "a.gltf").write_bytes(data)
    with golden.raises(SceneError):
        mesh_pieces(tmp_path / "a.gltf", Wanted("whole"))
