"""What scanners and cameras see at the start: their own robot, the room, or nothing."""

from dataclasses import replace
from itertools import product
from math import inf, pi
from pathlib import Path

import pytest

import nrp_core
from nrp_core.experiment.making.maker import maker_of
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import Box, Collision, Link, Model, Scene, Visual
from nrp_core.world.scene.sdf import read_model
from nrp_core.world.sight import enclosed, sights

BOX = "<box><size>0.4 0.4 0.2</size></box>"
MESH = "<mesh><uri>shell.obj</uri></mesh>"
INVERTED = "<mesh><uri>inverted.obj</uri></mesh>"
OPEN = "<mesh><uri>open.obj</uri></mesh>"
FACES = [(0, 1, 3), (0, 3, 2), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7),
         (1, 7, 3), (4, 6, 7), (4, 7, 5)]  # fmt: skip
"""Triangles of a box, which face outward; the last two are its front, at x = 0.2."""
SCAN = """<sensor name="scan" type="ray"><pose>{} 0 0 0 0 0</pose><ray>
<scan><horizontal><samples>9</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>
<range><min>0.02</min><max>10</max></range></ray>
<plugin name="p" filename="libgazebo_ros_laser.so"><topicName>/scan</topicName></plugin></sensor>"""
CAMERA = """<sensor name="eye" type="camera"><pose>{} 0 0 0 0 0</pose><camera>
<horizontal_fov>1</horizontal_fov><image><width>32</width><height>24</height></image>
<clip><near>0.01</near><far>50</far></clip></camera>
<plugin name="p" filename="libgazebo_ros_camera.so"><imageTopicName>/eye</imageTopicName></plugin></sensor>"""
INERTIAL = "<inertial><mass>1</mass></inertial>"
SPLIT = f"""</link><link name="head">{INERTIAL}{{}}</link><joint name="pan" type="revolute">
<parent>base</parent><child>head</child>
<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>"""
HERE = "{}</link>"


