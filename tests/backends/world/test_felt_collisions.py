"""Contact sensors feel the collisions that files for Gazebo name, in its own way of naming them."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.scene.model import Model
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model

ROBOT = """<robot name="vacuum">
<link name="base"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
  <collision name="shell"><origin xyz="0 0 0.5"/><geometry><box size="0.2 0.2 0.2"/></geometry>
  </collision></link>
<link name="foot"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
  <collision><geometry><box size="0.4 0.4 0.2"/></geometry></collision></link>
<joint name="held" type="fixed"><parent link="base"/><child link="foot"/></joint>
<gazebo reference="base"><sensor name="bump" type="contact"><update_rate>50</update_rate>
<contact><collision>{}</collision></contact>{}</sensor></gazebo></robot>"""
PLUGIN = """<plugin name="p" filename="libgazebo_ros_bumper.so"><ros><namespace>/</namespace>
<remapping>bumper_states:=hit</remapping></ros></plugin>"""


def vacuum(folder: Path, named: str, plugin: str = "") -> Model:
    (folder / "vacuum.urdf").write_text(ROBOT.format(named, plugin))
    return read_model(folder / "vacuum.urdf", pose=Pose((0.0, 0.0, 0.1)))


@pytest.mark.parametrize(
    ("named", "felt"),
    [
        ("shell", "shell"),
        ("shell_collision", "shell"),
        ("base_fixed_joint_lump__foot_collision", "foot::foot_collision"),
        ("base_fixed_joint_lump__foot_collision_1", "foot::foot_collision"),
        ("vacuum::base::shell", "shell"),
    ],
)
def test_names_of_gazebo_classic_are_those_of_the_file(tmp_path: Path, named: str, felt: str) -> None:
    model = vacuum(tmp_path, named)
    assert model.link("base").sensors[0].collisions == (felt,)
    assert model.warnings == ()


@pytest.mark.parametrize(
    ("named", "touches"), [("base_fixed_joint_lump__foot_collision", True), ("shell", False)]
)
def test_a_sensor_feels_the_link_that_is_fixed_to_its_own(
    open_world, advance, parts, tmp_path: Path, named: str, touches: bool
) -> None:
    """The foot stands on the floor, and the shell 40 cm above it touches nothing."""
    world = open_world(parts.floor(), vacuum(tmp_path, named, PLUGIN))
    felt = world.subscribe("/hit")
    advance(world, 0.5)
    states = felt.latest.message.states
    assert {each.collision1_name for each in states} == (
        {"vacuum::foot::foot_collision"} if touches else set()
    )
