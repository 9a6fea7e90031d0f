"""The processes that simulate bodies for this one.

Starting one takes a second, as does its discovery in ROS; so a process without a body is kept for the next
one.
"""

from __future__ import annotations

import atexit
import os
import pickle
import secrets
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from nrp_core.errors import SimulationError
from nrp_core.world import Closing, Finding, Scene

from nrp_world_ros.hosted.dialogue import Answer, Notes
from nrp_world_ros.ros2.node import Ros2Node, domain_number, load_rclpy
from nrp_world_ros.timekeeping import DONE, GO, Turn

_KEPT = 4
"""Number of processes without a body that are kept."""

_KEY_BYTES = 32

POLL_S = 0.0005
"""Polling period of the discovery; on loopback discovery takes some ms."""


@dataclass(frozen=True, slots=True)
class Order:
    """A request for a simulation: a scene, a seed, a backend and its options."""

    scene: Scene
    seed: int
    body: str
    options: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class HostNamespace:
    """The namespace of the two processes in ROS, and their secret key."""

    namespace: str
    key: bytes


@dataclass(frozen=True, slots=True)
class Opened:
    """The description of an opened world; see :class:`~nrp_core.world.world.World`."""

    warnings: tuple[Finding, ...]
    image_scale: float


class _MeetingNode(Ros2Node):
    """A node that also checks whether the other process lives."""

    def __init__(self, domain: int, look: Callable[[], None]) -> None:
        super().__init__("nrp_loop", domain=domain)
        self._look = look

    def check(self) -> None:
        super().check()
        self._look()


class Host(Closing):
    """A process that simulates one body at a time, and this process's node for it.

    Requests go to its standard input, and first answers come from its standard output; all else goes over
    ROS. Its standard input closes when this process ends, and then it ends, too.

    Args:
        domain: the domain of ROS 2.

    Attributes:
        node: the node of this process.
        notes: for requests to this body.

    Raises:
        BackendLoadError: ROS 2 is not installed, or cannot use the network.
    """

    def __init__(self, domain: int) -> None:
        load_rclpy()  # fails here if something is missing, before a process is started
        self.domain = domain
        self._simulates = "nothing yet"
        self._places = 0
        command = [sys.executable, "-P", "-m", "nrp_world_ros.hosted.host", str(domain)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        try:
            self.node = _MeetingNode(domain, self._look)
        except BaseException:
            self._end()
            raise

    def open(self, order: Order) -> Opened:
        """Request a world, and connect to it in a separate namespace of ROS.

        Raises:
            SimulationError: the process has ended.
            Exception: the exception raised there.
        """
        self._simulates = order.body
        self._places += 1
        place = HostNamespace(
            f"/nrp/host_{self._process.pid}/world_{self._places}", secrets.token_bytes(_KEY_BYTES)
        )
        self.notes = Notes(place.key)
        self.node.move(place.namespace)
        self.node.publisher(GO, Turn)
        self.node.listen(DONE, Turn)
        opened: Opened = self._told(order, place)
        await_other(self.node)
        return opened

    def _told(self, *said: object) -> Any:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        data = pickle.dumps(said)
        try:
            self._process.stdin.write(data)
            self._process.stdin.flush()
            answer: Answer = pickle.load(self._process.stdout)
        except (OSError, EOFError):
            self._process.wait()
            self._look()
            raise
        return answer.taken()

    def _look(self) -> None:
        code = self._process.poll()
        if code is not None:
            how = f"was ended by signal {-code}" if code < 0 else f"has ended with exit code {code}"
            raise SimulationError(f"the process that simulates the body by '{self._simulates}' {how}")

    @property
    def lives(self) -> bool:
        """Whether the process is alive."""
        return self._process.poll() is None

    def close(self) -> None:
        """End the process."""
        self.node.close()
        self._end()

    def _end(self) -> None:
        self._process.kill()
        self._process.communicate()


def await_other(node: Ros2Node, *, there: bool = True) -> None:
    """Wait until both have discovered each other, or until the other has left."""
    while any((node.peers(topic) > 0) is not there for topic in (GO, DONE)):
        node.check()
        time.sleep(POLL_S)


_idle: dict[int, list[Host]] = {}
"""Hosts by process id, because a fork of this process has none."""


def borrow(domain: int | None) -> Host:
    """Return a host without a body; start one if necessary."""
    number = domain_number(domain)
    idle = _idle.setdefault(os.getpid(), [])
    for host in [host for host in reversed(idle) if host.domain == number]:
        idle.remove(host)
        if host.lives:
            return host
        host.close()
    return Host(number)


def give_back(host: Host, *, usable: bool) -> None:
    """Keep a host for the next world, or end it."""
    idle = _idle.setdefault(os.getpid(), [])
    if usable and host.lives and len(idle) < _KEPT:
        host.node.move("")
        idle.append(host)
    else:
        host.close()


@atexit.register
def end_idle() -> None:
    """End the processes without a world; called at the end of this process."""
    for host in _idle.pop(os.getpid(), []):
        with suppress(SimulationError):
            host.close()
