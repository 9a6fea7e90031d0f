"""A loop at wall time and a robot that is not simulated: deadlines, and that it is always stopped."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from conftest import Ros2, needs_ros2

ROBOT = Path(__file__).with_name("ros2_robot.py")
CART = """<sdf version="1.9"><model name="cart"><link name="base"><inertial><mass>10</mass></inertial></link>
<plugin name="move" filename="libgazebo_ros_planar_move.so"><commandTopic>/cart/cmd_vel</commandTopic>
<odometryTopic>/cart/odom</odometryTopic></plugin></model></sdf>"""
EXPERIMENT = """
name: drive
timestep: 20 ms
duration: {duration}
brain: {{backend: event, model: brain.py}}
world:
  backend: ros
  scene: room.sdf
  robots: {{cart: {{model: cart.sdf}}}}
  options: {{ros: 2, time: wall, timestep: 20 ms, patience: {patience}, stop_after: 200 ms{more}}}
transfer_functions: [functions.py]
"""
BRAIN = "import pyNN.nest as sim\nsim.setup()\ncells = sim.Population(1, sim.IF_curr_exp())\n"
FUNCTIONS = """
import time

import nrp_core.dsl as nrp
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry


@nrp.MapRobotPublisher("drive", nrp.Topic("/cart/cmd_vel", Twist))
@nrp.MapRobotSubscriber("odom", nrp.Topic("/cart/odom", Odometry))
@nrp.Neuron2Robot()
def go(t, drive, odom):
    if HANG and 1.0 < t < 1.03:
        time.sleep(1.0)
    drive.send_message(Twist(Vector3(0.5, 0, 0)))
"""

Drive = Callable[..., tuple[subprocess.Popen[str], subprocess.Popen[str]]]


@pytest.fixture
def drive(ros2: Ros2) -> Drive:
    """Start a robot and the loop that drives it."""

    def start(duration: str, *robot: str, hang: bool = False, patience: str = "20 s", more: str = "") -> Any:
        folder = ros2.folder
        (folder / "cart.sdf").write_text(CART)
        (folder / "room.sdf").write_text('<sdf version="1.9"><world name="room"/></sdf>')
        (folder / "brain.py").write_text(BRAIN)
        (folder / "functions.py").write_text(FUNCTIONS.replace("HANG", str(hang)))
        (folder / "drive.yaml").write_text(EXPERIMENT.format(duration=duration, patience=patience, more=more))
        there = ros2.start(sys.executable, str(ROBOT), *robot)
        assert there.stdout is not None
        assert there.stdout.readline().strip() == "ready"
        loop = ros2.nrp("run", "drive.yaml", "--json")
        assert there.stdout.readline().strip() == "moving"
        return there, loop

    return start


def told(robot: subprocess.Popen[str]) -> Any:
    """End the robot, and return what it received."""
    robot.terminate()
    said, _ = robot.communicate(timeout=60)
    return json.loads(said.splitlines()[-1])


@needs_ros2
@pytest.mark.slow
def test_late_steps_are_counted_and_stop_the_robot_until_they_are_made_up(drive: Drive) -> None:
    robot, loop = drive("4 s", hang=True)
    said, _ = loop.communicate(timeout=120)
    found = json.loads(said[said.index("{") :])
    (late,) = [each for each in found["problems"] if each["code"] == "NRP278"]
    assert "stopped 1 times" in late["message"]
    commands = told(robot)["commands"]
    speeds = [speed for _, speed in commands]
    first = speeds.index(0.0)
    assert set(speeds[:first]) == {0.5}
    assert 0.5 in speeds[first:]  # it goes on
    assert speeds[-1] == 0.0


@needs_ros2
@pytest.mark.slow
@pytest.mark.parametrize("stamped", [False, True])
def test_a_killed_loop_leaves_a_robot_that_stands(drive: Drive, stamped: bool) -> None:
    robot, loop = drive("90 s", "stamped", more=", stamped: true") if stamped else drive("90 s")
    loop.kill()
    loop.communicate()
    time.sleep(3)
    speeds = [speed for _, speed in told(robot)["commands"]]
    assert 0.5 in speeds
    assert speeds[-5:] == [0.0] * 5


@needs_ros2
@pytest.mark.slow
def test_a_robot_that_sends_nothing_ends_the_run(drive: Drive) -> None:
    robot, loop = drive("90 s", patience="3 s")
    robot.kill()
    said, _ = loop.communicate(timeout=120)
    assert loop.returncode == 1
    assert "has sent nothing for 3 s" in said
