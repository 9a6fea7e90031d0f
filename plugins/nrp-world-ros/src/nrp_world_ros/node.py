"""A process in ROS 1 or ROS 2: its publishers and subscribers, for the rest of the plugin."""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from nrp_core.messages.cdr import Codec
from nrp_core.messages.generated import made
from nrp_core.world import Closing

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
    """Waiting messages; any thread may add one.

    Args:
        depth: maximum number of a topic; None: all.
    """

    def __init__(self, depth: int | None = DEPTH) -> None:
        self._depth = depth
        self._changed = threading.Condition()
        self._letters: dict[str, deque[Letter]] = {}
        self._counts: Counter[tuple[str, str]] = Counter()
        self._called = False

    def add(self, letter: Letter) -> None:
        """Add a message."""
        with self._changed:
            self._letters.setdefault(letter.topic, deque(maxlen=self._depth)).append(letter)
            self._counts[letter.sender, letter.topic] += 1
            self._changed.notify_all()

    def wake(self) -> None:
        """Let a :meth:`wait` perform its periodic work at once."""
        with self._changed:
            self._called = True
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
        """Return whether these numbers of messages have arrived from a node since the last :meth:`take`."""
        return all(self._counts[sender, topic] >= count for topic, count in counts.items())

    def wait(self, arrived: Callable[[], bool], timeout_s: float, meanwhile: Callable[[], None]) -> bool:
        """Wait for messages; return whether they have arrived.

        Args:
            arrived: returns whether they have arrived.
            timeout_s: maximum waiting time, s.
            meanwhile: called a few times a second; its exceptions end the waiting.
        """
        end_s = time.monotonic() + timeout_s
        while True:
            self._called = False
            meanwhile()
            with self._changed:
                remaining_s = min(0.2, max(0.0, end_s - time.monotonic()))
                self._changed.wait_for(lambda: self._called or arrived(), remaining_s)
                if arrived():
                    return True
            if time.monotonic() >= end_s:
                return False


PATIENCE_S = 30.0
"""Maximum waiting time of the caller of a service, s."""

Answer = Callable[[bytes], "Future[memoryview]"]
"""Takes a request, in a thread of ROS; the response comes later, and in any thread."""


class Publisher(Protocol):
    """Publishes on one topic."""

    def peers(self) -> int:
        """Return the number of subscribers."""
        ...

    def publish(self, message: Any) -> None:
        """Send a message to all subscribers.

        Raises:
            TopicError: a value does not fit the type of its field.
        """
        ...


class Node(Closing):
    """Publishes and subscribes to topics of ROS, and offers services.

    Args:
        codec: the encoding of messages in this ROS.
        depth: maximum number of waiting messages of a topic; None: all.

    Attributes:
        inbox: the received messages.
    """

    tool: ClassVar[str]
    """The program with which users list topics."""

    returns_errors: ClassVar[bool]
    """Whether the caller of a service is told why it failed."""

    def __init__(self, codec: Codec, depth: int | None = DEPTH) -> None:
        self.codec = codec
        self.inbox = Inbox(depth)

    @property
    @abstractmethod
    def reach(self) -> str:
        """Where this node can be found, and how to widen it, for a report."""

    @abstractmethod
    def publisher(self, topic: str, cls: type, *, latched: bool = False) -> Publisher:
        """Return the publisher on a topic; the same one for each call.

        Args:
            topic: the topic.
            cls: class of the messages.
            latched: whether a later subscriber gets the last message.

        Raises:
            TopicError: this ROS does not support such messages.
            SimulationError: the connection to ROS was lost.
        """

    @abstractmethod
    def listen(self, topic: str, cls: type) -> None:
        """Subscribe to a topic; messages go to the inbox.

        Raises:
            TopicError: this ROS does not support such messages.
            SimulationError: the connection to ROS was lost.
        """

    @abstractmethod
    def serve(self, service: str, request: str, response: str, answer: Answer) -> None:
        """Offer a service.

        Args:
            service: its name.
            request: type of the request, ``package/msg/NameRequest``.
            response: type of the response.
            answer: takes a request. If its response is one of our errors, the caller gets no response, and
                in some ROS the reason.

        Raises:
            SimulationError: the connection to ROS was lost.
        """

    @abstractmethod
    def call(self, service: str, request: Any, response: type, timeout_s: float) -> Any:
        """Call a service of another node, and return its response; None: no node offers it.

        Args:
            service: its name.
            request: the request.
            response: class of the response.
            timeout_s: time limit of the response in ROS 2; ROS 1 has none.

        Raises:
            SimulationError: it failed or did not answer, or the connection to ROS was lost.
            TopicError: this ROS has a type of that name with other fields.
        """

    @abstractmethod
    def keep(self, name: str, text: str) -> None:
        """Offer a text to all who ask, now or later: a parameter in ROS 1, a latched topic in ROS 2.

        Raises:
            SimulationError: the connection to ROS was lost.
        """

    @abstractmethod
    def peers(self, topic: str) -> int:
        """Return the number of nodes on the other side of a topic of this node."""

    @abstractmethod
    def met(self) -> list[str]:
        """Return the topics of this node with nodes on the other side."""

    def unmatched(self) -> list[str]:
        """Return the topics with nodes on the other side none of which can be connected."""
        return []

    @abstractmethod
    def sees(self, topic: str, other: str) -> bool:
        """Return whether a node is on the other side of a topic of this node; true for other topics."""

    @abstractmethod
    def settle(self, timeout_s: float) -> set[str]:
        """Wait until all known nodes on the topics of this node are connected.

        Returns:
            The topics without nodes on the other side.

        Raises:
            SimulationError: the connection to ROS was lost.
        """

    @abstractmethod
    def check(self) -> None:
        """Check the connection to ROS; calling it often is cheap.

        Raises:
            SimulationError: it was lost.
        """


def ros_type(name: str) -> Any:
    """Return the message class of a type that ROS has."""
    cls = made(name)
    assert cls is not None
    return cls
