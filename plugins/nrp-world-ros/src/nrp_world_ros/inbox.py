"""The queue of messages that ROS delivers in its own threads, until the loop takes them."""

from __future__ import annotations

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from nrp_core.world.messages.cdr import Codec

DEPTH = 256
"""Maximum number of waiting messages of a topic; beyond it the oldest are lost."""


@dataclass(frozen=True, slots=True)
class Letter:
    """A received message: its topic, type and bytes, the sending node, and the codec."""

    topic: str
    kind: str
    data: bytes
    sender: str
    codec: Codec

    @property
    def message(self) -> Any:
        """The message, of the platform's class.

        Raises:
            TopicError: the bytes are not such a message.
        """
        return self.codec.decode(self.data, self.kind)


class Inbox:
    """Waiting messages; any thread may add one."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._letters: dict[str, deque[Letter]] = {}
        self._counts: Counter[tuple[str, str]] = Counter()

    def add(self, letter: Letter) -> None:
        """Add a message."""
        with self._changed:
            self._letters.setdefault(letter.topic, deque(maxlen=DEPTH)).append(letter)
            self._counts[letter.sender, letter.topic] += 1
            self._changed.notify_all()

    def take(self) -> list[Letter]:
        """Remove and return all messages, topic by topic, in order of arrival."""
        with self._changed:
            letters = [letter for queue in self._letters.values() for letter in queue]
            self._letters.clear()
            self._counts.clear()
        return letters

    def last(self, topic: str) -> Letter | None:
        """Return the last waiting message of a topic without removing it."""
        queue = self._letters.get(topic)
        return queue[-1] if queue else None

    def has(self, sender: str, counts: Mapping[str, int]) -> bool:
        """Return whether these numbers of messages have come from a node since the last :meth:`take`."""
        return all(self._counts[sender, topic] >= count for topic, count in counts.items())

    def wait(self, arrived: Callable[[], bool], timeout_s: float, meanwhile: Callable[[], None]) -> bool:
        """Wait for messages; return whether they have come.

        Args:
            arrived: returns whether they have come.
            timeout_s: maximum waiting time, s.
            meanwhile: called a few times a second; its exceptions end the waiting.
        """
        end_s = time.monotonic() + timeout_s
        while True:
            meanwhile()
            with self._changed:
                if self._changed.wait_for(arrived, min(0.2, max(0.0, end_s - time.monotonic()))):
                    return True
            if time.monotonic() >= end_s:
                return False
