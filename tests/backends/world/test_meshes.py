"""Robots and rooms of mesh files: what is drawn, what is touched and what it weighs, on both engines."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import Box, Mesh, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_scene

SIDE = 0.4

WORLD = """<sdf version="1.9"><world name="room">
  <model name="floor"><static>1</static><link name="l"><collision name="c"><geometry>
    <box><size>10 10 0.1</size></box></geometry></collision></link></model>
  <model name="cube"><pose>0 0 {height} 0 0 0</pose><link name="l">
    <visual name="v"><geometry>{mesh}</geometry></visual>
    <collision name="c"><density>500</density><geometry>{mesh}</geometry></collision>
  </link></model>
</world></sdf>"""


@pytest.fixture(autouse=True, scope="module")
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


def box(size: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) - 0.5
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners[[face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]] * size + at


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory, _own_cache: None) -> Scene:
    """A cube in millimetres, as CAD programs write them, 2 cm above where it comes to rest."""
    folder = tmp_path_factory.mktemp("cube")
    write_stl(folder / "cube.stl", box(1000 * SIDE))
    mesh = "<mesh><uri>cube.stl</uri><scale>0.001 0.001 0.001</scale></mesh>"
    room = folder / "room.sdf"
    room.write_text(WORLD.format(mesh=mesh, height=0.05 + SIDE / 2 + 0.02))
    return read_scene(room)


def test_a_mesh_rests_on_the_floor_on_its_face(open_world, advance, cube):
    world = open_world(cube)
    advance(world, 2.0)
    pose = world.model_motion("cube").pose
    assert pose.position == pytest.approx((0, 0, 0.05 + SIDE / 2), abs=2e-3)
    assert pose.rpy[:2] == pytest.approx((0, 0), abs=0.01)


def test_a_mesh_without_inertial_weighs_what_it_bounds(cube):
    inertial = cube.model("cube").links[0].inertial
    assert inertial.mass == pytest.approx(500 * SIDE**3)
    assert inertial.inertia[:3] == pytest.approx((inertial.mass * SIDE**2 / 6,) * 3)


def test_separate_parts_of_a_mesh_have_free_space_between_them(open_world, advance, parts, tmp_path):
    gate = np.concatenate([box(1, (0, -1.5, 0)), box(1, (0, 1.5, 0))])
    write_stl(tmp_path / "gate.stl", gate)
    mesh = "<collision name='c'><geometry><mesh><uri>gate.stl</uri></mesh></geometry></collision>"
    ball = (
        "<model name='ball'><pose>0 0 2 0 0 0</pose><link name='l'><collision name='c'><geometry>"
        "<sphere><radius>0.3</radius></sphere></geometry></collision></link></model>"
    )
    room = tmp_path / "room.sdf"
    model = f"<model name='gate'><static>1</static><link name='l'>{mesh}</link></model>"
    room.write_text(f"<sdf version='1.9'><world name='w'>{model}{ball}</world></sdf>")
    world = open_world(read_scene(room))
    advance(world, 0.8)
    assert world.model_motion("ball").pose.position[2] < -0.5


def test_a_mesh_looks_like_the_shape_that_it_has(look, parts, cube):
    mesh = cube.model("cube").links[0].visuals[0].geometry
    assert isinstance(mesh, Mesh)
    place, rgba = Pose((1.2, 0.3, 0.5)), (1, 0, 0, 1)
    images = [
        look(parts.prop("thing", geometry, place, rgba=rgba, solid=False), parts.husky())
        for geometry in (mesh, Box((SIDE, SIDE, SIDE)))
    ]
    red = [(image == (255, 0, 0)).all(axis=2) for image in images]
    assert red[1].sum() > 50
    assert (red[0] == red[1]).mean() > 0.99
