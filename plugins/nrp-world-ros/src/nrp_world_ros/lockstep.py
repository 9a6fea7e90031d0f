"""How a loop and a body in two processes take their steps in turn.

The loop says on ``/nrp/go`` up to what time the body may go; the body says on ``/nrp/done`` what time it has
reached. ROS keeps the order of messages on one topic but not across topics. So either tells how many messages
it has sent on each of the others, and neither goes on before it has them. In ROS 2 one side may have found
the other on a topic, but not yet been found; so either tells where it has, and neither goes on before it has,
too. No run depends on the network.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from nrp_core.world.messages.base import Time, message

from nrp_world_ros.inbox import Letter
from nrp_world_ros.node import Node

GO = "/nrp/go"
DONE = "/nrp/done"


@message("nrp_msgs/msg/Turn")
@dataclass(slots=True)
class Turn:
    """Whose turn ends, and what was sent in it.

    Args:
        time: up to which the other may go, or that was reached.
        topics: on which something was sent.
        counts: how many messages on each.
        met: the topics on which there is somebody.
    """

    time: Time = field(default_factory=Time)
    topics: list[str] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    met: list[str] = field(default_factory=list)

    @classmethod
    def ended(cls, t_ns: int, sent: Counter[str], met: list[str]) -> Turn:
        """Return what one says at the end of a turn, and count anew."""
        turn = cls(Time.from_ns(t_ns), list(sent), list(sent.values()), met)
        sent.clear()
        return turn


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

    def end(self, t_ns: int, sent: Counter[str]) -> None:
        """Say that it is the other's turn."""
        self._say.publish(Turn.ended(t_ns, sent, self._node.met()))

    def wait(
        self,
        timeout_s: float,
        *,
        after_ns: int = -1,
        heard: Collection[str] | None = None,
        meanwhile: Callable[[], None],
    ) -> int | None:
        """Wait for the other to end its turn, and for all that it has sent.

        Args:
            timeout_s: how long to wait at most.
            after_ns: the time must be at least this.
            heard: the topics that this one hears; None: all that the other names.
            meanwhile: called a few times a second.

        Returns:
            the time that the other says, ns; None: it was silent.
        """
        said: list[int] = []
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
            said.append(turn.time.to_ns())
            return True

        return said[0] if self._node.inbox.wait(arrived, timeout_s, meanwhile) else None
