"""The last messages on some topics, so that a client that subscribes later receives them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from nrp_cockpit.wire.channels import Sent
from nrp_core.clock import seconds

PAST = "/cockpit/past"
"""The topic that announces the past of another topic: from when it is known, and the number of its messages.

The messages themselves follow on the other topic. Clients that do not subscribe to it get only the last one.
"""
MOST_BYTES = 64_000_000
"""Maximum size of all messages; the oldest of the largest topic are dropped first."""
MOST_MESSAGES = 8192
"""Maximum number of messages of a topic: almost three minutes at 50 Hz, which a page reads in a moment."""
_OVERHEAD_BYTES = 200
"""Memory that a message needs in addition to its content."""


def past_data(topic: str, from_ns: int, count: int, *, is_new: bool = False) -> dict[str, Any]:
    """Return the announcement of a past.

    Args:
        topic: the topic.
        from_ns: the time from which it is known.
        count: the number of messages that follow.
        is_new: whether all that was known before is invalid.
    """
    return {"topic": topic, "from_s": seconds(from_ns), "count": count, "new": is_new}


@dataclass(slots=True)
class _Past:
    from_ns: int
    most: int
    messages: deque[Sent] = field(default_factory=deque)
    size: int = 0

    def drop_first(self) -> None:
        self.size -= self.messages.popleft().size + _OVERHEAD_BYTES
        if self.messages:
            self.from_ns = self.messages[0].t_ns

    def drop_from(self, t_ns: int) -> None:
        while self.messages and self.messages[-1].t_ns >= t_ns:
            self.size -= self.messages.pop().size + _OVERHEAD_BYTES


class Memory:
    """The past of some topics up to now, bounded in size.

    Args:
        most_bytes: maximum size of all messages.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes, self._bytes = most_bytes, 0
        self._pasts: dict[str, _Past] = {}

    def __contains__(self, topic: object) -> bool:
        return topic in self._pasts

    @property
    def last_only(self) -> set[str]:
        """The topics of which only the last message is kept."""
        return {topic for topic, past in self._pasts.items() if past.most == 1}

    def begin(self, topic: str, from_ns: int, most: int = MOST_MESSAGES) -> None:
        """Keep the messages of a topic from a time on; delete earlier ones.

        Args:
            topic: the topic.
            from_ns: the time.
            most: maximum number of its messages.
        """
        self.forget([topic])
        self._pasts[topic] = _Past(from_ns, most)

    def forget(self, topics: Iterable[str]) -> None:
        """Keep no messages of these topics any more."""
        for topic in topics:
            past = self._pasts.pop(topic, None)
            self._bytes -= past.size if past else 0

    def go_back(self, t_ns: int) -> None:
        """Delete the messages after a time."""
        for past in self._pasts.values():
            past.drop_from(t_ns + 1)
            past.from_ns = min(past.from_ns, max(t_ns, 0))
        self._bytes = sum(past.size for past in self._pasts.values())

    def add(self, sent: Sent) -> None:
        """Keep a message if its topic is kept; if it is earlier than the last one, time has gone back."""
        past = self._pasts.get(sent.channel.topic)
        if past is None:
            return
        before = past.size
        if past.messages and sent.t_ns < past.messages[-1].t_ns:
            past.drop_from(sent.t_ns)
        past.messages.append(sent)
        past.size += sent.size + _OVERHEAD_BYTES
        if len(past.messages) > past.most:
            past.drop_first()
        self._bytes += past.size - before
        while self._bytes > self._most_bytes:
            self._drop_oldest()

    def of(self, topic: str) -> tuple[int, list[Sent]]:
        """Return the time from which a topic is known, ns, and its messages since then."""
        past = self._pasts.get(topic)
        return (0, []) if past is None else (past.from_ns, list(past.messages))

    def _drop_oldest(self) -> None:
        largest = max(self._pasts.values(), key=lambda past: past.size)
        self._bytes -= largest.size
        largest.drop_first()
        self._bytes += largest.size
