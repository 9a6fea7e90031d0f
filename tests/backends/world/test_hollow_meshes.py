"""Static meshes that are not convex are as hollow as they are drawn, on both engines and for lasers."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from nrp_world_mujoco.ground import ground_of
from scipy.spatial import ConvexHull

from nrp_core.findings import Code
from nrp_core.scene.meshes.cells import MAX_HOLLOW, cells, cells_of_surfaces, merged_cells
from nrp_core.scene.meshes.concave import concave_parts, hull_excess
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.meshes.triangles import revolve
from nrp_core.scene.model import ConcaveMesh, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.scene.tessellation import triangles_of
from nrp_core.world.robot_setup import RobotSetup, set_up_robot

RADIUS = 0.1
WORLD = """<sdf version="1.9"><world name="room">
  <model name="house"><static>1</static><link name="l"><collision name="c"><geometry>
    <mesh><uri>house.stl</uri></mesh></geometry></collision></link></model>
  <model name="floor"><static>1</static><link name="l"><collision name="c"><pose>0 0 -0.5 0 0 0</pose>
    <geometry><box><size>20 20 1</size></box></geometry></collision></link></model>
  <model name="ball"><pose>{place} 0 0 0</pose><link name="l"><collision name="c"><geometry>
    <sphere><radius>0.1</radius></sphere></geometry></collision>
    <sensor name="scan" type="ray"><update_rate>50</update_rate><topic>scan</topic><ray><scan><horizontal>
    <samples>4</samples><min_angle>-1.5707963</min_angle><max_angle>3.1415927</max_angle></horizontal></scan>
    <range><min>0.1</min><max>30</max></range></ray></sensor></link></model>
</world></sdf>"""


def quads(corners: np.ndarray) -> np.ndarray:
    """Return the triangles of quads, shape ``(n, 4, 3)``."""
    return corners[:, [(0, 1, 2), (0, 2, 3)]].reshape(-1, 3, 3)


def ring(outer: float = 5.0, inner: float = 4.8, height: float = 2.0) -> np.ndarray:
    """Return four joined walls about the origin, one closed surface."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    low = {half: np.column_stack([square * half, np.zeros(4)]) for half in (outer, inner)}
    high = {half: corners + np.array([0.0, 0.0, height]) for half, corners in low.items()}
    sides = []
    for i, j in ((0, 1), (1, 2), (2, 3), (3, 0)):
        sides += [
            (low[outer][i], low[outer][j], high[outer][j], high[outer][i]),
            (low[inner][j], low[inner][i], high[inner][i], high[inner][j]),
            (high[outer][i], high[outer][j], high[inner][j], high[inner][i]),
            (low[outer][j], low[outer][i], low[inner][i], low[inner][j]),
        ]
    return quads(np.array(sides))


def hills(count: int) -> np.ndarray:
    """Return an open surface of ``2 (count - 1)**2`` triangles with valleys."""
    x, y = np.meshgrid(*[np.linspace(-4, 4, count)] * 2)
    points = np.stack([x, y, 1 + 0.25 * np.cos(np.pi * x) * np.cos(np.pi * y)], axis=2)
    corners = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    return quads(np.stack(corners, axis=2).reshape(-1, 4, 3))


def room(folder: Path, triangles: np.ndarray, place: str):
    write_stl(folder / "house.stl", triangles)
    (folder / "room.sdf").write_text(WORLD.format(place=place))
    return read_scene(folder / "room.sdf")


@pytest.mark.one_of(3)
@pytest.mark.parametrize("inward", [False, True])
def test_a_ball_stands_between_joined_walls_and_sees_them(open_world, advance, tmp_path, inward):
    walls = ring()
    world = open_world(room(tmp_path, walls[:, ::-1] if inward else walls, "1 1 0.5"))
    scans = world.subscribe("/ball/scan")
    advance(world, 0.02)
    # at -90, 0, 90 and 180 degrees
    assert scans.latest.message.ranges == pytest.approx([5.8, 3.8, 3.8, 5.8], abs=1e-3)
    advance(world, 1.0)
    assert world.model_motion("ball").pose.position == pytest.approx((1, 1, RADIUS), abs=2e-3)


