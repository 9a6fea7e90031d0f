"""The torque that a load cell reports is about its own origin, wherever the joint and its links are."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from jointed import GRAVITY, MASS, axis, joint, limit, link

from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_scene

CELL = """<sensor name="cell" type="force_torque"><pose>0.1 0 0.2 {roll} 0 0</pose>
<update_rate>50</update_rate><force_torque><frame>{frame}</frame></force_torque></sensor>"""
PLUGIN = """<plugin name="cell" filename="libgazebo_ros_ft_sensor.so"><jointName>j</jointName>
<topicName>cell</topicName><updateRate>50</updateRate></plugin>"""


@pytest.fixture
def hung(tmp_path):
    """Read a bob that a joint away from its frame holds; its centre of mass is beside both."""

    def read(cell: str, plugin: str = "") -> Scene:
        bob = link("bob", com=(0.5, 0.3, 0.0), at=(0.0, 0.0, 2.0))
        held = joint("revolute", f"<pose>0.2 0 0 0 0 0</pose>{axis('1 0 0', limit(0, 0))}{cell}")
        path = tmp_path / "room.sdf"
        path.write_text(
            f'<sdf version="1.9"><world name="w"><model name="robot"><pose>0 0 0 0 0 {pi / 2}</pose>'
            f"{bob}{held}{plugin}</model></world></sdf>"
        )
        return read_scene(path)

    return read


def wrench(world, topic: str, advance) -> np.ndarray:
    heard = world.subscribe(topic)
    advance(world, 0.5)
    felt = heard.latest.message.wrench
    return np.array([[each.x, each.y, each.z] for each in (felt.force, felt.torque)])


@pytest.mark.parametrize(("frame", "roll"), [("child", 0.0), ("sensor", pi / 2)])
def test_a_torque_is_about_the_origin_of_its_sensor(open_world, advance, hung, frame, roll) -> None:
    """The sensor is at (0.3, 0, 0.2) in the bob, whose weight acts at (0.5, 0.3, 0)."""
    world = open_world(hung(CELL.format(frame=frame, roll=roll)))
    weight = np.array([0.0, 0.0, -MASS * GRAVITY])
    expected = np.array([weight, np.cross([0.2, 0.3, -0.2], weight)])
    if frame == "sensor":  # its y points up, and its z back along y
        expected = np.array([[x, z, -y] for x, y, z in expected])
    assert wrench(world, "/robot/j/cell/forcetorque", advance) == pytest.approx(expected, abs=0.02)


def test_a_torque_of_gazebo_classics_plugin_is_about_the_origin_of_the_joint(
    open_world, advance, hung
) -> None:
    world = open_world(hung("", PLUGIN))
    weight = np.array([0.0, 0.0, -MASS * GRAVITY])
    expected = np.array([weight, np.cross([0.3, 0.3, 0.0], weight)])
    assert wrench(world, "/robot/cell", advance) == pytest.approx(expected, abs=0.02)