def write(path: Path, faces: list[tuple[int, int, int]]) -> None:
    corners = product((-0.2, 0.2), (-0.2, 0.2), (-0.1, 0.1))
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    path.write_text("\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces)]) + "\n")


FLOOR = Box((20.0, 20.0, 0.1))
ROOM = Scene((
    Model("floor", (Link("link", collisions=(Collision("c", FLOOR),), visuals=(Visual("v", FLOOR),)),),
          pose=Pose((0.0, 0.0, -1.0)), static=True),
))  # fmt: skip
"""A floor 0.95 m below the robot."""


def seen(robot: Model) -> list[tuple[float, str, float, float]]:
    """Return the share, the link and the distance of the own robot, and the share of nothing."""
    found = sights(ROOM.with_model(robot), robot)
    return [(one.own, one.most, round(one.nearest_m, 2), round(one.empty, 2)) for one in found]


@pytest.mark.parametrize(
    ("geometry", "part", "sensor", "x", "own"),
    [
        (MESH, SPLIT, SCAN, 0.1, (1.0, "base", 0.1)),
        (MESH, SPLIT, SCAN, 0.25, (0.0, "", inf)),  # in front of it
        (MESH, HERE, SCAN, 0.1, (0.0, "", inf)),  # the body that carries a scanner is ignored
        (BOX, SPLIT, SCAN, 0.1, (0.0, "", inf)),  # rays leave a simple solid
        (OPEN, HERE, CAMERA, 0.1, (0.0, "", inf)),
        (INVERTED, HERE, CAMERA, 0.1, (1.0, "base", 0.1)),
        (INVERTED, HERE, CAMERA, 0.25, (0.0, "", inf)),
        (MESH, HERE, CAMERA, 0.1, (0.0, "", inf)),  # the back of a surface is not drawn
        (MESH, SPLIT, CAMERA, 0.1, (0.0, "", inf)),
        (BOX, HERE, CAMERA, 0.1, (0.0, "", inf)),
        (BOX, HERE, CAMERA, -0.3, (1.0, "base", 0.1)),  # looks at its back from 0.1 m
        (BOX, SPLIT, SCAN, -0.3, (1.0, "base", 0.1)),
    ],
)  # fmt: skip
def test_what_covers_a_sensor_is_found_with_its_distance(
    tmp_path: Path, geometry: str, part: str, sensor: str, x: float, own: tuple[float, str, float]
) -> None:
    write(tmp_path / "shell.obj", FACES)
    write(tmp_path / "open.obj", [(a, c, b) for a, b, c in FACES[:-2]])
    write(tmp_path / "inverted.obj", [(a, c, b) for a, b, c in FACES])
    shape = f"<geometry>{geometry}</geometry>"
    shapes = f'<collision name="c">{shape}</collision><visual name="v">{shape}</visual>'
    base = f'<link name="base">{INERTIAL}{shapes}'
    text = f'<sdf version="1.6"><model name="robot">{base}{part.format(sensor.format(x))}</model></sdf>'
    (tmp_path / "robot.sdf").write_text(text)
    ((*covered, _),) = seen(read_model(tmp_path / "robot.sdf"))
    assert tuple(covered) == own


BARE = f'<sdf version="1.6"><model name="robot"><link name="base">{INERTIAL}{{}}</link></model></sdf>'


@pytest.mark.parametrize(
    ("sensor", "pitch", "empty"),
    [
        (CAMERA, -pi / 2, 1.0),
        (CAMERA, pi / 2, 0.0),
        (SCAN, 0.0, 1.0),
        (SCAN, pi / 4, 0.0),  # all beams lie in a plane that falls by at least cos(1) * 45 degrees
    ],
)
def test_a_sensor_that_sees_nothing_at_any_heading_is_found(
    tmp_path: Path, sensor: str, pitch: float, empty: float
) -> None:
    pitched = sensor.replace("{} 0 0 0 0 0", f"0 0 0 0 {pitch} 0")
    text = (
        f'<sdf version="1.6"><model name="robot"><link name="base">{INERTIAL}{pitched}</link></model></sdf>'
    )
    (tmp_path / "robot.sdf").write_text(text)
    assert seen(read_model(tmp_path / "robot.sdf")) == [(0.0, "", inf, empty)]


def test_a_wall_behind_a_robot_that_turns_is_seen(tmp_path: Path) -> None:
    (tmp_path / "robot.sdf").write_text(BARE.format(SCAN.format(0)))
    robot, wall = read_model(tmp_path / "robot.sdf"), Box((0.1, 20.0, 2.0))
    links = (Link("link", collisions=(Collision("c", wall),)),)
    behind = Model("wall", links, pose=Pose((-3.0, 0.0, 0.0)), static=True)
    scene = Scene((robot, behind))
    assert all(one.empty < 0.5 for one in sights(scene, robot))
    fixed = replace(robot, static=True)
    assert [one.empty for one in sights(Scene((fixed, behind)), fixed)] == [1.0]


def test_shipped_robots_see_their_rooms() -> None:
    found = []
    for name in nrp_core.shipped():
        experiment = nrp_core.load_experiment(name)
        if experiment.world.scene is not None and "/" not in name:
            scene = maker_of(experiment).room(experiment)
            for robot in experiment.world.robots:
                model = maker_of(experiment).robot(experiment, robot)
                found += list(sights(scene.with_model(model), model))
    assert len(found) > 2
    assert all(one.own < 0.5 and one.empty < 0.5 for one in found)


def robot(folder: Path, base: str, camera: str, more: str = "") -> Model:
    """Return a robot with visuals and a camera on its base."""
    link = f'<link name="base">{INERTIAL}{base}{camera}</link>{more}'
    (folder / "robot.sdf").write_text(f'<sdf version="1.6"><model name="robot">{link}</model></sdf>')
    return read_model(folder / "robot.sdf")


def visual(geometry: str, pose: str = "0 0 0 0 0 0", name: str = "v", alpha: float = 1.0) -> str:
    material = f"<material><diffuse>1 1 1 {alpha}</diffuse></material>"
    return f'<visual name="{name}"><pose>{pose}</pose><geometry>{geometry}</geometry>{material}</visual>'


@pytest.mark.parametrize(
    ("geometry", "x", "alpha", "through_m"),
    [
        (BOX, 0.0, 1.0, 0.2),
        (MESH, 0.0, 1.0, 0.2),
        ("<sphere><radius>0.2</radius></sphere>", -0.1, 1.0, 0.3),
        ("<cylinder><radius>0.2</radius><length>0.2</length></cylinder>", 0.15, 1.0, 0.05),
        (BOX, 0.0, 0.0, None),  # is invisible
        (BOX, 0.25, 1.0, None),
        (BOX, -0.25, 1.0, None),
        (INVERTED, 0.0, 1.0, None),  # its inside is drawn
        (OPEN, 0.0, 1.0, None),  # has no front
    ],
)
def test_a_camera_inside_a_shape_that_is_drawn_from_outside_is_found(
    tmp_path: Path, geometry: str, x: float, alpha: float, through_m: float | None
) -> None:
    write(tmp_path / "shell.obj", FACES)
    write(tmp_path / "open.obj", [(a, b, c) for a, b, c in FACES[:-2]])
    write(tmp_path / "inverted.obj", [(a, c, b) for a, b, c in FACES])
    one = robot(tmp_path, visual(geometry, alpha=alpha), CAMERA.format(x))
    found = list(enclosed(ROOM.with_model(one), one))
    if through_m is None:
        assert found == []
    else:
        ((link, sensor, shape),) = found
        assert (link, sensor.name, shape.model, shape.link) == ("base", "eye", "robot", "base")
        assert shape.through_m == pytest.approx(through_m, abs=0.002)  # round shapes have corners


def test_a_camera_inside_a_wall_of_the_room_is_found(tmp_path: Path) -> None:
    one = robot(tmp_path, "", CAMERA.format(0.4))
    wall = Link("panel", visuals=(Visual("v", Box((0.5, 4.0, 2.0))),))
    scene = ROOM.with_model(one).with_model(Model("wall", (wall,), pose=Pose((0.5, 0.0, 0.0)), static=True))
    ((_, _, shape),) = enclosed(scene, one)
    assert (shape.model, shape.link, round(shape.through_m, 6)) == ("wall", "panel", 0.35)


@pytest.mark.parametrize(
    ("size", "place", "middle"),
    [
        ("0.02 0.05 0.05", "0.1 0 0 0 0 0", 1.0),  # in front of the lens, with a third of the image
        ("0.02 0.05 0.05", "0.1 0.1 0 0 0 0", 0.0),
        ("0.02 0.4 0.2", "0.1 0 -0.12 0 0 0", 0.0),  # a hood below it
    ],
)
def test_the_middle_of_an_image_that_its_own_body_covers_is_measured(
    tmp_path: Path, size: str, place: str, middle: float
) -> None:
    one = robot(tmp_path, visual(f"<box><size>{size}</size></box>", place), CAMERA.format(0.0))
    (sight,) = sights(ROOM.with_model(one), one)
    assert sight.own < 0.5
    assert sight.middle == pytest.approx(middle, abs=0.3)
    assert sight.middle_m == (pytest.approx(0.09, abs=1e-3) if middle else inf)
