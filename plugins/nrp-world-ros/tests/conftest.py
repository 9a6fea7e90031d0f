"""Programs that meet in ROS, on loopback."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

pytest_plugins = ["cases", "golden"]  # in tests/shared

OPTION = "--ros"

needs_ros = pytest.mark.ros("1")
needs_ros2 = pytest.mark.ros("2")
needs_networks = pytest.mark.ros("networks")
needs_rviz = pytest.mark.ros("rviz")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        OPTION,
        default="",
        choices=("1", "2"),
        help="the ROS that must be here; by default any that is",
    )


def missing() -> dict[str, list[str]]:
    """Return what each ROS lacks on this machine."""
    ros1 = [name for name in ("rosmaster", "rostopic", "rosbag") if shutil.which(name) is None]
    ros1 += ["rospy in this Python"] if find_spec("rospy") is None else []
    ros1 += ["a Python without ROS 2, whose packages have the same names"] if find_spec("rclpy") else []
    ros2 = ["rclpy in this Python"] if find_spec("rclpy") is None else []
    rviz = [program for program in ("rviz", "Xvfb") if shutil.which(program) is None]
    return {"1": ros1, "2": ros2, "networks": _networks_lack(), "rviz": rviz}


def _networks_lack() -> list[str]:
    """Return what is missing for two networks of this user's own."""
    tools = [tool for tool in ("unshare", "nsenter", "ip") if shutil.which(tool) is None]
    if tools or not subprocess.run(["unshare", "-rn", "true"], capture_output=True, check=False).returncode:
        return tools
    return ["the right to make networks"]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip tests of a ROS that is not here, unless it must be."""
    lacks, required = missing(), config.getoption(OPTION).split(",")
    required += ["networks"] if "2" in required else []
    for item in items:
        for marker in item.iter_markers("ros"):
            (ros,) = marker.args
            if lacks[ros] and ros not in required:
                what = f"ROS {ros}" if ros in ("1", "2") else ros
                reason = f"{what} is not here ({', '.join(lacks[ros])}); the README says how to get it"
                item.add_marker(pytest.mark.skip(reason=reason))


class Programs:
    """Programs that run side by side until the test ends."""

    bridge: tuple[str, ...] = ()

    def __init__(self, folder: Path, **env: str) -> None:
        self.folder = folder
        self.env = {**os.environ, "PYTHONUNBUFFERED": "1", **env}
        self.started: list[subprocess.Popen[str]] = []

    @staticmethod
    def until(done: object, timeout_s: float = 60.0) -> None:
        end_s = time.monotonic() + timeout_s
        while not done():  # type: ignore[operator]
            assert time.monotonic() < end_s
            time.sleep(0.05)

    def start(self, *command: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            command,
            env=self.env,
            cwd=self.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.started.append(process)
        return process

    def nrp(self, *arguments: str) -> subprocess.Popen[str]:
        return self.start(sys.executable, "-m", "nrp_core", *arguments)

    def body(self, *arguments: str) -> subprocess.Popen[str]:
        """Start the world of the main experiment with small images, and wait until ROS knows it."""
        process = self.nrp(
            "ros-bridge", "braitenberg_husky", "--without-brain", "-s", "world.options.image_scale=0.25",
            *self.bridge, *arguments,
        )  # fmt: skip
        assert process.stdout is not None
        assert any(line.startswith("in ROS") for line in process.stdout)  # kernels may be compiled before
        return process

    def run(self, *command: str, timeout_s: float = 60.0) -> str:
        done = subprocess.run(
            command,
            env=self.env,
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def end(self) -> None:
        for process in self.started:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        for process in self.started:
            try:
                process.communicate(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()


class Ros(Programs):
    """A master of ROS 1, and programs that know it."""

    def __init__(self, folder: Path) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        super().__init__(
            folder,
            ROS_MASTER_URI=f"http://127.0.0.1:{self.port}",
            ROS_IP="127.0.0.1",
            ROS_LOG_DIR=str(folder / "log"),
        )
        self.master: subprocess.Popen[str] | None = None

    def start_master(self) -> None:
        self.master = self.start("rosmaster", "--core", "-p", str(self.port))
        self.until(self._listens)

    def _listens(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0


CALLS = """
import sys

from nrp_core import load_experiment, Run
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose

settings = ["world.backend=ros", f"world.options={{ros: {sys.argv[1]}, time: lockstep}}"]
with Run(load_experiment("braitenberg_husky", settings)) as run:
    run.run_until(0.1)
    home = run.result().final_pose["husky"]["x"]
    answer = run.world.call("/gazebo/set_model_state", ModelState("husky", Pose(Point(home + 1, 0, 0.2))))
    assert answer.success, answer
    run.run_until(0.2)
    assert abs(run.result().final_pose["husky"]["x"] - home - 1) < 0.1
    run.world.call("/gazebo/reset_world")
    run.run_until(0.3)
    assert abs(run.result().final_pose["husky"]["x"] - home) < 0.1
    assert "did you mean" in run.world.call("/gazebo/delete_model", "huskie").status_message
"""
"""A loop that moves and resets its body by the services that the body has in ROS."""

PEER = Path(__file__).with_name("ros2_peer.py")
DOMAIN = 1 + os.getpid() % 100


class Ros2(Programs):
    """Programs in a domain of ROS 2 that no other test is in at the same time, on loopback."""

    bridge = ("--ros2",)
    domain = DOMAIN

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, ROS_DOMAIN_ID=str(DOMAIN), ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST")

    def peer(self, *arguments: str) -> subprocess.Popen[str]:
        """Start a node of ROS 2 that knows nothing of the platform."""
        return self.start(sys.executable, str(PEER), *arguments)

    def ready_peer(self, *arguments: str) -> subprocess.Popen[str]:
        """Start one, and wait until it has made its topics."""
        process = self.peer(*arguments)
        assert process.stdout is not None
        assert process.stdout.readline().strip() == "ready"
        return process


@pytest.fixture(scope="module")
def no_idle_bodies() -> Iterator[None]:
    """Leave no process that waits for a world, and no node that would meet it."""
    yield
    from nrp_world_ros.hosted.hosts import end_idle

    end_idle()


@pytest.fixture
def ros2(tmp_path: Path) -> Iterator[Ros2]:
    programs = Ros2(tmp_path)
    yield programs
    programs.end()


@pytest.fixture(scope="module")
def bridged(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros]:
    """Programs of ROS 1 beside a body that all tests of a module share: each may leave it anywhere."""
    ros = Ros(tmp_path_factory.mktemp("ros"))
    ros.start_master()
    ros.body()
    yield ros
    ros.end()


@pytest.fixture
def no_master(tmp_path: Path) -> Iterator[Ros]:
    ros = Ros(tmp_path)
    yield ros
    ros.end()


@pytest.fixture
def ros(no_master: Ros) -> Ros:
    no_master.start_master()
    return no_master
