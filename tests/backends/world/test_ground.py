"""Ground of height maps and extruded polygons bears what lies on it, at its height, on both engines."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from golden import Golden

from nrp_core.scene.model import Heightmap, Scene
from nrp_core.scene.sdf import read_scene

RADIUS = 0.1

WORLD = """<sdf version="1.9"><world name="room">
  <model name="ground"><static>1</static><pose>0 0 0.5 0 0 0</pose><link name="l">
    <visual name="v"><geometry>{shape}</geometry></visual>
    <collision name="c"><geometry>{shape}</geometry></collision></link></model>
  <model name="floor"><static>1</static><link name="l"><collision name="c"><geometry>
    <box><size>10 10 0.2</size></box></geometry></collision></link></model>
  {balls}
</world></sdf>"""
BALL = """<model name="ball{i}"><pose>{x} {y} 2 0 0 0</pose><link name="l"><collision name="c"><geometry>
    <sphere><radius>0.1</radius></sphere></geometry></collision>
    <sensor name="down" type="ray"><update_rate>50</update_rate><topic>down</topic>
    <pose>0 0 0 0 1.5707963 0</pose><ray><scan><horizontal><samples>1</samples></horizontal></scan></ray>
    </sensor></link></model>"""


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))


def with_balls(folder: Path, shape: str, places: list[tuple[float, float]]) -> Scene:
    balls = "".join(BALL.format(i=i, x=x, y=y) for i, (x, y) in enumerate(places))
    room = folder / "room.sdf"
    room.write_text(WORLD.format(shape=shape, balls=balls))
    return read_scene(room)


def hills(folder: Path, size: str = "8 8 1") -> str:
    """Four plateaus, of other heights in each quarter: in an image x goes right and y goes up."""
    quarters = np.array([[255, 128], [64, 0]], np.uint8).repeat(16, axis=0).repeat(16, axis=1)
    cv2.imwrite(str(folder / "hills.png"), quarters)
    return f"<heightmap><uri>hills.png</uri><size>{size}</size><pos>0 0 0.25</pos></heightmap>"


def polylines(*rings: str) -> str:
    points = [" ".join(ring.split()).split(", ") for ring in rings]
    lines = ("".join(f"<point>{point}</point>" for point in ring) for ring in points)
    return "".join(f"<polyline>{line}<height>0.3</height></polyline>" for line in lines)


FRAME = polylines("-1 -1, 1 -1, 1 1, -1 1", "-0.5 -0.5, 0.5 -0.5, 0.5 0.5, -0.5 0.5, -0.5 -0.5")
CORNER = polylines("0 0, 2 0, 2 1, 1 1, 1 2, 0 2")


def test_balls_rest_on_a_height_map_and_lasers_see_it(open_world, advance, tmp_path):
    places = [(-2, 2), (2, 2), (-2, -2), (2, -2)]
    scene = with_balls(tmp_path, hills(tmp_path), places)
    world = open_world(scene)
    heights = [0.75 + level / 255 for level in (255, 128, 64, 0)]
    below = [world.subscribe(f"/ball{i}/down") for i in range(4)]
    advance(world, 0.02)
    seen = [float(each.latest.message.ranges[0]) for each in below]
    assert seen == pytest.approx([2 - height for height in heights], abs=5e-3)
    advance(world, 2.0)
    rests = [world.model_motion(f"ball{i}").pose.position[2] for i in range(4)]
    assert rests == pytest.approx([height + RADIUS for height in heights], abs=0.01)


@pytest.mark.parametrize(
    ("shape", "places", "heights"),
    [
        (FRAME, [(0.75, 0), (0, 0)], [0.8, 0.1]),
        (CORNER, [(1.5, 0.5), (0.5, 1.5), (1.5, 1.5)], [0.8, 0.8, 0.1]),
    ],
)
def test_balls_rest_on_an_extruded_polygon_and_fall_through_its_holes(
    open_world, advance, tmp_path, shape, places, heights
):
    world = open_world(with_balls(tmp_path, shape, places))
    advance(world, 2.0)
    rests = [world.model_motion(f"ball{i}").pose.position[2] for i in range(len(places))]
    assert rests == pytest.approx([height + RADIUS for height in heights], abs=0.01)


def test_a_height_map_that_cannot_be_had_is_a_warning(tmp_path):
    shape = hills(tmp_path)
    assert isinstance(with_balls(tmp_path, shape, []).models[0].links[0].collisions[0].geometry, Heightmap)
    for change, reason in (
        (
            lambda: (tmp_path / "hills.png").write_bytes(b"no"),
            "is not an image of at least 2 by 2 and at most 67 million pixels",
        ),
        (lambda: (tmp_path / "hills.png").unlink(), "is not there"),
    ):
        change()
        assert f"the height map 'hills.png' {reason}" in str(with_balls(tmp_path, shape, []).warnings[0])
    moving = WORLD.replace("<static>1</static><pose>0 0 0.5", "<pose>0 0 0.5").format(shape=shape, balls="")
    (tmp_path / "room.sdf").write_text(moving)
    assert "belongs to a model that is not <static>" in str(read_scene(tmp_path / "room.sdf").warnings[0])


def test_a_polyline_that_encloses_nothing_is_a_warning(tmp_path, golden: Golden):
    scene = with_balls(tmp_path, polylines("0 0, 1 0, 2 0"), [])
    golden(str(scene.warnings[0]))
