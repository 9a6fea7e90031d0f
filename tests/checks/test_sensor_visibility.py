"""Scanners and cameras that see only their own robot are found, with the distance."""

from __future__ import annotations

from itertools import product
from math import inf
from pathlib import Path

import pytest

import nrp_core
from nrp_core.checks.subjects.sensor_visibility import own_robot_views
from nrp_core.checks.validate import validate_file
from nrp_core.experiment.making.maker import maker_of
from nrp_core.findings import Code
from nrp_core.scene.model import Box, Collision, Link, Model, Scene, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model

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


@pytest.mark.parametrize(
    ("geometry", "part", "sensor", "x", "own"),
    [
        (MESH, SPLIT, SCAN, 0.1, (1.0, 0.1)),
        (MESH, SPLIT, SCAN, 0.25, (0.0, inf)),  # in front of it
        (MESH, HERE, SCAN, 0.1, (0.0, inf)),  # the body that carries a scanner is ignored
        (BOX, SPLIT, SCAN, 0.1, (0.0, inf)),  # rays leave a simple solid
        (OPEN, HERE, CAMERA, 0.1, (0.0, inf)),
        (INVERTED, HERE, CAMERA, 0.1, (1.0, 0.1)),
        (INVERTED, HERE, CAMERA, 0.25, (0.0, inf)),
        (MESH, HERE, CAMERA, 0.1, (0.0, inf)),  # the back of a surface is not drawn
        (BOX, HERE, CAMERA, -0.3, (1.0, 0.1)),  # its back is 0.1 m ahead
        (BOX, SPLIT, SCAN, -0.3, (1.0, 0.1)),
    ],
)  # fmt: skip
def test_a_shape_that_covers_a_sensor_is_found_with_its_distance(
    tmp_path: Path, geometry: str, part: str, sensor: str, x: float, own: tuple[float, float]
) -> None:
    write(tmp_path / "shell.obj", FACES)
    write(tmp_path / "open.obj", [(a, c, b) for a, b, c in FACES[:-2]])
    write(tmp_path / "inverted.obj", [(a, c, b) for a, b, c in FACES])
    shape = f"<geometry>{geometry}</geometry>"
    shapes = f'<collision name="c">{shape}</collision><visual name="v">{shape}</visual>'
    base = f'<link name="base">{INERTIAL}{shapes}'
    text = f'<sdf version="1.6"><model name="robot">{base}{part.format(sensor.format(x))}</model></sdf>'
    (tmp_path / "robot.sdf").write_text(text)
    robot = read_model(tmp_path / "robot.sdf")
    (found,) = own_robot_views(ROOM.with_model(robot), robot)
    assert (found.share, round(found.nearest_m, 2)) == own


def test_shipped_robots_see_their_rooms() -> None:
    found = []
    for name in nrp_core.shipped():
        experiment = nrp_core.load_experiment(name)
        if experiment.world.scene is not None and "/" not in name:
            scene = maker_of(experiment).room(experiment)
            for robot in experiment.world.robots:
                model = maker_of(experiment).robot(experiment, robot)
                found += list(own_robot_views(scene.with_model(model), model))
    assert len(found) > 2
    assert all(one.share < 0.5 for one in found)


RIG = "<pose>0 0 0.132 0 0 0</pose>"


@pytest.mark.parametrize(
    ("pose", "is_reported"), [(RIG, False), ("<pose>0.1 0 0.06 0 1.5708 0</pose>", True)]
)
def test_a_camera_that_sees_only_its_robot_is_reported(husky: Path, pose: str, is_reported: bool) -> None:
    """The second one looks down at the deck."""
    path = husky / "husky.sdf"
    assert RIG in path.read_text()
    path.write_text(path.read_text().replace(RIG, pose))
    found = validate_file(husky / "experiment.yaml")
    assert [one.code for one in found if one.code is Code.NRP374] == [Code.NRP374] * is_reported
