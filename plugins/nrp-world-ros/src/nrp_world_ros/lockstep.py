"""Lockstep of a loop and a body in two processes, which take turns.

The loop publishes on ``/nrp/go`` the time up to which the body may run; the body publishes on ``/nrp/done``
the time that it has reached. ROS keeps the order of messages on one topic but not across topics. So each side
announces the number of messages that it has sent on each of the other topics, and waits for those of the
other side. In ROS 2 discovery of a topic may be one-sided; so each side announces the topics on which it has
discovered the other, and waits until both have. So results do not depend on the network.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
import numpy.typing as npt
from nrp_core.world.messages.base import Time, message

from nrp_world_ros.inbox import Letter
from nrp_world_ros.node import Node

GO = "/nrp/go"
DONE = "/nrp/done"

Sent = dict[str, list[int]]
"""The times of the messages that were sent on each topic, ns."""


@message("nrp_msgs/msg/Turn")
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
            heard: the topics subscribed to here; None: all that the other side names.
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
