"""Lockstep of a loop and a body in two processes, which take turns.

The loop publishes on ``/nrp/go`` the time up to which the body may run; the body publishes on ``/nrp/done``
the time that it has reached. ROS keeps the order of messages on one topic but not across topics. So each side
announces the number of messages that it has sent on each of the other topics, and waits for those of the
other side. In ROS 2 discovery of a topic may be one-sided; so each side announces the topics on which it has
discovered the other, and waits until both have. So results do not depend on the network.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
import numpy.typing as npt
from nrp_core.clock import seconds
from nrp_core.errors import SimulationError
from nrp_core.messages.base import Time, message

from nrp_world_ros.node import Letter, Node, ros_type
from nrp_world_ros.options import RosOptions, TimeSource

GO = "/nrp/go"
DONE = "/nrp/done"

Sent = dict[str, list[int]]
"""The times of the messages that were sent on each topic, ns."""


@message("nrp_ros_msgs/msg/Turn")
@dataclass(slots=True)
class Turn:
    """The end of a turn, with the messages sent in it.

    Args:
        time: the time up to which the other side may run, or the time reached.
        topics: the topics with sent messages.
        counts: the number of messages on each.
        times_ns: times of these messages, topic by topic.
        met: the topics on which the other side was discovered.
        note: a request or an answer, if the two sides use them.
    """

    time: Time = field(default_factory=Time)
    topics: list[str] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    times_ns: list[int] = field(default_factory=list)
    met: list[str] = field(default_factory=list)
    note: npt.NDArray[np.uint8] = field(default_factory=lambda: np.empty(0, np.uint8))

    @classmethod
    def ended(cls, t_ns: int, sent: Sent, met: list[str], note: bytes = b"") -> Turn:
        """Return the message for the end of a turn, and clear the counts."""
        counts = [len(times_ns) for times_ns in sent.values()]
        all_ns = [t_ns for times_ns in sent.values() for t_ns in times_ns]
        turn = cls(Time.from_ns(t_ns), list(sent), counts, all_ns, met, np.frombuffer(note, np.uint8))
        sent.clear()
        return turn

    @property
    def sent(self) -> Sent:
        """The time of each message."""
        times_ns = iter(self.times_ns)
        return {
            topic: list(islice(times_ns, count))
            for topic, count in zip(self.topics, self.counts, strict=True)
        }


class Turns:
    """One of the two sides.

    Args:
        node: the node of this process.
        mine: the topic on which this side ends its turn.
        theirs: the topic on which the other side ends its turn.
    """

    def __init__(self, node: Node, mine: str, theirs: str) -> None:
        self._node, self._theirs = node, theirs
        self._say = node.publisher(mine, Turn)
        node.listen(theirs, Turn)

    def end(self, t_ns: int, sent: Sent, note: bytes = b"") -> None:
        """End this side's turn."""
        self._say.publish(Turn.ended(t_ns, sent, self._node.met(), note))

    def wait(
        self,
        timeout_s: float,
        *,
        after_ns: int = -1,
        heard: Collection[str] | None = None,
        meanwhile: Callable[[], None],
    ) -> Turn | None:
        """Wait for the end of the other side's turn, and for all messages sent in it.

        Args:
            timeout_s: maximum waiting time, s.
            after_ns: minimum time of the message, ns.
            heard: the topics subscribed to here; None: all topics of the other side.
            meanwhile: called a few times a second.

        Returns:
            The message of the other side; None after the time limit.
        """
        said: list[Turn] = []
        turns: dict[Letter, Turn] = {}

        def arrived() -> bool:
            letter = self._node.inbox.last(self._theirs)
            if letter is None:
                return False
            turn = turns.get(letter) or turns.setdefault(letter, letter.message)
            sent = dict(zip(turn.topics, turn.counts, strict=True))
            due = {topic: n for topic, n in sent.items() if heard is None or topic in heard}
            if turn.time.to_ns() < after_ns or not self._node.inbox.has(letter.sender, due):
                return False
            if not all(self._node.sees(topic, letter.sender) for topic in turn.met):
                return False
            said.append(turn)
            return True

        return said[0] if self._node.inbox.wait(arrived, timeout_s, meanwhile) else None


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
        missed: the number of steps that were not computed in time; only wall time does not wait.
        steps: the number of all steps.
        worst_ns: the largest delay, ns.
    """

    late_ns = 0
    missed = 0
    steps = 0
    worst_ns = 0

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
        """Wait until ``t_ns``, and until the messages sent by then have arrived.

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
        self.steps += 1
        self.missed += self.late_ns > 0
        self.worst_ns = max(self.worst_ns, self.late_ns)
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
