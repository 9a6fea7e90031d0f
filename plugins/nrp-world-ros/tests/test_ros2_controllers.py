"""Controllers and the simulator as programs of ROS 2 use them: actions, services and parameters, by rclpy."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from conftest import Ros2, needs_ros2

LINK = """<link name="l{0}"><inertial><mass value="1"/><origin xyz="0.2 0 0"/>
<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision></link>
<joint name="j{0}" type="revolute"><origin xyz="{0} 0 1"/><parent link="world"/><child link="l{0}"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="5"/></joint>"""
ROBOT = f"""<robot name="arm"><link name="world"/>{"".join(LINK.format(number) for number in (1, 2, 3))}
<gazebo><plugin name="c" filename="libgz_ros2_control-system.so"><parameters>c.yaml</parameters>
</plugin></gazebo></robot>"""
ROOM = """<sdf version="1.9"><world name="room"><model name="post"><static>true</static>
<pose>3.3 0 0.75 0 0 0</pose><link name="l"><collision name="c"><geometry><box><size>0.1 0.1 0.1</size></box>
</geometry></collision></link></model></world></sdf>"""
CONTROLLERS = """
controller_manager:
  ros__parameters:
    follow: {type: joint_trajectory_controller/JointTrajectoryController}
    hand: {type: position_controllers/GripperActionController}
follow:
  ros__parameters: {joints: [j1, j2]}
hand:
  ros__parameters: {joint: j3}
"""
EXPERIMENT = """
name: arm
timestep: 10 ms
duration: 1000 s
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf, robots: {arm: {model: arm.urdf}}}
"""
BRAIN = "import pyNN.nest as sim\nsim.setup()\ncells = sim.Population(1, sim.IF_curr_exp())\n"


def answers(ros2: Ros2, *arguments: str) -> Any:
    said = ros2.run(
        sys.executable, str(Path(__file__).with_name("ros2_clients.py")), *arguments, timeout_s=240
    )
    return json.loads(said.splitlines()[-1])


@contextmanager
def running(folder: Path) -> Iterator[Ros2]:
    """Run an arm behind the bridge."""
    folder.mkdir(exist_ok=True)
    (folder / "arm.urdf").write_text(ROBOT)
    (folder / "c.yaml").write_text(CONTROLLERS)
    (folder / "arm.yaml").write_text(EXPERIMENT)
    (folder / "room.sdf").write_text(ROOM)
    (folder / "brain.py").write_text(BRAIN)
    ros2 = Ros2(folder)
    body = ros2.nrp("ros-bridge", "arm.yaml", "--without-brain", "--ros2")
    assert body.stdout is not None
    lines = []
    for line in body.stdout:
        lines.append(line)
        if line.startswith("in ROS"):
            break
    try:
        assert lines[-1].startswith("in ROS"), "".join(lines)
        yield ros2
    finally:
        ros2.end()


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros2]:
    """An arm that the tests of this file share."""
    with running(tmp_path_factory.mktemp("arm")) as ros2:
        yield ros2


@needs_ros2
def test_trajectories_are_followed_replaced_cancelled_and_refused(arm: Ros2) -> None:
    found = answers(arm, "follow")
    assert found["reached"]["status"] == 4  # GoalStatus.STATUS_SUCCEEDED
    assert found["reached"]["at"] == pytest.approx([0.5, -0.4], abs=0.03)  # 50 ms before the end
    assert found["reached"]["feedback"] >= 3
    assert found["unknown joint"] == found["without positions"] == "rejected"
    assert (found["narrow"]["status"], found["narrow"]["code"]) == (6, -4)  # aborted on its path
    assert found["cancelled"]["status"] == 5
    assert abs(found["cancelled"]["at"][0]) < 1.0  # it was on its way to 1.5
    assert (found["replaced"]["status"], found["after"]["status"]) == (6, 4)


@needs_ros2
def test_a_gripper_reaches_a_position_and_stalls_at_an_obstacle(arm: Ros2) -> None:
    found = answers(arm, "grip")
    assert found["open"]["reached"]
    assert found["open"]["position"] == pytest.approx(-0.3, abs=0.01)
    assert (found["closed"]["reached"], found["closed"]["stalled"]) == (False, True)
    assert 0.2 < found["closed"]["position"] < 1.0  # the post is in its way to 1.5


@needs_ros2
def test_services_of_controllers_and_simulators_and_parameters_answer(arm: Ros2) -> None:
    found = answers(arm, "standard")
    assert found["controllers"] == {
        "follow": "joint_trajectory_controller/JointTrajectoryController",
        "hand": "position_controllers/GripperActionController",
    }
    assert found["switch"] == [True, False]
    assert "robot_description" in found["parameters"]
    assert found["description"].startswith("<robot")
    assert "arm" in found["entities"]
    assert found["spawned"] == ["box", "box_1"]
    assert found["refused"] == [104, 104, 102, 101, 0, 0]
    assert found["filters"] == [4, 4, 4]
    assert found["height"] == pytest.approx(5.0, abs=0.01)
    assert (found["set in base"], found["set in world"]) == (0, 1)  # not supported; ok
    assert found["moved"] == pytest.approx([7.0, 0.0, 1.0])
    assert (found["reset 1"], found["reset 2"]) == (0, 1)
    assert found["back"] == pytest.approx([3.3, 0.0, 0.75])
    assert found["missing"] == 2
    assert found["deleted"] == [1, 1]
    assert found["states"] == [1, 1, 2, 101, 1]  # playing; paused once, and not again; continued
    assert 10 in found["features"]
