"""The sources of time behind ROS; the time of a world starts at 0 at the first wait for its body."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection

from nrp_core.clock import seconds
from nrp_core.errors import SimulationError

from nrp_world_ros.lockstep import DONE, GO, Sent, Turn, Turns
from nrp_world_ros.node import Node, ros_type
from nrp_world_ros.options import RosOptions, TimeSource

CLOCK = "/clock"

_ASK_S = 1.0
"""Period of the requests for the time of a body until it answers, s."""


class Timekeeper(ABC):
    """Waits until a time.

    Args:
        node: the node of this process.
        patience_s: maximum period without progress of the time, s.

    Attributes:
        late_ns: delay of the loop at its last step, ns.
    """

    late_ns = 0

    def __init__(self, node: Node, patience_s: float) -> None:
        self._node, self._patience_s = node, patience_s

    @abstractmethod
    def start(self, sent: Sent) -> None:
        """Set the time to 0 now.

        Args:
            sent: the messages sent since the last step; cleared afterwards.

        Raises:
            SimulationError: the time is not published.
        """

    @abstractmethod
    def reach(self, t_ns: int, sent: Sent, heard: Collection[str]) -> Sent:
        """Wait until ``t_ns``, and until the messages sent by then have come.

        Args:
            t_ns: the time to wait for.
            sent: the messages sent since the last step; cleared afterwards.
            heard: the subscribed topics.

        Returns:
            The times of the received messages, as far as they are known.

        Raises:
            SimulationError: the time does not advance.
        """

    def _await(self, arrived: Callable[[], bool], what: str) -> None:
        if not self._node.inbox.wait(arrived, self._patience_s, self._node.check):
            raise SimulationError(f"{what} for {self._patience_s:g} s")


class Wall(Timekeeper):
    """The clock of this machine."""

    def start(self, sent: Sent) -> None:
        self._origin_ns = time.monotonic_ns()

    def reach(self, t_ns: int, sent: Sent, heard: Collection[str]) -> Sent:
        self.late_ns = max(0, time.monotonic_ns() - self._origin_ns - t_ns)
        self._node.check()
        time.sleep(max(0, self._origin_ns + t_ns - time.monotonic_ns()) * 1e-9)
        sent.clear()
        return {}


class Clock(Timekeeper):
    """The topic ``/clock``."""

    def __init__(self, node: Node, patience_s: float) -> None:
        super().__init__(node, patience_s)
        node.listen(CLOCK, ros_type("rosgraph_msgs/msg/Clock"))
        self._said_ns: int | None = None

    def start(self, sent: Sent) -> None:
        self._said_ns = None
        self._await(lambda: self._read() is not None, f"no node has published on {CLOCK}")
        self._origin_ns = self._read() or 0

    def reach(self, t_ns: int, sent: Sent, heard: Collection[str]) -> Sent:
        target_ns = self._origin_ns + t_ns
        self.late_ns = max(0, (self._read() or 0) - target_ns)
        stands = f"{CLOCK} has not reached {seconds(target_ns):g} s"
        self._await(lambda: (self._read() or 0) >= target_ns, stands)
        sent.clear()
        return {}

    def _read(self) -> int | None:
        letter = self._node.inbox.last(CLOCK)
        if letter is not None:
            self._said_ns = letter.message.clock.to_ns()
        return self._said_ns


class Lockstep(Timekeeper):
    """The loop itself; the body waits for it."""

    def __init__(self, node: Node, patience_s: float) -> None:
        super().__init__(node, patience_s)
        self._turns = Turns(node, GO, DONE)

    def start(self, sent: Sent) -> None:
        bodies = self._node.peers(GO)
        if bodies > 1:
            raise SimulationError(f"{bodies} bodies wait on {GO}, but a loop steps only one; stop the others")
        end_s = time.monotonic() + self._patience_s
        while (turn := self._go(0, sent, (), min(_ASK_S, self._patience_s))) is None:
            if time.monotonic() > end_s:  # a new body may miss the first message
                raise self._silent()
        self._origin_ns = turn.time.to_ns()

    def reach(self, t_ns: int, sent: Sent, heard: Collection[str]) -> Sent:
        turn = self._go(self._origin_ns + t_ns, sent, heard, self._patience_s)
        if turn is None:
            raise self._silent()
        return {topic: [t - self._origin_ns for t in times_ns] for topic, times_ns in turn.sent.items()}

    def _go(self, target_ns: int, sent: Sent, heard: Collection[str], wait_s: float) -> Turn | None:
        self._turns.end(target_ns, sent)
        return self._turns.wait(wait_s, after_ns=target_ns, heard=heard, meanwhile=self._node.check)

    def _silent(self) -> SimulationError:
        return SimulationError(
            f"the body has not answered on {DONE}, or not sent the messages announced there, for "
            f"{self._patience_s:g} s; is 'nrp ros-bridge --lockstep' running?"
        )


_KINDS: dict[TimeSource, type[Timekeeper]] = {
    TimeSource.WALL: Wall,
    TimeSource.CLOCK: Clock,
    TimeSource.LOCKSTEP: Lockstep,
}


def timekeeper(options: RosOptions, node: Node) -> Timekeeper:
    """Return the source of time that the options select."""
    return _KINDS[options.time](node, seconds(options.patience))