@pytest.mark.one_of(3)
def test_a_ball_rests_on_a_wall_and_falls_into_the_valley_of_a_terrain(open_world, advance, tmp_path):
    world = open_world(room(tmp_path, ring(), "4.9 0 2.3"))
    advance(world, 1.0)
    assert world.model_motion("ball").pose.position[2] == pytest.approx(2 + RADIUS, abs=2e-3)
    world = open_world(room(tmp_path, hills(65), "1 0 2"))
    advance(world, 1.0)
    assert world.model_motion("ball").pose.position == pytest.approx((1, 0, 0.75 + RADIUS), abs=5e-3)


def test_convex_meshes_stay_hulls_and_moving_ones_do_not_become_surfaces(tmp_path):
    assert concave_parts(hull_of_cube()) is None
    scene = room(tmp_path, ring(), "0 0 1")
    assert all(isinstance(each.geometry, ConcaveMesh) for each in scene.models[0].links[0].collisions)
    moving = WORLD.format(place="0 0 1").replace("<static>1</static>", "", 1)
    (tmp_path / "room.sdf").write_text(moving)
    shapes = read_scene(tmp_path / "room.sdf").models[0].links[0].collisions
    assert not any(isinstance(each.geometry, ConcaveMesh) for each in shapes)


def test_walls_in_millimetres_are_as_thick_as_those_in_metres(tmp_path):
    found = []
    for units in (1, 1000):
        room(tmp_path, units * ring(), "0 0 1")
        text = (tmp_path / "room.sdf").read_text()
        scale = f"</uri><scale>{f'{1 / units} ' * 3}</scale>"
        (tmp_path / "room.sdf").write_text(text.replace("</uri>", scale, 1))
        (shape,) = read_scene(tmp_path / "room.sdf").models[0].links[0].collisions
        vertices, faces = triangles_of(shape.geometry)
        found.append((shape.geometry.depth, np.ptp(vertices, axis=0), len(faces)))
    assert found[0][0] == found[1][0] == pytest.approx(0.05)
    assert found[0][1] == pytest.approx(found[1][1])
    assert found[0][2] == found[1][2]


def test_an_object_that_moves_is_reported_with_the_volume_of_its_hull(tmp_path):
    room(tmp_path, ring(), "0 0 1")
    assert hull_excess(np.concatenate([cup(), cup()[:, ::-1]]), [hull_of_cube()]) == 0.0
    for static, expected in (("0", ["1176"]), ("1", [])):
        text = WORLD.format(place="0 0 1").replace("<static>1</static>", f"<static>{static}</static>", 1)
        (tmp_path / "room.sdf").write_text(text)
        found = [each for each in read_scene(tmp_path / "room.sdf").warnings if each.code == Code.NRP258]
        # the hull has 10 m x 10 m x 2 m, the walls 7.84 m^2 x 2 m
        assert [re.search(r"(\d+) %", each.message).group(1) for each in found] == expected


def cup() -> np.ndarray:
    """Return a cup about z of 0.5 m radius and 1 m height, its wall 4 cm and its bottom 10 cm thick."""
    vertices, faces = revolve([(0, 0), (0.5, 0), (0.5, 1), (0.46, 1), (0.46, 0.1), (0, 0.1)])
    return vertices[faces]


@pytest.mark.one_of(2)
@pytest.mark.parametrize(("sides", "units"), [(1, 1000), (2, 1)])
def test_a_ball_stays_in_a_bin_that_moves(open_world, advance, tmp_path, sides, units):
    surface = cup()
    write_stl(tmp_path / "house.stl", units * np.concatenate([surface, surface[:, ::-1]][:sides]))
    inertial = "<inertial><mass>20</mass><inertia><ixx>2</ixx><iyy>2</iyy><izz>2</izz></inertia></inertial>"
    text = WORLD.format(place="0.1 0 1.5").replace(
        '<static>1</static><link name="l">', f'<link name="l">{inertial}', 1
    )
    scale = f"</uri><scale>{f'{1 / units} ' * 3}</scale>"
    (tmp_path / "room.sdf").write_text(text.replace("</uri>", scale, 1))
    scene = read_scene(tmp_path / "room.sdf")
    assert len(scene.models[0].links[0].collisions) <= MAX_HOLLOW
    assert not [each for each in scene.warnings if each.code == Code.NRP258]
    world = open_world(scene)
    advance(world, 1.5)
    x, y, z = world.model_motion("ball").pose.position
    assert np.hypot(x, y) < 0.46 - RADIUS + 0.01
    assert z == pytest.approx(0.1 + RADIUS, abs=0.015)
    assert world.model_motion("house").pose.position == pytest.approx((0, 0, 0), abs=0.02)


