"""A process in ROS 1 or ROS 2: its publishers and subscribers, for the rest of the plugin."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, ClassVar, Protocol

from nrp_core.world import Closing
from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.generated import made

from nrp_world_ros.inbox import Inbox

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

    Attributes:
        inbox: the received messages.
    """

    tool: ClassVar[str]
    """The program with which users list topics."""

    returns_errors: ClassVar[bool]
    """Whether the caller of a service is told why it failed."""

    def __init__(self, codec: Codec) -> None:
        self.codec = codec
        self.inbox = Inbox()

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
