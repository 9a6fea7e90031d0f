"""A ROS master on loopback, and programs that know it."""

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

NEEDED = [name for name in ("rosmaster", "rostopic") if shutil.which(name) is None]
if find_spec("rospy") is None:
    NEEDED.append("rospy in this Python")

needs_ros = pytest.mark.skipif(
    bool(NEEDED), reason=f"ROS 1 is not here ({', '.join(NEEDED)}); the README says how to get it"
)


class Ros:
    """A master, and programs that run beside it until the test ends."""

    def __init__(self, folder: Path) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.folder = folder
        self.env = {
            **os.environ,
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "ROS_IP": "127.0.0.1",
            "ROS_LOG_DIR": str(folder / "log"),
            "PYTHONUNBUFFERED": "1",
        }
        self.started: list[subprocess.Popen[str]] = []
        self.master: subprocess.Popen[str] | None = None

    def start_master(self) -> None:
        self.master = self.start("rosmaster", "--core", "-p", str(self.port))
        self.until(self._listens)

    def _listens(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

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
        """Start the world of the main experiment with small pictures, and wait until ROS knows it."""
        process = self.nrp(
            "ros-bridge", "braitenberg_husky", "--without-brain", "-s", "world.options.image_scale=0.25",
            *arguments,
        )  # fmt: skip
        assert process.stdout is not None
        assert process.stdout.readline().startswith("in ROS")
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


@pytest.fixture
def no_master(tmp_path: Path) -> Iterator[Ros]:
    ros = Ros(tmp_path)
    yield ros
    ros.end()


@pytest.fixture
def ros(no_master: Ros) -> Ros:
    no_master.start_master()
    return no_master