def test_a_ball_falls_through_the_hole_of_a_plate_in_urdf(open_world, advance, tmp_path):
    write_stl(tmp_path / "plate.stl", ring(outer=1.0, inner=0.3, height=0.2))
    (tmp_path / "plate.urdf").write_text(
        '<robot name="plate"><link name="plate"><inertial><mass value="5"/>'
        '<inertia ixx="1" iyy="1" izz="1"/></inertial><collision><geometry><mesh filename="plate.stl"/>'
        "</geometry></collision></link></robot>"
    )
    plate = set_up_robot(read_model(tmp_path / "plate.urdf"), RobotSetup(True))
    ball = room(tmp_path, ring(), "0.05 0 0.6").models[2]
    world = open_world(Scene((replace(plate, pose=Pose((0.0, 0.0, 0.1))), ball)))
    advance(world, 0.5)
    assert world.model_motion("ball").pose.position == pytest.approx((0.05, 0, 0.6 - 9.81 / 8), abs=0.02)


def hull_of_cube() -> np.ndarray:
    x, y = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]).T / 2
    low, high = (np.column_stack([x, y, np.full(4, z)]) for z in (-0.5, 0.5))
    sides = [(low[i], low[j], high[j], high[i]) for i, j in ((0, 1), (1, 2), (2, 3), (3, 0))]
    return quads(np.array([*sides, high, low[::-1]]))


def test_cells_are_as_thin_as_the_walls_and_have_their_surface():
    (part,) = concave_parts(ring(inner=4.98))
    assert part.depth == pytest.approx(0.02)
    made = list(cells(part.triangles, part.depth))
    assert len(made) == 16  # each flat side is one cell; each rim has four
    areas, volumes = zip(*((_area(each[:4]), ConvexHull(each).volume) for each in made), strict=True)
    # sides of 2 m height and two rims
    assert sum(areas) == pytest.approx(2 * 4 * (10 + 9.96) + 2 * (10**2 - 9.96**2), rel=1e-5)
    assert volumes == pytest.approx(np.array(areas) * 0.02, rel=1e-4)


def _area(corners: np.ndarray) -> float:
    """Return the area of a convex quadrilateral."""
    a, b, c, d = corners
    return float(np.linalg.norm(np.cross(c - a, d - b))) / 2


def shell(half: float = 2.0, height: float = 2.0) -> np.ndarray:
    """Return four walls without thickness that face the origin, and a floor."""
    x, y = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]).T * half
    low, high = (np.column_stack([x, y, np.full(4, z)]) for z in (0.2, height))
    sides = [(low[j], low[i], high[i], high[j]) for i, j in ((0, 1), (1, 2), (2, 3), (3, 0))]
    return quads(np.array([*sides, low]))


@pytest.mark.parametrize("kind", ["inside", "outside", "both"])
def test_surfaces_without_thickness_keep_their_room_whichever_way_they_face(
    open_world, advance, tmp_path, kind
):
    walls = shell()
    faces = {"inside": walls, "outside": walls[:, ::-1], "both": np.concatenate([walls, walls[:, ::-1]])}
    world = open_world(room(tmp_path, faces[kind], "1.88 1 0.5"))  # 2 cm from a wall
    scans = world.subscribe("/ball/scan")
    advance(world, 0.02)
    assert scans.latest.message.ranges == pytest.approx([3.0, 0.12, 1.0, 3.88], abs=1e-3)
    advance(world, 1.0)
    lying = 0.01 if kind == "outside" else 0.0  # MuJoCo has a plate of 1 cm behind each face
    x, y, z = world.model_motion("ball").pose.position
    assert (x, y) == pytest.approx((1.88, 1.0), abs=2e-3)
    assert 0.2 + RADIUS - 2e-3 < z < 0.2 + RADIUS + lying + 2e-3


