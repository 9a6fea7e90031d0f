"""Mesh files become pieces of a common kind, converted once."""

from __future__ import annotations

import gc
import os
import struct
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import square_gltf
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.scene import meshes
from nrp_core.scene.inertia import solid_of
from nrp_core.scene.meshes import Piece, mesh_pieces
from nrp_core.scene.meshes.convert import KINDS, Wanted, parse, pieces_of
from nrp_core.scene.meshes.convex import MAX_CORNERS, MAX_PIECES, convex_pieces
from nrp_core.scene.meshes.stl import read_stl, write_stl
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.sdf import read_model

FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
CORNERS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))

Pieces = Callable[..., list[Piece]]


@pytest.fixture
def pieces(tmp_path: Path) -> Pieces:
    """Write a file and return what it becomes."""

    def read(name: str, content: bytes | str, form: str = "colored", **wanted: object) -> list[Piece]:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return mesh_pieces(path, Wanted(form, **wanted))  # type: ignore[arg-type]

    return read


def volume(triangles: Triangles) -> float:
    solid = solid_of(triangles, 1.0)
    return solid.mass if solid else 0.0


def rounded(rgba: tuple[float, ...] | None) -> tuple[float, ...]:
    return tuple(round(part, 2) for part in rgba or ())


def box(size: float = 1.0, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Triangles:
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) - 0.5
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return corners[faces] * size + at


def ball(rings: int) -> Triangles:
    """A sphere of radius 1 as triangles between rings of points."""
    angles = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    heights = np.linspace(0, np.pi, rings)
    grid = np.array(
        [[(np.sin(h) * np.cos(a), np.sin(h) * np.sin(a), np.cos(h)) for a in angles] for h in heights]
    )
    a, b, c, d = grid[:-1], np.roll(grid[:-1], -1, 1), np.roll(grid[1:], -1, 1), grid[1:]
    lower, upper = np.stack([a, d, c], axis=2), np.stack([a, c, b], axis=2)
    return np.concatenate([lower.reshape(-1, 3, 3), upper.reshape(-1, 3, 3)])


# -- STL


def binary_stl() -> bytes:
    rows = [struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in CORNERS[i]), 0) for face in FACES]
    return b"solid that begins like text".ljust(80) + struct.pack("<I", 4) + b"".join(rows)


def text_stl() -> bytes:
    corners = (["outer loop", *("vertex {} {} {}".format(*CORNERS[i]) for i in face)] for face in FACES)
    return "\n".join(["solid thing", *(row for face in corners for row in face), "endsolid"]).encode()


@pytest.mark.parametrize("content", [binary_stl(), text_stl()])
def test_stl_is_read_binary_and_as_text(pieces: Pieces, tetrahedron: Triangles, content: bytes) -> None:
    (piece,) = pieces("a.STL", content)
    assert piece.rgba is None
    assert read_stl(piece.path).tolist() == tetrahedron.tolist()


# -- OBJ

TWO_THINGS = """
mtllib colors.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1  # a comment
o square
usemtl red
f 1/1/1 2/2/1 3/3/1 4/4/1
o corner
usemtl green
f -5//1 -4//1 -1//1
"""
COLORS = "newmtl red\nKd 1 0 0\nd 0.5\nnewmtl green\nKd 0 1 0\n"


def test_obj_is_read_with_its_colours_the_largest_piece_first(pieces: Pieces, tmp_path: Path) -> None:
    (tmp_path / "colors.mtl").write_text(COLORS)
    square, corner = pieces("a.obj", TWO_THINGS)
    assert (square.rgba, corner.rgba) == ((1, 0, 0, 0.5), (0, 1, 0, 1))
    assert read_stl(square.path).shape == (2, 3, 3)
    assert read_stl(corner.path).tolist() == [[[0, 0, 0], [1, 0, 0], [0, 0, 1]]]


def test_obj_is_read_with_comments_tabs_continued_lines_and_corners_of_any_form(pieces: Pieces) -> None:
    vertices = ["v\t0 0 0  # first", "  v 1 0 0 0.5 0.5 0.5", "v 0 1 0", "v 1 1 \\", " 0", "vn 0 0 1"]
    faces = ["f 1//1 2//1 4/7/1 3", "g again", "\tf -4 -3/2 -2"]
    (piece,) = pieces("a.obj", "\r\n".join(["# a corner", *vertices, *faces, ""]))
    assert sorted(read_stl(piece.path).sum(axis=1).tolist()) == [[1, 1, 0], [1, 2, 0], [2, 1, 0]]


