"""Extruded polygons keep their volume, whole or in convex pieces."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.scene.inertia import solid_of
from nrp_core.scene.meshes import shapes
from nrp_core.scene.meshes.convex import convex_pieces
from nrp_core.scene.meshes.shapes import extrude, heights_of, terrain
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.model import Heightmap


def star(radii: list[float], scale: float = 1.0) -> np.ndarray:
    angles = np.arange(len(radii)) * 2 * np.pi / len(radii)
    return scale * np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


def area(ring: np.ndarray) -> float:
    x, y = ring.T
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def volumes(pieces: list[Triangles]) -> list[float]:
    solids = [solid_of(piece, 1.0) for piece in pieces]
    assert all(solid is not None for solid in solids)
    return [solid.mass for solid in solids if solid]


@given(st.lists(st.floats(0.3, 2.0), min_size=3, max_size=12), st.booleans(), st.booleans())
def test_stars_with_holes_have_the_volume_of_their_area(
    radii: list[float], hole: bool, backwards: bool
) -> None:
    outline, inner = star(radii), star(radii, 0.5)
    rings = [outline[::-1] if backwards else outline, *([inner] if hole else [])]
    expected = 0.7 * (area(outline) - hole * area(inner))
    (whole,) = extrude(rings, 0.7, convex=False)
    assert volumes([whole]) == pytest.approx([expected])
    pieces = extrude(rings, 0.7, convex=True)
    assert sum(volumes(pieces)) == pytest.approx(expected)
    for piece in pieces:
        (hull,) = convex_pieces(piece)
        assert volumes([hull]) == pytest.approx(volumes([piece]), rel=2e-2)


def test_a_convex_polygon_is_one_piece_and_an_island_in_a_hole_stands() -> None:
    assert len(extrude([star([1.0] * 8)], 1.0, convex=True)) == 1
    rings = [star([1.0] * 4, scale) for scale in (1.0, 3.0, 2.0)]
    (whole,) = extrude(rings, 1.0, convex=False)
    assert volumes([whole]) == pytest.approx([2 * (9 - 4 + 1)])


def test_heights_survive_as_triangles(tmp_path) -> None:
    from nrp_core.scene.meshes.stl import write_stl

    heights = np.random.Generator(np.random.Philox(1)).random((7, 4)).astype(np.float32)
    write_stl(tmp_path / "hills.stl", terrain(heights))
    ground = Heightmap(tmp_path / "hills.stl", (1.0, 1.0, 1.0), *heights.shape)
    assert heights_of(ground).tolist() == heights.tolist()


def test_an_outline_without_the_package_that_cuts_it_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    ring = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    with pytest.raises(SceneError, match=r"nrp-core\[models\]"):
        shapes._triangulated([ring])