def test_a_wall_without_thickness_has_its_door_and_a_lidless_box_its_inside(open_world, advance, tmp_path):
    x = np.array([(-2, -1), (-1, 1), (1, 2)])
    posts = [[(a, 1, 0), (b, 1, 0), (b, 1, 2), (a, 1, 2)] for a, b in x[[0, 2]]]
    lintel = [[(a, 1, 2), (b, 1, 2), (b, 1, 3), (a, 1, 3)] for a, b in x]
    world = open_world(room(tmp_path, quads(np.array(posts + lintel, float)), "0 1 0.5"))
    advance(world, 1.0)
    assert world.model_motion("ball").pose.position == pytest.approx((0, 1, RADIUS), abs=2e-3)


def test_an_inverted_terrain_carries_as_any_other(open_world, advance, tmp_path):
    for count in (9, 33):
        heights = []
        for surface in (hills(count), hills(count)[:, ::-1]):
            world = open_world(room(tmp_path, surface, "1 0 2"))
            advance(world, 1.0)
            heights.append(world.model_motion("ball").pose.position[2])
        assert heights[0] == pytest.approx(0.75 + RADIUS, abs=0.03)
        assert heights[1] == pytest.approx(heights[0], abs=0.015)


def tube(count: int) -> np.ndarray:
    """Return a torus of radii 0.3 and 0.1 m about z, of ``2 count**2`` triangles."""
    angles = np.arange(count + 1) * 2 * np.pi / count
    u, v = np.meshgrid(angles, angles, indexing="ij")
    points = np.stack(
        [(0.3 + 0.1 * np.cos(v)) * np.cos(u), (0.3 + 0.1 * np.cos(v)) * np.sin(u), 0.1 * np.sin(v)], axis=2
    )
    corners = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return quads(np.stack(corners, axis=2).reshape(-1, 4, 3))


def test_cells_of_a_round_surface_are_few_and_stay_near_it():
    surface = tube(32)
    (part,) = concave_parts(surface)
    made = cells(part.triangles, part.depth)
    assert len(made) < len(surface) / 5
    rng = np.random.default_rng(1)
    u, v = rng.uniform(0, 2 * np.pi, (2, 2000))
    for radius, inside in ((0.104, False), (0.096, True)):  # the middles of faces are 0.5 mm inside
        level = 0.3 + radius * np.cos(v)
        points = np.column_stack([level * np.cos(u), level * np.sin(u), radius * np.sin(v)])
        hulls = (ConvexHull(each).equations for each in made)
        filled = np.zeros(len(points), bool)
        for hull in hulls:
            filled |= (points @ hull[:, :3].T + hull[:, 3] < 0).all(axis=1)
        assert filled.mean() > 0.99 if inside else not filled.any()  # cells part behind a hollow side


def test_faces_that_are_given_from_both_sides_have_the_cells_of_a_sheet():
    surface = tube(32)
    (part,) = concave_parts(np.concatenate([surface, surface[:, ::-1]]))
    assert part.depth == pytest.approx(0.01)
    assert len(cells(part.triangles, 0.01)) == len(cells(surface, 0.01))


def test_cells_are_computed_once(monkeypatch):
    (part,) = concave_parts(tube(48))
    first = cells(part.triangles, part.depth)
    monkeypatch.setattr("nrp_core.scene.meshes.cells._computed", None)
    again = cells(part.triangles, part.depth)
    assert len(first) > 1
    assert all(np.array_equal(one, other) for one, other in zip(first, again, strict=True))


@pytest.mark.parametrize("most", [100, 10_000])
def test_the_cells_of_a_room_are_read_from_one_entry_until_a_mesh_changes(tmp_path, monkeypatch, most):
    write_stl(tmp_path / "house.stl", hills(33))
    uses = {ConcaveMesh(tmp_path / "house.stl", depth=depth): 2 for depth in (0.01, 0.02)}
    first, errors = cells_of_surfaces(uses, most)
    monkeypatch.setattr("nrp_core.scene.meshes.cells.cells", None)
    again, errors_again = cells_of_surfaces(uses, most)
    assert len(errors) == (2 if most == 100 else 0)
    assert (errors == errors_again).all()
    for one, other in zip([*first[0], *first[1]], [*again[0], *again[1]], strict=True):
        assert np.array_equal(one, other)
    write_stl(tmp_path / "house.stl", hills(33) * 2)
    with pytest.raises(TypeError):  # computed anew
        cells_of_surfaces(uses, most)