def test_a_changed_material_file_is_noticed(pieces: Pieces, tmp_path: Path) -> None:
    assert [piece.rgba for piece in pieces("a.obj", TWO_THINGS)] == [None]
    (tmp_path / "colors.mtl").write_text(COLORS)
    assert pieces("a.obj", TWO_THINGS)[0].rgba == (1, 0, 0, 0.5)
    (tmp_path / "colors.mtl").write_text(COLORS.replace("1 0 0", "0 0 1"))
    assert pieces("a.obj", TWO_THINGS)[0].rgba == (0, 0, 1, 0.5)


@pytest.fixture
def hashed(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """All contents that are hashed from now on."""
    found: list[bytes] = []

    def counted(total: Any, *parts: object) -> Any:
        found.extend(part for part in parts if isinstance(part, bytes))
        return updated(total, *parts)

    updated = meshes._updated
    monkeypatch.setattr(meshes, "_updated", counted)
    return found


def test_a_file_is_hashed_again_only_if_it_has_changed(tmp_path: Path, hashed: list[bytes]) -> None:
    turned = TWO_THINGS.replace("v 1 0 0", "v 2 0 0")
    assert len(turned) == len(TWO_THINGS)
    path, extents = tmp_path / "a.obj", []
    for text, changed_s in ((TWO_THINGS, 1e9), (TWO_THINGS, 1e9), (turned, 1e9 + 1e-3)):
        path.write_text(text)
        os.utime(path, (changed_s, changed_s))
        extents.append([read_stl(piece.path).max() for piece in mesh_pieces(path, Wanted("colored"))])
    assert extents[0] == extents[1] != extents[2]
    assert hashed == [TWO_THINGS.encode(), turned.encode()]


def test_a_file_that_has_just_changed_may_change_within_the_same_tick(
    tmp_path: Path, hashed: list[bytes]
) -> None:
    turned = TWO_THINGS.replace("v 1 0 0", "v 2 0 0")
    path, extents, just_now_s = tmp_path / "a.obj", [], time.time()
    for text in (TWO_THINGS, turned):
        path.write_text(text)
        os.utime(path, (just_now_s, just_now_s))
        extents.append([read_stl(piece.path).max() for piece in mesh_pieces(path, Wanted("colored"))])
    assert extents[0] != extents[1]


def test_no_contents_of_mesh_files_stay_in_memory_for_their_hashes(tmp_path: Path) -> None:
    for number in range(4):
        path = tmp_path / f"{number}.stl"
        write_stl(path, np.concatenate([ball(20)] * 10) + number)
        os.utime(path, (1e9, 1e9))
        mesh_pieces(path, Wanted("whole"))
    meshes._parsed.cache_clear()
    # lists of the entry points of packages warn of those who look into them
    held = [each for each in gc.get_objects() if type(each) is list and _are_contents(each)]
    assert held == []


def _are_contents(held: list[object]) -> bool:
    return bool(held) and isinstance(held[0], bytes) and len(held[0]) > 100_000


def test_an_image_counts_as_its_mean_colour(pieces: Pieces, tmp_path: Path) -> None:
    half = np.zeros((4, 4, 3), np.uint8)
    half[:2] = (0, 0, 255)  # red, as OpenCV has it
    (tmp_path / "half.png").write_bytes(cv2.imencode(".png", half)[1].tobytes())
    (tmp_path / "colors.mtl").write_text("newmtl red\nKd 1 1 1\nmap_Kd half.png\n")
    assert rounded(pieces("a.obj", TWO_THINGS)[0].rgba) == (0.5, 0, 0, 1)


def test_a_submesh_is_picked_out_and_centred(pieces: Pieces) -> None:
    (corner,) = pieces("a.obj", TWO_THINGS, "whole", submesh="corner")
    assert read_stl(corner.path).tolist() == [[[0, 0, 0], [1, 0, 0], [0, 0, 1]]]
    (centred,) = pieces("a.obj", TWO_THINGS, "whole", submesh="corner", centered=True)
    points = read_stl(centred.path).reshape(-1, 3)
    assert (points.min(axis=0) + points.max(axis=0)).tolist() == [0, 0, 0]


# -- Collada

DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
    <unit name="{unit}" meter="{meter}"/><up_axis>Y_UP</up_axis></asset>
  <library_effects><effect id="paint"><profile_COMMON><technique sid="common"><phong>
    <emission><color>0 0 0 1</color></emission><diffuse><color>0.2 0.4 0.6 1</color></diffuse>
  </phong></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="blue"><instance_effect url="#paint"/></material></library_materials>
  <library_geometries><geometry id="shape" name="shape"><mesh>
    <source id="points"><float_array id="numbers" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
      <technique_common><accessor source="#numbers" count="4" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="vertices"><input semantic="POSITION" source="#points"/></vertices>
    <triangles count="4" material="skin"><input semantic="VERTEX" source="#vertices" offset="0"/>
      <p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene">
    <node id="left" name="left"><translate>10 0 0</translate>{node}</node>
    <node id="right" name="right"><scale>2 2 2</scale>{node}</node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"""
NODE = """<instance_geometry url="#shape"><bind_material><technique_common>
  <instance_material symbol="skin" target="#blue"/></technique_common></bind_material></instance_geometry>"""


def dae(unit: str = "meter", meter: float = 1.0) -> str:
    return DAE.format(unit=unit, meter=meter, node=NODE)


def test_collada_is_read_with_its_transforms_and_colours(pieces: Pieces) -> None:
    (piece,) = pieces("a.dae", dae())
    assert rounded(piece.rgba) == (0.2, 0.4, 0.6, 1)
    triangles = read_stl(piece.path)
    assert triangles.max(axis=(0, 1)).tolist() == [11, 2, 2]
    assert volume(triangles) == pytest.approx((1 + 8) / 6)


def test_a_faulty_colour_of_highlights_costs_a_collada_file_nothing(pieces: Pieces) -> None:
    faulty = dae().replace("</diffuse>", "</diffuse><specular><color>0 0 0.01.0</color></specular>")
    (piece,) = pieces("a.dae", faulty)
    assert rounded(piece.rgba) == (0.2, 0.4, 0.6, 1)
    assert volume(read_stl(piece.path)) == pytest.approx((1 + 8) / 6)


def test_the_unit_of_collada_counts(pieces: Pieces) -> None:
    (piece,) = pieces("a.dae", dae("millimeter", 0.001))
    assert read_stl(piece.path).max() == pytest.approx(0.011)


def test_a_node_of_collada_is_a_submesh(pieces: Pieces) -> None:
    (right,) = pieces("a.dae", dae(), "whole", submesh="right")
    assert volume(read_stl(right.path)) == pytest.approx(8 / 6)


def test_collada_with_entities_is_refused_unexpanded(pieces: Pieces, golden: Golden) -> None:
    bomb = "<!DOCTYPE a [" + "".join(
        f'<!ENTITY e{i} "{f"&e{i - 1};" * 10 if i else "x" * 100}">' for i in range(12)
    )
    with golden.raises(SceneError):
        pieces("a.dae", dae().replace("<COLLADA", bomb + "]><COLLADA", 1).replace("skin", "&e11;", 1))


def test_comments_in_collada_may_hold_hyphens(pieces: Pieces) -> None:
    text = (
        "<?xml version='1.0' encoding='iso-8859-1'?><!-- \N{DEGREE SIGN} --->"
        + dae()[dae().index("<COLLADA") :]
    )
    text = text.replace("<node", "<!--- -- --->\n<node")
    (right,) = pieces("a.dae", text.encode("latin-1"), "whole", submesh="right")
    assert volume(read_stl(right.path)) == pytest.approx(8 / 6)


NORMALS = """<source id="directions"><float_array id="many" count="{count}">{numbers}</float_array>
  <technique_common><accessor source="#many" count="{count}" stride="3">
    <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
  </accessor></technique_common></source><vertices"""


@pytest.mark.parametrize("source", ["directions", "points"])
def test_normals_in_collada_take_no_part_and_shift_nothing(pieces: Pieces, source: str) -> None:
    normal = f'<input offset="0" source="#{source}" semantic="NORMAL"/>'
    text = dae().replace("<vertices", NORMALS.format(count=3, numbers="0 0 1"), 1)
    text = text.replace('source="#vertices" offset="0"/>', f'source="#vertices" offset="1"/>{normal}')
    text = text.replace("0 2 1 0 1 3 0 3 2 1 2 3", "0 0 0 2 0 1 0 0 0 1 0 3 0 0 0 3 0 2 0 1 0 2 0 3")
    (given,), (without,) = pieces("a.dae", text), pieces("b.dae", dae())
    assert (read_stl(given.path) == read_stl(without.path)).all()


def test_numbers_of_normals_in_collada_are_not_read(pieces: Pieces) -> None:
    normal = '<input offset="0" source="#directions" semantic="NORMAL"/>'
    text = dae().replace("<vertices", NORMALS.format(count=4, numbers="0 0 1 0"), 1)
    text = text.replace("<p>", f"{normal}<p>")
    (given,), (without,) = pieces("a.dae", text), pieces("b.dae", dae())
    assert (read_stl(given.path) == read_stl(without.path)).all()


# -- convex pieces


def test_a_convex_solid_is_its_own_hull() -> None:
    (piece,) = convex_pieces(box())
    assert volume(piece) == pytest.approx(1)
    a, b, c = piece.swapaxes(0, 1)
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a)
    assert (outward > 0).all()


def test_pieces_that_do_not_touch_stay_apart_and_a_piece_inside_another_is_left_out() -> None:
    walls = np.concatenate([box(1), box(2, (5, 0, 0)), box(0.1, (5, 0, 0))])
    assert [volume(piece) for piece in convex_pieces(walls)] == pytest.approx([8, 1])


def test_only_the_largest_of_many_pieces_are_kept() -> None:
    crowd = np.concatenate([box(0.5 + i / 100, (2 * i, 0, 0)) for i in range(MAX_PIECES + 5)])
    pieces = convex_pieces(crowd)
    assert len(pieces) == MAX_PIECES
    assert min(map(volume, pieces)) >= 0.54**3


def test_a_fine_hull_is_made_coarse_and_keeps_its_extent() -> None:
    (piece,) = convex_pieces(ball(40))
    assert len(np.unique(piece.reshape(-1, 3), axis=0)) <= MAX_CORNERS
    assert volume(piece) == pytest.approx(4 / 3 * np.pi, rel=0.1)
    assert np.ptp(piece.reshape(-1, 3), axis=0) == pytest.approx([2, 2, 2], rel=0.01)


def test_a_hull_of_few_corners_is_exact_however_fine_its_mesh_is() -> None:
    directions = ball(40) / np.linalg.norm(ball(40), axis=2, keepdims=True)
    (piece,) = convex_pieces(directions / np.abs(directions).max(axis=2, keepdims=True))  # a cube of edge 2
    assert volume(piece) == pytest.approx(8, rel=2e-3)


@pytest.mark.parametrize(
    "triangles",
    [
        [[(0, 0, 0), (2, 0, 0), (0, 1, 0)]],  # a sheet
        [[(0, 0, 0), (1, 1, 1), (2, 2, 2)]],  # a line
        [[(3, 3, 3), (3, 3, 3), (3, 3, 3)]],  # a point
    ],
)
def test_a_flat_mesh_gets_a_thickness(triangles: list[list[tuple[float, float, float]]]) -> None:
    (piece,) = convex_pieces(np.array(triangles, float))
    assert volume(piece) > 0
    assert np.abs(piece).max() <= 3.01


@given(st.lists(st.tuples(*[st.floats(-10, 10)] * 9), min_size=1, max_size=30))
def test_every_corner_of_a_mesh_lies_in_a_piece_of_it(rows: list[tuple[float, ...]]) -> None:
    triangles = np.array(rows, np.float32).astype(float).reshape(-1, 3, 3)
    pieces = convex_pieces(triangles)
    lower = min(piece.min() for piece in pieces)
    upper = max(piece.max() for piece in pieces)
    tolerance = 1e-2 * max(np.ptp(triangles), 1e-6)
    assert lower <= triangles.min() + tolerance
    assert upper >= triangles.max() - tolerance


# -- weights


def test_a_box_of_triangles_weighs_what_a_box_does() -> None:
    solid = solid_of(box(2, (1, 2, 3)), 1000.0)
    assert solid is not None
    assert solid.mass == pytest.approx(8000)
    assert solid.pose.position == pytest.approx((1, 2, 3))
    assert solid.inertia == pytest.approx((8000 * 8 / 12,) * 3 + (0, 0, 0), abs=1e-6)


def test_a_mirrored_surface_weighs_the_same(tetrahedron: Triangles) -> None:
    usual, mirrored = solid_of(tetrahedron, 1.0), solid_of(tetrahedron * (-1, 1, 1), 1.0)
    assert usual is not None
    assert mirrored is not None
    assert mirrored.mass == pytest.approx(usual.mass)
    assert mirrored.inertia[:3] == pytest.approx(usual.inertia[:3])


def test_a_sheet_weighs_nothing() -> None:
    assert solid_of(np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0)]], float), 1.0) is None


# -- the cache


def test_a_mesh_is_converted_once(pieces: Pieces, monkeypatch: pytest.MonkeyPatch) -> None:
    content = dae(meter=0.123)
    first = pieces("a.dae", content)
    monkeypatch.setattr(meshes, "pieces_of", None)
    assert pieces("b.dae", content) == first


@pytest.mark.parametrize("damage", [Path.unlink, lambda path: path.with_name("pieces.json").write_text("{")])
def test_a_damaged_cache_is_made_anew(pieces: Pieces, damage: Callable[[Path], object]) -> None:
    (piece,) = pieces("a.stl", binary_stl())
    damage(piece.path)
    assert pieces("a.stl", binary_stl()) == [piece]
    assert volume(read_stl(piece.path)) == pytest.approx(1 / 6)


def test_without_a_cache_meshes_are_converted_in_each_process(
    pieces: Pieces, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/nowhere")
    (piece,) = pieces("a.stl", binary_stl())
    assert volume(read_stl(piece.path)) == pytest.approx(1 / 6)


# -- what cannot be used


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", b"solid nothing\nendsolid"),
        ("a.stl", b"\xff\xfe not a mesh"),
        ("a.stl", b"version https://git-lfs.github.com/spec/v1\noid sha256:0"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
        ("a.obj", b"v 0 0 zero\n"),
        ("a.obj", b"v 0 0 0\nf 1 0 1\n"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nf 1 2\n"),
        ("a.obj", b""),
        ("a.dae", b"<COLLADA>"),
        ("a.dae", b"<COLLADA/>"),
        ("a.fbx", b""),
    ],
)
def test_an_unusable_mesh_is_refused_in_one_sentence(
    pieces: Pieces, name: str, content: bytes, golden: Golden
) -> None:
    with golden.raises(SceneError) as refusal:
        pieces(name, content)
    assert "\n" not in refusal.value.message


@pytest.mark.parametrize(("height", "left_out"), [(1.0, 0), (np.nan, 1), (np.inf, 1), (1e10, 1)])
def test_triangles_that_cannot_be_drawn_are_left_out_and_counted(
    pieces: Pieces, tmp_path: Path, height: float, left_out: int
) -> None:
    content = bytearray(binary_stl())
    struct.pack_into("<f", content, 84 + 12, height)  # x of the first corner
    (piece,) = pieces("a.stl", bytes(content))
    assert (len(read_stl(piece.path)), piece.left_out) == (4 - left_out, left_out)
    shape = "<geometry><mesh><uri>a.stl</uri></mesh></geometry>"
    (tmp_path / "a.sdf").write_text(
        '<sdf version="1.7"><model name="m"><static>true</static><link name="a">'
        f'<visual name="v">{shape}</visual></link></model></sdf>'
    )
    said = [str(one) for one in read_model(tmp_path / "a.sdf").warnings]
    assert ["1 triangles of the mesh 'a.stl' are left out" in one for one in said] == [True] * left_out


def test_a_missing_submesh_is_named_with_the_existing_ones(pieces: Pieces, golden: Golden) -> None:
    with golden.raises(SceneError, match="'squar'"):
        pieces("a.obj", TWO_THINGS, submesh="squar")


@pytest.mark.parametrize("suffix", sorted(KINDS))
@given(data=st.data())
def test_a_damaged_file_is_read_or_refused_but_never_crashes(suffix: str, data: st.DataObject) -> None:
    sound = {
        ".stl": binary_stl(),
        ".obj": TWO_THINGS.encode(),
        ".dae": dae().encode(),
        ".gltf": square_gltf.text_file({}),
        ".glb": square_gltf.binary_file({}),
    }[suffix]
    start = data.draw(st.integers(0, len(sound)))
    end = data.draw(st.integers(start, len(sound)))
    damaged = sound[:start] + data.draw(st.binary(max_size=20)) + sound[end:]
    try:
        pieces = pieces_of(parse(damaged, suffix, lambda _: None)[0], Wanted("convex"))
    except (ValueError, IndexError):
        return
    assert all(np.isfinite(triangles).all() for triangles in (piece.triangles for piece in pieces))


@pytest.mark.parametrize("number", [b"\0\0\x81\x7f", b"\0\0\x80\x7f", b"\0\0\xc0\x7f"])
def test_a_triangle_of_gltf_with_a_corner_that_is_not_a_number_is_left_out(number: bytes) -> None:
    """A signalling nan, an infinity and a quiet nan in the corner that only one triangle has."""
    corners = square_gltf.CORNERS.tobytes()
    damaged = square_gltf.binary_file({}).replace(corners, corners[:36] + number + corners[40:])
    (surface,), left_out = parse(damaged, ".glb", lambda _: None)
    assert (len(surface.triangles), left_out) == (1, 1)


def test_a_written_mesh_is_read_back(tmp_path: Path) -> None:
    write_stl(tmp_path / "a.stl", ball(5))
    assert read_stl(tmp_path / "a.stl") == pytest.approx(ball(5), abs=1e-6)
