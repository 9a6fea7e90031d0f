"""A process that stops a robot when the loop that drives it is late, hangs, or has ended in any way.

It holds one end of a pipe. The loop writes a line for each drive that it commands, and one in each step. If
a step is late, or the pipe is closed because the loop was killed, the guard sends a velocity of zero to these
drives. It is a process of its own, because a loop that hangs or is killed cannot send anything.

``python -m nrp_world_ros.guard ROS DOMAIN STOP_AFTER_S`` runs it; a domain of -1 is that of the environment.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from contextlib import suppress
from typing import Any

from nrp_core.errors import SimulationError
from nrp_core.messages.base import Time
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.std_msgs import Header

from nrp_world_ros.joining import join
from nrp_world_ros.node import Node, Publisher, ros_type
from nrp_world_ros.options import Ros

TwistStamped: Any = ros_type("geometry_msgs/msg/TwistStamped")
UNSTAMPED = "_unstamped"
"""The end of the topic of a drive whose controller takes ``TwistStamped`` on a topic without it."""

STOPS_S = 1.0
"""How long the guard sends velocities of zero after the end of the loop, s; messages may be lost."""

_PERIOD_S = 0.05
_SEARCH_S = 0.5
_START_S = 30.0
"""Time limit of the guard's start, s, in which a slow machine imports ROS."""


def velocity(twist: Any, *, stamped: bool) -> Any:
    """Return a command of a drive: a ``Twist``, or one with the present time of the machine."""
    return TwistStamped(Header(Time.from_ns(time.time_ns())), twist) if stamped else twist


class Guard:
    """The loop's end of the pipe.

    Args:
        ros: the version of ROS.
        domain: the domain of ROS 2.
        stop_after_s: how late a step may be, s.
    """

    def __init__(self, ros: Ros, domain: int | None, stop_after_s: float) -> None:
        number = -1 if domain is None else domain
        command = [
            sys.executable,
            "-P",
            "-m",
            "nrp_world_ros.guard",
            str(int(ros)),
            str(number),
            str(stop_after_s),
        ]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )

    def watch(self, topic: str, *, stamped: bool, present: bool) -> None:
        """Guard a drive, and wait until the guard has found it, if it is present.

        Raises:
            SimulationError: the guard has ended, or did not find it in time.
        """
        kind, place = "stamped" if stamped else "plain", "present" if present else "absent"
        self._write(f"{kind} {place} {topic}\n".encode())
        assert self._process.stdout is not None
        ready, _, _ = select.select([self._process.stdout], [], [], _START_S)
        if not (ready and self._process.stdout.readline()):
            raise SimulationError(f"the process that guards {topic} did not find it within {_START_S:g} s")

    def arm(self, topic: str) -> None:
        """Report the first command of a drive; drives without commands belong to other programs."""
        self._write(f"armed {topic}\n".encode())

    def beat(self) -> None:
        """Report a step.

        Raises:
            SimulationError: the guard has ended.
        """
        self._write(b".\n")

    def _write(self, line: bytes) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(line)
            self._process.stdin.flush()
        except OSError as error:
            raise SimulationError("the process that guards the robot has ended") from error

    def close(self) -> None:
        """End the guard, which stops the drives."""
        with suppress(OSError):
            self._process.communicate()


class Watch:
    """The guard's end of the pipe.

    Args:
        node: in ROS.
        stop_after_s: how late a step may be, s.
    """

    def __init__(self, node: Node, stop_after_s: float) -> None:
        self._node, self._stop_after_s = node, stop_after_s
        self._drives: dict[str, tuple[Publisher, bool]] = {}
        self._armed: set[str] = set()

    def run(self) -> None:
        """Watch until the pipe is closed, and stop the drives."""
        text, last_s = b"", float("inf")
        while True:
            ready, _, _ = select.select([0], [], [], min(_PERIOD_S, self._stop_after_s / 4))
            if ready:
                data = os.read(0, 65536)
                if not data:
                    break
                text += data
                *lines, text = text.split(b"\n")
                for line in lines:
                    if line != b".":
                        self._add(line.decode())
                last_s = time.monotonic()
            elif time.monotonic() > last_s + self._stop_after_s:
                self.stop()
        end_s = time.monotonic() + STOPS_S
        while self._armed and time.monotonic() < end_s:
            self.stop()
            time.sleep(_PERIOD_S)

    def _add(self, line: str) -> None:
        kind, topic = line.split(" ", 1)
        if kind == "armed":
            self._armed.add(topic)
            return
        stamped = kind == "stamped"
        place, topic = topic.split(" ")
        self._drives[topic] = self._node.publisher(topic, TwistStamped if stamped else Twist), stamped
        while topic in self._node.settle(_SEARCH_S) and place == "present":
            if select.select([0], [], [], 0)[0]:
                return  # the loop waits no longer
            time.sleep(_PERIOD_S)
        print("ready", flush=True)

    def stop(self) -> None:
        """Send a velocity of zero to the drives that were commanded."""
        for publisher, stamped in map(self._drives.__getitem__, self._armed):
            publisher.publish(velocity(Twist(), stamped=stamped))


def main(ros: int, domain: int, stop_after_s: float) -> None:
    """Join ROS, and watch."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # it ends after the loop
    with join(Ros(ros), "nrp_guard", queue=1, domain=None if domain < 0 else domain) as node:
        Watch(node, stop_after_s).run()


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
