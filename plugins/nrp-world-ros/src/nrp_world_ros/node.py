"""A process in ROS, of either kind: what it publishes and hears. The rest of the plugin knows no more."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, Protocol

from nrp_core.world import Closing
from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.generated import made

from nrp_world_ros.backend import Ros
from nrp_world_ros.inbox import Inbox


class Publisher(Protocol):
    """Publishes on one topic."""

    def peers(self) -> int:
        """Return how many listen."""
        ...

    def publish(self, message: Any) -> None:
        """Send a message to all who listen.

        Raises:
            TopicError: a field holds what its type cannot.
        """
        ...


class Node(Closing):
    """Publishes and hears topics of ROS, and offers services.

    Args:
        codec: what this ROS makes of messages.

    Attributes:
        inbox: where messages arrive.
    """

    tool: ClassVar[str]
    """The program by which users see topics."""

    has_services: ClassVar[bool]
    """Whether :meth:`serve` can be called."""

    def __init__(self, codec: Codec) -> None:
        self.codec = codec
        self.inbox = Inbox()

    @abstractmethod
    def publisher(self, topic: str, cls: type) -> Publisher:
        """Return what publishes on a topic; asked again, the same.

        Raises:
            TopicError: this ROS cannot carry such messages.
            SimulationError: ROS is gone.
        """

    @abstractmethod
    def listen(self, topic: str, cls: type) -> None:
        """Let what others publish on a topic arrive in the inbox.

        Raises:
            TopicError: this ROS cannot carry such messages.
            SimulationError: ROS is gone.
        """

    @abstractmethod
    def serve(self, service: str, request: str, response: str, answer: Callable[[bytes], memoryview]) -> None:
        """Offer a service.

        Args:
            service: its name.
            request: type of what is asked, ``package/msg/NameRequest``.
            response: type of what is answered.
            answer: is given a request and returns the response, in a thread of its own.

        Raises:
            SimulationError: ROS is gone.
        """

    @abstractmethod
    def peers(self, topic: str) -> int:
        """Return how many are on the other side of a topic of ours."""

    @abstractmethod
    def met(self) -> list[str]:
        """Return the topics of ours with anybody on the other side."""

    @abstractmethod
    def sees(self, topic: str, other: str) -> bool:
        """Whether a node is on the other side of a topic of ours; true where the topic is not ours."""

    @abstractmethod
    def settle(self, timeout_s: float) -> set[str]:
        """Wait until everybody who is known on our topics is connected.

        Returns:
            the topics with nobody on the other side.

        Raises:
            SimulationError: ROS is gone.
        """

    @abstractmethod
    def check(self) -> None:
        """Look whether ROS is still there; calling it often costs nothing.

        Raises:
            SimulationError: it is not.
        """


def join(ros: Ros, name: str, *, queue: int = 0, domain: int | None = None) -> Node:
    """Become a node of ROS.

    Args:
        ros: which of the two.
        name: what the node is called, if nothing else in this process has started it before.
        queue: how many messages wait for a listener that is slow, before the oldest are lost; 0: all.
        domain: of ROS 2; by default ``ROS_DOMAIN_ID`` says, else 0.

    Raises:
        BackendLoadError: what it needs is not there.
    """
    if ros is Ros.ONE:
        from nrp_world_ros.ros1.node import Ros1Node

        return Ros1Node(name, queue=queue)
    from nrp_world_ros.ros2.node import Ros2Node

    return Ros2Node(name, queue=queue, domain=domain)


def ros_type(name: str) -> Any:
    """Return the message class of a type that ROS has."""
    cls = made(name)
    assert cls is not None
    return cls
