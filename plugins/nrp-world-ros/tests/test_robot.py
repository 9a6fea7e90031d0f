"""A loop at wall time and a robot that is not simulated: deadlines, and that it is always stopped."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from nrp_core.errors import SimulationError
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.world import Code, Scene, World, read_scene

from conftest import Ros2, needs_ros2
from nrp_world_ros import RosBackend, RosOptions
from nrp_world_ros.guard import TwistStamped
from nrp_world_ros.joining import join
from nrp_world_ros.options import Ros, TimeSource

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


VALVE = """<mujoco><worldbody><body name="valve"><joint name="j"/><geom size="0.1"/></body></worldbody>
<actuator><general name="m" joint="j" dyntype="integrator" ctrlrange="-1 1"/></actuator></mujoco>"""


def at_wall_time(folder: Path, **options: Any) -> World:
    """Open a loop that drives a cart, whose controller also takes stamped commands, and a valve."""
    (folder / "cart.sdf").write_text(CART.replace("/cart/cmd_vel", "/cart/base/cmd_vel_unstamped"))
    (folder / "valve.xml").write_text(VALVE)
    models = [model for name in ("cart.sdf", "valve.xml") for model in read_scene(folder / name).models]
    chosen = RosOptions(ros=Ros.TWO, time=TimeSource.WALL, patience="4 s", **options)
    return RosBackend().open(Scene(tuple(models)), seed=1, options=chosen)


@needs_ros2
def test_only_velocities_are_stamped_and_end_with_zero(ros2: Ros2) -> None:
    """A drive of ros2_control takes stamped velocities on ``cmd_vel``, and others elsewhere."""
    with join(Ros.TWO, "robot", domain=ros2.domain) as node:
        node.listen("/cart/base/cmd_vel", TwistStamped)
        node.listen("/valve/m/cmd", Float64)
        with at_wall_time(ros2.folder, domain=ros2.domain, stamped=True) as world:
            drive = world.advertise("/cart/base/cmd_vel_unstamped")
            valve = world.advertise("/valve/m/cmd")
            for step in range(20):
                drive.publish(Twist(Vector3(0.5)))
                valve.publish(Float64(0.3))
                world.run_until((step + 1) * 20_000_000)
        letters = node.inbox.take()
    speeds = [each.message.twist.linear.x for each in letters if each.topic == "/cart/base/cmd_vel"]
    assert 0.5 in speeds
    assert speeds[-5:] == [0.0] * 5  # the guard's, too, although the first command came before the first step
    assert {each.message.data for each in letters if each.topic == "/valve/m/cmd"} == {0.3}


class Clock:
    """A clock that stands still but for sleep."""

    now_ns = 0

    def monotonic_ns(self) -> int:
        return self.now_ns

    def sleep(self, duration_s: float) -> None:
        self.now_ns += round(duration_s * 1e9)


@needs_ros2
def test_steps_that_are_late_by_less_than_a_step_are_not_reported(
    ros2: Ros2, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, step_ns = Clock(), 20_000_000
    monkeypatch.setattr("nrp_world_ros.timekeeping.time", clock)
    with at_wall_time(ros2.folder, domain=ros2.domain) as world:
        for spent, codes in ((1.0, []), (1.9, []), (2.1, [Code.NRP278])):
            clock.now_ns += round(spent * step_ns)
            for _ in range(3):  # it catches up
                world.run_until(world.now_ns + step_ns)
            found = [each for each in world.engine.warnings if each.subject == "time"]
            assert [each.code for each in found] == codes
    assert "3 of 8 steps" in found[0].message  # until then


@needs_ros2
def test_silence_before_the_first_step_does_not_count(ros2: Ros2, monkeypatch: pytest.MonkeyPatch) -> None:
    """A brain may take minutes to build; robots send a message now and then."""
    waited_s = [0.0]
    late = SimpleNamespace(monotonic=lambda: time.monotonic() + waited_s[0], sleep=time.sleep)
    monkeypatch.setattr("nrp_world_ros.engine.time", late)
    with at_wall_time(ros2.folder, domain=ros2.domain) as world:
        for begins in (lambda: None, world.reset):
            begins()
            waited_s[0] += 100.0
            world.run_until(20_000_000)
        waited_s[0] += 100.0
        with pytest.raises(SimulationError, match="nothing"):
            world.run_until(40_000_000)
