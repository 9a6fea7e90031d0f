"""Models that launch files of ROS spawn take part; a robot that none brings makes the run incomplete."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

_URDF = """<robot name="any" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="base">
<xacro:property name="mass" value="2"/><inertial><mass value="${mass}"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link></robot>"""
_LAUNCH = """<launch><arg name="real" default="false"/><arg name="height" default="0.3"/>
<param name="{name}" command="$(find xacro)/xacro --inorder '$(find my_robot)/urdf/{file}'"/>
<group if="$(arg real)"><node pkg="gazebo_ros" type="spawn_model" name="a"
  args="-urdf -file $(find my_robot)/no.urdf -model real"/></group>
<group ns="/x"><node pkg="gazebo_ros" type="spawn_model" name="b"
  args="-urdf -param robot_description -model mobile -x 1.5 -z $(arg height) -Y 0.5"/></group></launch>"""
_OUTER = """<launch><include file="$(find my_robot)/launch/inner.launch">
<arg name="height" value="0.25"/></include><node pkg="tools" type="plot.py" name="plot"/></launch>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    package = tmp_path / "ros" / "my_robot"
    for name in ("urdf", "launch"):
        (package / name).mkdir(parents=True)
    (package / "urdf" / "m.urdf.xacro").write_text(_URDF)
    (package / "launch" / "inner.launch").write_text(
        _LAUNCH.format(name="robot_description", file="m.urdf.xacro")
    )
    (tmp_path / "outer.launch").write_text(_OUTER)
    (tmp_path / "x.bibi").write_text("<bibi/>")
    (tmp_path / "x.exc").write_text(
        '<ExD><environmentModel src="room.sdf"/><bibiConf src="x.bibi"/><rosLaunch src="outer.launch"/></ExD>'
    )
    (tmp_path / "room.sdf").write_text(
        '<sdf version="1.6"><world name="w"><model name="floor"><static>1</static><link name="l">'
        '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>'
        "</link></model></world></sdf>"
    )
    return tmp_path


def _left_out(folder: Path) -> list[str]:
    with Run(read_exc(folder / "x.exc")) as run:
        run.run_until(0.02)
        return [one.message for one in run.problems if one.code is Code.NRP256]


def test_the_model_that_included_files_spawn_takes_part_at_its_pose(folder: Path) -> None:
    with Run(read_exc(folder / "x.exc")) as run:
        pose = run.world.model_motion("mobile").pose
        assert (*pose.position, pose.rpy[2]) == pytest.approx((1.5, 0.0, 0.25, 0.5))
        assert run.world.scene.model("mobile").links[0].inertial.mass == 2
        assert run.experiment.world.robots.keys() == {"mobile"}
        run.run_until(0.1)
        assert run.result().complete


def test_a_spawned_model_without_a_file_is_left_out(folder: Path) -> None:
    inner = folder / "ros" / "my_robot" / "launch" / "inner.launch"
    inner.write_text(_LAUNCH.format(name="robot_description", file="gone.urdf"))
    said = _left_out(folder)
    assert "robot 'mobile', which 'outer.launch' spawns, not found: left out" in said


def test_a_launch_file_that_spawns_nothing_leaves_a_run_without_a_robot(folder: Path) -> None:
    (folder / "outer.launch").write_text("<launch><node pkg='p' type='t.py' name='n'/></launch>")
    assert _left_out(folder) == ["no robot takes part: the launch file brings none, and the room has none"]
    room = folder / "room.sdf"
    arm = """<model name="arm"><link name="a"/><link name="b"/>
<joint name="fix" type="fixed"><parent>world</parent><child>a</child></joint><joint name="j" type="revolute">
<parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz></axis></joint></model></world>"""
    room.write_text(room.read_text().replace("</world>", arm))
    assert _left_out(folder) == []  # the room has the robot


def test_an_actor_of_the_room_is_left_out(folder: Path) -> None:
    room = folder / "room.sdf"
    walker = "<actor name='walker'><skin><filename>walk.dae</filename></skin></actor></world>"
    room.write_text(room.read_text().replace("</world>", walker))
    assert _left_out(folder) == ["an <actor> of the room is left out: it is not simulated"]
