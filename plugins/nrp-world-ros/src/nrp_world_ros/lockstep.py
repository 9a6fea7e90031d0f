"""How a loop and a body in two processes take their steps in turn.

The loop says on ``/nrp/go`` up to what time the body may go; the body says on ``/nrp/done`` what time it has
reached. ROS keeps the order of messages on one topic but not across topics. So either tells how many messages
it has sent on each of the others, and neither goes on before it has them. In ROS 2 one side may have found
the other on a topic, but not yet been found; so either tells where it has, and neither goes on before it has,
too. No run depends on the network.
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
    """Whose turn ends, and what was sent in it.

    Args:
        time: up to which the other may go, or that was reached.
        topics: on which something was sent.
        counts: how many messages on each.
        times_ns: of these messages, topic by topic.
        met: the topics on which there is somebody.
        note: what is asked or answered besides, where the two have agreed on how.
    """

    time: Time = field(default_factory=Time)
    topics: list[str] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    times_ns: list[int] = field(default_factory=list)
    met: list[str] = field(default_factory=list)
    note: npt.NDArray[np.uint8] = field(default_factory=lambda: np.empty(0, np.uint8))

    @classmethod
    def ended(cls, t_ns: int, sent: Sent, met: list[str], note: bytes = b"") -> Turn:
        """Return what one says at the end of a turn, and count anew."""
        counts = [len(times_ns) for times_ns in sent.values()]
        all_ns = [t_ns for times_ns in sent.values() for t_ns in times_ns]
        turn = cls(Time.from_ns(t_ns), list(sent), counts, all_ns, met, np.frombuffer(note, np.uint8))
        sent.clear()
        return turn

    @property
    def sent(self) -> Sent:
        """When each message was sent."""
        times_ns = iter(self.times_ns)
        return {
            topic: list(islice(times_ns, count))
            for topic, count in zip(self.topics, self.counts, strict=True)
        }


class Turns:
    """One of the two.

    Args:
        node: of this process.
        mine: where this one says that it is the other's turn.
        theirs: where the other one says so.
    """

    def __init__(self, node: Node, mine: str, theirs: str) -> None:
        self._node, self._theirs = node, theirs
        self._say = node.publisher(mine, Turn)
        node.listen(theirs, Turn)

    def end(self, t_ns: int, sent: Sent, note: bytes = b"") -> None:
        """Say that it is the other's turn."""
        self._say.publish(Turn.ended(t_ns, sent, self._node.met(), note))

    def wait(
        self,
        timeout_s: float,
        *,
        after_ns: int = -1,
        heard: Collection[str] | None = None,
        meanwhile: Callable[[], None],
    ) -> Turn | None:
        """Wait for the other to end its turn, and for all that it has sent.

        Args:
            timeout_s: how long to wait at most.
            after_ns: the time must be at least this.
            heard: the topics that this one hears; None: all that the other names.
            meanwhile: called a few times a second.

        Returns:
            what the other says; None: it was silent.
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