def test_merged_cells_are_few_cover_the_surface_and_stay_as_near_it_as_they_say():
    surface, side = hills(65), 0.5
    found = cells(surface, 0.01)
    made, error = merged_cells(found, side)
    assert len(found) > 4 * (8 / side) ** 2
    assert len(made) <= (1 + 8 / side) ** 2 * 2
    assert 0.01 < error < side / 2
    a, b, c = surface[::4].swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    for above, inside in ((-0.004, True), (2 * error, False), (-2 * error, False)):
        points = (a + b + c) / 3 + above * normals
        filled = np.zeros(len(points), bool)
        for hull in (ConvexHull(each).equations for each in made):
            filled |= (points @ hull[:, :3].T + hull[:, 3] < 1e-6).all(axis=1)
        assert filled.all() if inside else not filled.any()


def test_a_room_of_very_many_cells_has_fewer_for_mujoco_and_says_how_exact_they_are(
    backend, open_world, advance, tmp_path, monkeypatch
):
    pytest.importorskip("mujoco")
    monkeypatch.setattr("nrp_world_mujoco.surfaces.MAX_CELLS", 600)
    surface = np.concatenate([hills(33), hills(33) + np.array([0, 0, 1])])
    scene = room(tmp_path, surface, "1 0 2.2")
    write_stl(tmp_path / "thread.stl", quads(np.array([[(0, 0, 3), (1, 0, 3), (1, 5e-5, 3), (0, 5e-5, 3)]])))
    link = scene.models[0].links[0]
    thread = replace(link.collisions[0], name="thread", geometry=ConcaveMesh(tmp_path / "thread.stl"))
    link = replace(link, collisions=(*link.collisions, thread))  # too narrow to have a cell
    house = replace(scene.models[0], links=(link,))
    world = open_world(replace(scene, models=(house, *scene.models[1:])))
    advance(world, 1.0)
    reported = [each.message for each in world.engine.warnings if each.code == Code.NRP258]
    off = float(re.search(r"up to ([\d.]+) m", reported[0]).group(1)) if reported else 0.0
    assert bool(reported) == ("Mujoco" in type(backend).__name__)
    assert world.model_motion("ball").pose.position[2] == pytest.approx(1.75 + RADIUS, abs=0.02 + off)


def test_cells_of_a_floor_leave_its_pit_open():
    """Its slopes are so gentle that they go on from the floor, and narrow strips are around it."""
    x = [0.0, 2.0, 2.1, 4.1, 4.2, 6.2]
    flat = [
        [(x[i], x[j], 0), (x[i + 1], x[j], 0), (x[i + 1], x[j + 1], 0), (x[i], x[j + 1], 0)]
        for i in range(5)
        for j in range(5)
        if (i, j) != (2, 2)
    ]
    rim = [(2.1, 2.1, 0), (4.1, 2.1, 0), (4.1, 4.1, 0), (2.1, 4.1, 0)]
    slopes = [(rim[i - 1], rim[i], (3.1, 3.1, -0.2)) for i in range(4)]
    made = cells(np.concatenate([quads(np.array(flat)), slopes]), 0.01)
    over = np.random.default_rng(1).uniform((2.7, 2.7, -0.1), (3.5, 3.5, 0.0), (500, 3))
    for each in made:
        hull = ConvexHull(each).equations
        assert not (over @ hull[:, :3].T + hull[:, 3] < -1e-9).all(axis=1).any()


def test_a_terrain_becomes_a_grid_and_a_roof_over_something_does_not(open_world, advance, tmp_path):
    surface = hills(65)
    ground = ground_of(*_indexed(surface))
    assert ground.heights.shape == (129, 129)  # its triangles have the other diagonal
    turned = ground_of(*_indexed(surface[..., [1, 0, 2]] * (-1, 1, 1)))
    assert turned.heights.shape == (65, 65)
    assert ground.at(np.array([(1.0, 0.0), (0.0, 0.0)])) == pytest.approx([0.75, 1.25])
    assert ground_of(*_indexed(surface[:-1])) is not None  # a corner at the rim is missing
    assert ground_of(*_indexed(np.delete(surface, slice(4000, 4200), axis=0))) is None
    assert ground_of(*_indexed(np.concatenate([surface, surface + np.array([0, 0, 1])]))) is None
    world = open_world(room(tmp_path, surface, "1 0 0.3"))
    advance(world, 1.0)
    assert world.model_motion("ball").pose.position == pytest.approx((1, 0, RADIUS), abs=5e-3)


def _indexed(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, faces.reshape(-1, 3)
