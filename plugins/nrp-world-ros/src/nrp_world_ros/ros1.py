"""This process as a node of ROS. rospy allows one node per process, started once."""

from __future__ import annotations

import os
import socket
import sysconfig
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from types import ModuleType
from typing import Any
from urllib.parse import urlsplit

from nrp_core.errors import BackendLoadError, SimulationError, TopicError

from nrp_world_ros.node import PATIENCE_S, Answer, Letter, Node, Publisher
from nrp_world_ros.ros1_encoding import Ros1Codec

INSTALL = (
    "apt-get install --no-install-recommends python3-rospy python3-roslaunch && "
    f"echo /usr/lib/python3/dist-packages > {sysconfig.get_path('purelib')}/ros.pth"
)
"""Path file for Debian's rospy in this Python; added paths come after installed packages."""


def load_rospy() -> ModuleType:
    """Return rospy.

    Raises:
        BackendLoadError: it or one of its requirements is missing.
    """
    try:
        import rosgraph  # noqa: F401  a part of ROS that rospy is useless without
        import rospy
    except ImportError as error:
        raise BackendLoadError(f"ROS 1 is not in this Python ({error})", remedy=INSTALL) from error
    module: ModuleType = rospy
    return module


CODEC = Ros1Codec()


@cache
def wire_type(name: str) -> type[Any]:
    """Return rospy's message class for a type of the codec.

    Args:
        name: the full name, ``package/msg/Type``.
    """
    import genpy

    class Wire(genpy.Message):  # type: ignore[misc]
        """A message as bytes."""

        __slots__ = ["data"]
        _slot_types = ["uint8[]"]  # noqa: RUF012  rospy's own name for what it reads
        _type = name.replace("/msg/", "/")
        _md5sum = CODEC.md5(name)
        _full_text = CODEC.definition(name)
        _has_header = False

        def __init__(self, data: bytes | memoryview = b"") -> None:
            self.data = data

        def serialize(self, buff: Any) -> None:
            buff.write(self.data)

        def deserialize(self, data: bytes) -> Wire:
            self.data = data
            return self

    return Wire


@cache
def wire_service(request: str, response: str) -> type[Any]:
    """Return rospy's class of a service.

    Args:
        request: full name of the request, ``package/msg/NameRequest``.
        response: full name of the response, ``package/msg/NameResponse``.
    """
    content = {
        "_type": request.replace("/msg/", "/").removesuffix("Request"),
        "_md5sum": CODEC.service_md5(request, response),
        "_request_class": wire_type(request),
        "_response_class": wire_type(response),
    }
    return type("WireService", (), content)


_LOOPBACK = ("localhost", "127.", "[::1]")
_CHECK_S = 1.0
_NOT_HERE = (OSError, ValueError)


