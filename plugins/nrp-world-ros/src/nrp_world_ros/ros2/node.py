"""This process as a node of ROS 2: a participant of DDS, with ROS 2's names for topics and types.

There is no central list of nodes; they discover each other, which takes a moment.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from nrp_core.clock import NS_PER_S
from nrp_core.errors import SimulationError, TopicError
from nrp_core.world import Closing
from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.std_msgs import String

from nrp_world_ros.node import Answer, Node, Publisher
from nrp_world_ros.ros2.load import load_dds
from nrp_world_ros.ros2.mail import Mail, participants
from nrp_world_ros.ros2.network import domain_number, participate, reach, service_sockets
from nrp_world_ros.ros2.presence import announce
from nrp_world_ros.ros2.rtps.participant import RtpsParticipant
from nrp_world_ros.ros2.services import Services
from nrp_world_ros.ros2.types import dds_topic

_DISCOVERY_S = 1.0
"""Time limit of the mutual discovery of a new node and others, s; a tenth of it on loopback."""

_MUTUAL_S = 0.2
"""Time limit for a discovered node to discover this one, s."""

_HELD_UP_S = 10.0
"""Maximum blocking time by a slow subscriber that must get every message, s."""

_HARDLY_S = 0.01
"""The same if messages may be lost, s."""


class Ros2Node(Node):
    """See :class:`~nrp_world_ros.node.Node`.

    Args:
        name: name of the node.
        queue: queue length for a slow subscriber, beyond which the oldest messages are lost; 0: unlimited.
        domain: its number; None: ``ROS_DOMAIN_ID``, else 0.

    Raises:
        BackendLoadError: Cyclone DDS is not installed, or cannot use the network.
    """

    tool = "ros2 topic"
    returns_errors = False

    def __init__(self, name: str, *, queue: int = 0, domain: int | None = None) -> None:
        load_dds()
        super().__init__(Codec())
        self._queue = queue
        self._namespace = ""
        self._services: Services | None = None
        self._number = domain_number(domain)
        self._topics, self._participant = participate(self._number, self.codec)
        self._writers: dict[str, _Ros2Publisher] = {}
        self._matched: tuple[dict[str, int], float] = ({}, time.monotonic())
        self._joined_s = time.monotonic()
        self._presence = announce(name, self._participant, self.codec, self._topics)
        # its thread must start last
        self._mail = Mail(self._participant, self.inbox, self.codec)

    # -- topics

    @property
    def reach(self) -> str:
        return f"this one is in {reach(self._number)}"

    def move(self, namespace: str) -> None:
        """Leave all topics; later ones are below a namespace, ``/there``."""
        self._require_open()
        self._leave_topics()
        self._namespace = namespace

    def _leave_topics(self) -> None:
        self._mail.clear()
        for writer in self._writers.values():
            writer.close()
        self._writers.clear()
        self.inbox.take()

    def publisher(self, topic: str, cls: type, *, latched: bool = False) -> Publisher:
        if topic not in self._writers:
            from cyclonedds.pub import DataWriter

            name = self._type_name(cls)
            qos = self._qos(name, self._queue, latched=latched)
            writer = DataWriter(self._participant, self._topic(topic, name), qos=qos)
            self._writers[topic] = _Ros2Publisher(topic, writer, self.codec, lossy=self._queue > 0)
        return self._writers[topic]

    def listen(self, topic: str, cls: type) -> None:
        if topic in self._mail:
            return
        name = self._type_name(cls)
        self._mail.open(topic, name, self._topic(topic, name), self._qos(name, 0))

    def _type_name(self, cls: type) -> str:
        self._require_open()
        return self.codec.name(cls)

    def _topic(self, topic: str, name: str) -> Any:
        from cyclonedds.core import DDSException

        try:
            there = dds_topic(self._namespace + topic)
            return self._topics.topic(self._participant, there, name, self.codec)
        except DDSException as error:
            raise TopicError(f"{topic} cannot be a topic of ROS 2: {error}") from error

    def _qos(self, name: str, queue: int, *, latched: bool = False) -> Any:
        """Return ROS 2's default quality of service, reliable; late subscribers get what is latched."""
        from cyclonedds.core import Policy, Qos

        return Qos(
            Policy.Reliability.Reliable(int((_HARDLY_S if queue else _HELD_UP_S) * NS_PER_S)),
            Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
            Policy.History.KeepLast(1 if latched else queue) if latched or queue else Policy.History.KeepAll,
            Policy.IgnoreLocal.Participant,
            Policy.DataRepresentation(use_cdrv0_representation=True),
            Policy.Userdata(f"typehash={self.codec.hash(name)};".encode()),
        )

    def serve(self, service: str, request: str, response: str, answer: Answer) -> None:
        self._require_open()
        if self._services is None:
            self._services = Services(RtpsParticipant(service_sockets(self._number)))
        self._services.serve(service, request, response, answer)

    def keep(self, name: str, text: str) -> None:
        self.publisher(name, String, latched=True).publish(String(text))

    # -- discovery

    def _ends(self) -> dict[str, Callable[[], int]]:
        """Return the objects that count the nodes on each topic."""
        writers = {topic: writer.peers for topic, writer in self._writers.items()}
        return self._mail.ends() | writers

    def peers(self, topic: str) -> int:
        return self._ends()[topic]()

    def met(self) -> list[str]:
        return [topic for topic, peers in self._ends().items() if peers()]

    def sees(self, topic: str, other: str) -> bool:
        if topic in self._writers:
            return other in self._writers[topic].listeners()
        return topic not in self._mail or other in self._mail.senders(topic)

    def settle(self, timeout_s: float) -> set[str]:
        self._require_open()
        end_s = time.monotonic() + timeout_s
        while True:
            self._mail.adapt()
            counts, now_s = {topic: peers() for topic, peers in self._ends().items()}, time.monotonic()
            if counts != self._matched[0]:
                self._matched = (counts, now_s)
            alone = {topic for topic, count in counts.items() if not count}
            searched = not alone or now_s > self._joined_s + _DISCOVERY_S
            if now_s > end_s or (searched and now_s > self._matched[1] + _MUTUAL_S):
                return alone
            time.sleep(0.01)

    def check(self) -> None:
        self._require_open()
        self._mail.check()

    def _require_open(self) -> None:
        if self._participant is None:
            raise SimulationError("this node has left ROS 2")

    def close(self) -> None:
        if self._participant is not None:
            self._leave_topics()
            self._mail.close()
            if self._services is not None:
                self._services.close()
            self._participant = self._presence = None
            del self._topics  # the domain ends with its last node


class _Ros2Publisher(Closing):
    """Publishes on one topic; if it is lossy, a message that one subscriber does not take is lost for all."""

    def __init__(self, topic: str, writer: Any, codec: Codec, *, lossy: bool) -> None:
        self._topic, self._writer, self._codec, self._lossy = topic, writer, codec, lossy
        self._known: dict[int, str] = {}

    def listeners(self) -> set[str]:
        """Return the subscribed participants."""
        handles = self._writer.get_matched_subscriptions()
        return participants(handles, self._known, self._writer.get_matched_subscription_data)

    def peers(self) -> int:
        return int(self._writer.get_publication_matched_status().current_count)

    def publish(self, message: Any) -> None:
        from cyclonedds.core import DDSException

        data = self._codec.encode(message)
        try:
            self._writer.write(self._writer.data_type(data))
        except DDSException as error:
            if not (self._lossy and error.code == DDSException.DDS_RETCODE_TIMEOUT):
                raise SimulationError(f"a message on {self._topic} was not accepted: {error}") from error

    def close(self) -> None:
        """Leave the topic."""
        self._writer = None