class Ros1Node(Node):
    """See :class:`~nrp_world_ros.node.Node`.

    Args:
        name: name of the node, unless this process has already started one.
        queue: queue length for a slow subscriber, beyond which the oldest messages are lost; 0: unlimited.

    Raises:
        BackendLoadError: rospy is not installed, or no master was found.
    """

    tool = "rostopic"
    returns_errors = True

    def __init__(self, name: str, *, queue: int = 0) -> None:
        super().__init__(CODEC)
        self._rospy = rospy = load_rospy()
        import rosgraph

        self._uri: str = rosgraph.get_master_uri()
        try:
            self._look_for_master()
        except _NOT_HERE as error:
            message = f"no ROS master is at {self._uri} ({error}); start one: roscore, or set ROS_MASTER_URI"
            raise BackendLoadError(message) from error
        if not rospy.core.is_initialized():
            rospy.init_node(name, anonymous=True, disable_signals=True, disable_rosout=True)
        self._master = rosgraph.Master(rospy.get_name())
        self._queue = queue
        self._publishers: dict[str, _Ros1Publisher] = {}
        self._listeners: dict[str, Any] = {}
        self._services: list[Any] = []
        self._parameters: set[str] = set()
        self._checked_s = time.monotonic()

    @property
    def reach(self) -> str:
        return f"this one is known to the master at {self._uri}: is ROS_MASTER_URI the same for the others?"

    def publisher(self, topic: str, cls: type, *, latched: bool = False) -> Publisher:
        if topic not in self._publishers:
            kind = wire_type(self.codec.name(cls))
            self._require_master()
            self._publishers[topic] = _Ros1Publisher(
                self._rospy.Publisher(topic, kind, queue_size=self._queue, latch=latched), kind
            )
        return self._publishers[topic]

    def listen(self, topic: str, cls: type) -> None:
        if topic in self._listeners:
            return
        name, me = self.codec.name(cls), self._rospy.get_name()
        self._require_master()

        def arrived(message: Any) -> None:
            sender = message._connection_header["callerid"]
            if sender != me:
                self.inbox.add(Letter(topic, name, bytes(message.data), sender, self.codec))

        self._listeners[topic] = self._rospy.Subscriber(topic, wire_type(name), arrived, tcp_nodelay=True)

    def serve(self, service: str, request: str, response: str, answer: Answer) -> None:
        kind = wire_service(request, response)
        self._require_master()

        def handle(message: Any) -> Any:
            coming = answer(bytes(message.data))
            try:
                return kind._response_class(coming.result(PATIENCE_S))
            except TimeoutError:
                if not coming.cancel():  # it is being answered now
                    return kind._response_class(coming.result())
                raise TopicError(f"{service}: no answer within {PATIENCE_S:g} s; is it paused?") from None

        self._services.append(self._rospy.Service(service, kind, handle, error_handler=_unmoved))

    def call(self, service: str, request: Any, response: type, timeout_s: float) -> Any:
        from rosgraph.masterapi import MasterException

        self._require_master()
        with suppress(MasterException):  # of a service that no node offers
            self._master.lookupService(service)
            answer = self.codec.name(response)
            kind = wire_service(self.codec.name(type(request)), answer)
            proxy = self._rospy.ServiceProxy(service, kind)
            try:
                received = proxy.call(kind._request_class(bytes(self.codec.encode(request))))
            except self._rospy.ServiceException as error:
                raise SimulationError(f"{service} failed: {error}") from error
            return self.codec.decode(bytes(received.data), answer)
        return None

    def keep(self, name: str, text: str) -> None:
        self._require_master()
        self._rospy.set_param(name, text)
        self._parameters.add(name)

    def peers(self, topic: str) -> int:
        return int(self._ends()[topic]())

    def met(self) -> list[str]:
        return [topic for topic, peers in self._ends().items() if peers()]

    def sees(self, topic: str, other: str) -> bool:
        return True  # a TCP connection is known on both sides

    def _ends(self) -> dict[str, Callable[[], int]]:
        """Return the objects that count the connections of each topic."""
        listeners = {topic: listener.get_num_connections for topic, listener in self._listeners.items()}
        return listeners | {topic: publisher.peers for topic, publisher in self._publishers.items()}

    def settle(self, timeout_s: float) -> set[str]:
        end_s = time.monotonic() + timeout_s
        ends, answers = self._ends(), cache(self._answers)
        while True:
            known = self._known(answers)
            waiting = [topic for topic, peers in ends.items() if peers() < known.get(topic, 0)]
            if not waiting or time.monotonic() > end_s:
                return {topic for topic, peers in ends.items() if not peers()}
            time.sleep(0.01)

    def _known(self, answers: Callable[[str], bool]) -> dict[str, int]:
        """Return the number of nodes on the other side of each topic."""
        try:
            publishing, listening, _ = self._master.getSystemState()
        except Exception as error:
            raise self._gone(error) from error
        me = self._rospy.get_name()
        sides = ((publishing, self._listeners), (listening, self._publishers))
        return {
            topic: sum(node != me and answers(node) for node in nodes)
            for others, ours in sides
            for topic, nodes in others
            if topic in ours
        }

    def _answers(self, node: str) -> bool:
        """Return whether a node is alive; the master keeps listing dead ones."""
        try:
            _reach(self._master.lookupNode(node))
        except Exception:  # noqa: BLE001  the master says in one way of its own that there is none
            return False
        return True

    def check(self) -> None:
        if time.monotonic() < self._checked_s + _CHECK_S:
            return
        if self._rospy.is_shutdown():
            raise SimulationError("ROS has shut this node down, as rosnode kill does")
        self._require_master()
        self._checked_s = time.monotonic()

    def _require_master(self) -> None:
        """Check the master; without one, rospy would wait forever when it joins a topic."""
        try:
            self._look_for_master()
        except _NOT_HERE as error:
            raise self._gone(error) from error

    def _gone(self, error: Exception) -> SimulationError:
        return SimulationError(f"the ROS master at {self._uri} was lost ({error})")

    def _look_for_master(self) -> None:
        on_loopback = urlsplit(self._uri).netloc.startswith(_LOOPBACK)
        if on_loopback and not {"ROS_IP", "ROS_HOSTNAME"} & os.environ.keys():
            os.environ["ROS_IP"] = "127.0.0.1"  # else rospy would listen on every network of the machine
        _reach(self._uri)

    def close(self) -> None:
        """Leave all topics; the node itself stays until the process ends."""
        try:
            self._look_for_master()
        except _NOT_HERE:
            return  # without a master rospy would log an error for each topic
        for end in (*self._publishers.values(), *self._listeners.values()):
            end.unregister()
        for service in self._services:
            service.shutdown()
        for name in self._parameters:
            self._rospy.delete_param(name)
        self._parameters.clear()
        self._publishers.clear()
        self._listeners.clear()
        self._services.clear()


def _unmoved(*_error: object) -> None:
    """Pass an error to the caller through rospy; it is not a fault of this process."""


def _reach(uri: str) -> None:
    """Check that there is a server at ``http://host:port``.

    Raises:
        OSError, ValueError: no server answered.
    """
    parts = urlsplit(uri)
    if parts.hostname is None or parts.port is None:
        raise ValueError("the address is not of the form http://host:port")
    socket.create_connection((parts.hostname, parts.port), timeout=2.0).close()


class _Ros1Publisher:
    """Publishes on one topic."""

    def __init__(self, publisher: Any, kind: type[Any]) -> None:
        self._publisher, self._kind = publisher, kind

    def peers(self) -> int:
        return int(self._publisher.get_num_connections())

    def publish(self, message: Any) -> None:
        self._publisher.publish(self._kind(CODEC.encode(message)))

    def unregister(self) -> None:
        """Leave the topic."""
        self._publisher.unregister()
