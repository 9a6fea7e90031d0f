"""This process as a node of ROS 2, by its own client library, rclpy.

Messages pass as bytes: rclpy encodes and decodes only calls of services. A thread receives them.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any

from nrp_core.errors import BackendLoadError, SimulationError, TopicError, did_you_mean
from nrp_core.messages.cdr import Codec
from nrp_core.messages.std_msgs import String

from nrp_world_ros.node import PATIENCE_S, Answer, Letter, Node, Publisher
from nrp_world_ros.options import LAST_DOMAIN
from nrp_world_ros.ros2.types import RosTypes

INSTALL = "pip install 'nrp-world-ros[ros2]'"
"""The wheels of ROS 2; with an installation of ROS, its set-up script does the same."""

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_RANGES = ("LOCALHOST", "SUBNET", "OFF", "SYSTEM_DEFAULT")

_DISCOVERY_S = 1.0
"""Time limit of the mutual discovery of a new node and others, s."""

_MUTUAL_S = 0.2
"""Time limit for a discovered node to discover this one, s."""

_PARTICIPANT = 12
"""Length of the part of a global identifier that names the process, in DDS."""


def load_rclpy() -> ModuleType:
    """Return rclpy.

    Raises:
        BackendLoadError: it is not installed.
    """
    try:
        import rclpy
    except ImportError as error:
        raise BackendLoadError(f"ROS 2 is not in this Python ({error})", remedy=INSTALL) from error
    module: ModuleType = rclpy
    return module


def domain_number(chosen: int | None, environ: Mapping[str, str] = os.environ) -> int:
    """Return the number of the domain.

    Args:
        chosen: the user's choice; None: ``ROS_DOMAIN_ID``, else 0.
        environ: the environment variables.

    Raises:
        BackendLoadError: the domain does not exist.
    """
    text = environ.get("ROS_DOMAIN_ID", "") if chosen is None else str(chosen)
    if text and not (text.isdecimal() and int(text) <= LAST_DOMAIN):
        raise BackendLoadError(f"ROS_DOMAIN_ID is a number from 0 to {LAST_DOMAIN}, not '{text}'")
    return int(text or 0)


def discovery_range(environ: Mapping[str, str] = os.environ) -> str:
    """Return how far nodes are searched: by default only on this machine, where ROS searches the subnet.

    Raises:
        BackendLoadError: ROS 2 does not have such a range.
    """
    wanted = environ.get(_RANGE) or _RANGES[0]
    if wanted not in _RANGES:
        hint = did_you_mean(wanted, _RANGES)
        raise BackendLoadError(f"{_RANGE} is one of {', '.join(_RANGES)}, not '{wanted}'{hint}")
    return wanted


def reach(number: int, environ: Mapping[str, str] = os.environ) -> str:
    """Return which nodes are found, for a report that none are."""
    near = {
        "LOCALHOST": f"on this machine; to find those of others, set {_RANGE}=SUBNET for all",
        "OFF": f"which searches nobody, because {_RANGE} is OFF",
    }.get(discovery_range(environ), "on this subnet, if it carries multicast; else set ROS_STATIC_PEERS")
    return f"domain {number}, {near}. Others have the same ROS_DOMAIN_ID and the same RMW_IMPLEMENTATION"


class Ros2Node(Node):
    """See :class:`~nrp_world_ros.node.Node`.

    Args:
        name: name of the node.
        queue: queue length for a slow subscriber, beyond which the oldest messages are lost; 0: unlimited.
        domain: its number; None: ``ROS_DOMAIN_ID``, else 0.
        parameters: whether it offers the services of parameters.

    Attributes:
        types: its classes of messages, services and actions.

    Raises:
        BackendLoadError: ROS 2 is not installed, or cannot use the network.
    """

    tool = "ros2 topic"
    returns_errors = False

    def __init__(
        self, name: str, *, queue: int = 0, domain: int | None = None, parameters: bool = False
    ) -> None:
        super().__init__(Codec())
        self._rclpy: Any = load_rclpy()
        self.types = RosTypes(self.codec)
        self._parameters = parameters
        self._queue = queue
        self._namespace = ""
        self._number = domain_number(domain)
        self._publishers: dict[str, _Ros2Publisher] = {}
        self._listeners: dict[str, _Listener] = {}
        self._clients: dict[str, Any] = {}
        self._matched: tuple[dict[str, int], float] = ({}, time.monotonic())
        self._joined_s = time.monotonic()
        self._error: Exception | None = None
        self._join(name)

    def _join(self, name: str) -> None:
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions

        self._context = self._rclpy.Context()
        with _environment(_RANGE, discovery_range()):
            try:
                self._rclpy.init(
                    context=self._context, domain_id=self._number,
                    signal_handler_options=SignalHandlerOptions.NO,
                )  # fmt: skip
                self._node = self._rclpy.create_node(
                    name, context=self._context, use_global_arguments=False, enable_rosout=False,
                    start_parameter_services=self._parameters,
                )  # fmt: skip
            except Exception as error:
                self._rclpy.try_shutdown(context=self._context)
                raise BackendLoadError(f"ROS 2 cannot join domain {self._number}: {error}") from error
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._open = True
        self._thread = threading.Thread(target=self._spin, name="ros2", daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        try:
            while self._open:
                with suppress(_NoAnswerError):
                    self._executor.spin_once()
        except Exception as error:  # noqa: BLE001  reported to the loop, which runs in another thread
            if self._open:
                self._error = error

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
        for listener in self._listeners.values():
            listener.close()
        for publisher in self._publishers.values():
            publisher.close()
        self._listeners.clear()
        self._publishers.clear()
        self.inbox.take()

    def publisher(self, topic: str, cls: type, *, latched: bool = False) -> Publisher:
        if topic not in self._publishers:
            self._require_open()
            from rclpy.event_handler import PublisherEventCallbacks

            kind = self.types.message(self.codec.name(cls))
            qos = _qos(1 if latched else self._queue, latched=latched)
            with _refusing(topic):
                made = self._node.create_publisher(
                    kind,
                    self._namespace + topic,
                    qos,
                    event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
                )
            self._publishers[topic] = _Ros2Publisher(topic, self._node, made, self.codec)
        return self._publishers[topic]

    def listen(self, topic: str, cls: type) -> None:
        if topic in self._listeners:
            return
        self._require_open()
        name = self.codec.name(cls)

        def arrived(data: bytes, info: Mapping[str, Any]) -> None:
            self.inbox.add(Letter(topic, name, data, _sender(info), self.codec))

        with _refusing(topic):
            self._listeners[topic] = _Listener(
                self._node, self.types.message(name), self._namespace + topic, arrived
            )

    def serve(self, service: str, request: str, response: str, answer: Answer) -> None:
        from rclpy.serialization import deserialize_message, serialize_message

        kind = self.types.service(request, response)
        self._serve(
            service,
            kind,
            lambda asked, _empty: answer(serialize_message(asked)),
            lambda data: deserialize_message(bytes(data), kind.Response),
        )

    def offer(self, service: str, kind: str, ask: Callable[[Any, Any], Future[Any]]) -> None:
        """Offer a service of a type, ``package/srv/Name``.

        Args:
            service: its name.
            kind: its type.
            ask: takes a request and an empty response, of ROS's classes, in a thread of ROS; the response
                comes later.
        """
        self._serve(service, self.types.named(kind), ask, lambda response: response)

    def _serve(
        self, service: str, kind: Any, ask: Callable[[Any, Any], Future[Any]], read: Callable[[Any], Any]
    ) -> None:
        self._require_open()

        def called(request: Any, response: Any) -> Any:
            coming = ask(request, response)
            self.inbox.wake()
            try:
                return read(coming.result(PATIENCE_S))
            except Exception as error:  # ROS 2 has no place for the reason; the loop has reported it
                coming.cancel()
                raise _NoAnswerError from error

        with _refusing(service):
            self._node.create_service(kind, service, called)

    def act(self, name: str, kind: str, accepts: Callable[[Any], bool], take: Callable[[Any], None]) -> Any:
        """Offer an action, and return its server.

        Args:
            name: its name.
            kind: its type, ``package/action/Name``.
            accepts: returns whether a goal is accepted.
            take: takes an accepted goal. Both are called in a thread of ROS.
        """
        from rclpy.action import ActionServer, CancelResponse, GoalResponse

        self._require_open()
        with _refusing(name):
            return ActionServer(
                self._node,
                self.types.named(kind),
                name,
                execute_callback=lambda _goal: None,
                goal_callback=lambda goal: GoalResponse.ACCEPT if accepts(goal) else GoalResponse.REJECT,
                handle_accepted_callback=take,
                cancel_callback=lambda _goal: CancelResponse.ACCEPT,
            )

    @staticmethod
    def begin(goal: Any) -> None:
        """Show an accepted goal as executing; rclpy would call a function that waits for its end."""
        from rclpy.action.server import GoalEvent

        if not goal.is_cancel_requested:
            goal._update_state(GoalEvent.EXECUTE)

    def ours(self, message: Any, cls: type) -> Any:
        """Return a message of ROS's class as one of the platform's class."""
        name = self.codec.name(cls)
        return self.codec.decode(self.codec.encode_as(message, name), name)

    def call(self, service: str, request: Any, response: type, timeout_s: float) -> Any:
        from rclpy.serialization import deserialize_message, serialize_message

        self._require_open()
        time.sleep(max(0.0, self._joined_s + _DISCOVERY_S - time.monotonic()))
        if service not in dict(self._node.get_service_names_and_types()):
            return None
        asked, answer = self.codec.name(type(request)), self.codec.name(response)
        kind = self.types.service(asked, answer)
        if service not in self._clients:
            self._clients[service] = self._node.create_client(kind, service)
        client = self._clients[service]
        if not client.wait_for_service(timeout_s):
            return None
        message = deserialize_message(bytes(self.codec.encode(request)), kind.Request)
        try:
            received = client.call(message, timeout_s)
        except TimeoutError:
            raise SimulationError(f"{service} has not answered within {timeout_s:g} s") from None
        return self.codec.decode(serialize_message(received), answer)

    def keep(self, name: str, text: str) -> None:
        self.publisher(name, String, latched=True).publish(String(text))
        parameter = name.strip("/").replace("/", ".")
        if self._parameters and not self._node.has_parameter(parameter):
            self._node.declare_parameter(parameter, text)

    # -- discovery

    def _ends(self) -> dict[str, _End]:
        """Return the publishers and subscriptions by topic."""
        return {**self._listeners, **self._publishers}

    def peers(self, topic: str) -> int:
        return self._ends()[topic].peers()

    def met(self) -> list[str]:
        return [topic for topic, end in self._ends().items() if end.peers()]

    def unmatched(self) -> list[str]:
        return [topic for topic, end in self._ends().items() if end.listed() and not end.peers()]

    def sees(self, topic: str, other: str) -> bool:
        end = self._ends().get(topic)
        return end is None or end.sees(other)

    def settle(self, timeout_s: float) -> set[str]:
        self._require_open()
        end_s = time.monotonic() + timeout_s
        while True:
            for listener in self._listeners.values():
                listener.adapt()
            counts, now_s = {topic: end.peers() for topic, end in self._ends().items()}, time.monotonic()
            if counts != self._matched[0]:
                self._matched = (counts, now_s)
            alone = {topic for topic, count in counts.items() if not count}
            searched = not alone or now_s > self._joined_s + _DISCOVERY_S
            if now_s > end_s or (searched and now_s > self._matched[1] + _MUTUAL_S):
                return alone
            time.sleep(0.01)

    def check(self) -> None:
        self._require_open()
        if self._error is not None:
            raise SimulationError(f"ROS 2 has stopped delivering messages: {self._error}") from self._error

    def _require_open(self) -> None:
        if not self._open:
            raise SimulationError("this node has left ROS 2")

    def close(self) -> None:
        if self._open:
            self._open = False
            self._executor.shutdown()
            self._thread.join()
            self._leave_topics()
            self._node.destroy_node()
            self._rclpy.try_shutdown(context=self._context)


class _NoAnswerError(Exception):
    """A call of a service that gets no answer."""


class _End:
    """A publisher or a subscription, and the nodes on the other side."""

    def __init__(self, node: Any, topic: str) -> None:
        self._node, self._topic = node, topic
        self._known: set[str] = set()

    def peers(self) -> int:
        """Return the number of nodes on the other side that are connected."""
        raise NotImplementedError

    def listed(self) -> list[Any]:
        """Return the other side's descriptions in ROS's graph, whether or not they can be connected."""
        raise NotImplementedError

    def _others(self) -> list[str]:
        """Return the processes on the other side that can be connected."""
        raise NotImplementedError

    def sees(self, other: str) -> bool:
        """Return whether a process is connected."""
        if not self.peers():
            self._known.clear()
        elif other not in self._known:
            others = self._others()
            if len(others) <= self.peers():  # a node is listed some time before it is connected
                self._known = set(others)
        return other in self._known


class _Ros2Publisher(_End):
    """Publishes on one topic."""

    def __init__(self, topic: str, node: Any, publisher: Any, codec: Codec) -> None:
        super().__init__(node, publisher.topic_name)
        self._name, self._publisher, self._codec = topic, publisher, codec

    def peers(self) -> int:
        return int(self._publisher.get_subscription_count())

    def listed(self) -> list[Any]:
        infos: list[Any] = self._node.get_subscriptions_info_by_topic(self._topic)
        return infos

    def _others(self) -> list[str]:
        mine = self._publisher.qos_profile
        return [_process(info.endpoint_gid) for info in self.listed() if _suffices(mine, info.qos_profile)]

    def publish(self, message: Any) -> None:
        data = bytes(self._codec.encode(message))
        try:
            self._publisher.publish(data)
        except Exception as error:
            raise SimulationError(f"a message on {self._name} was not accepted: {error}") from error

    def close(self) -> None:
        """Leave the topic."""
        self._node.destroy_publisher(self._publisher)


class _Listener(_End):
    """Receives the messages of one topic as bytes; it requests reliability if a publisher offers it."""

    def __init__(self, node: Any, kind: Any, topic: str, arrived: Callable[..., None]) -> None:
        super().__init__(node, topic)
        self._kind, self._arrived = kind, arrived
        self._subscribe(_qos(0))

    def _subscribe(self, qos: Any) -> None:
        from rclpy.event_handler import SubscriptionEventCallbacks

        silent = SubscriptionEventCallbacks(use_default_callbacks=False)  # see adapt()
        self._subscription = self._node.create_subscription(
            self._kind, self._topic, self._arrived, qos, event_callbacks=silent, raw=True
        )

    def peers(self) -> int:
        return int(self._subscription.get_publisher_count())

    def listed(self) -> list[Any]:
        infos: list[Any] = self._node.get_publishers_info_by_topic(self._topic)
        return infos

    def _others(self) -> list[str]:
        mine = self._subscription.qos_profile
        return [_process(info.endpoint_gid) for info in self.listed() if _suffices(info.qos_profile, mine)]

    def adapt(self) -> None:
        """Request only best effort from publishers that offer less, as drivers of sensors do."""
        from rclpy.qos import ReliabilityPolicy

        if self.peers() or self._subscription.qos_profile.reliability is ReliabilityPolicy.BEST_EFFORT:
            return
        infos = self.listed()
        if infos and all(info.qos_profile.reliability is ReliabilityPolicy.BEST_EFFORT for info in infos):
            self.close()
            modest = _qos(0)
            modest.reliability = ReliabilityPolicy.BEST_EFFORT
            self._subscribe(modest)

    def close(self) -> None:
        """Leave the topic."""
        self._node.destroy_subscription(self._subscription)


def _qos(queue: int, *, latched: bool = False) -> Any:
    """Return ROS 2's default quality of service, reliable; late subscribers receive latched messages."""
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        history=HistoryPolicy.KEEP_LAST if queue else HistoryPolicy.KEEP_ALL,
        depth=queue,
    )


def _suffices(offered: Any, requested: Any) -> bool:
    """Return whether the quality of service of a publisher satisfies a subscription."""
    from rclpy.qos import QoSCompatibility, qos_check_compatible

    return qos_check_compatible(offered, requested)[0] is not QoSCompatibility.ERROR


def _sender(info: Mapping[str, Any]) -> str:
    """Return the process that has sent a message; older versions of ROS do not report it."""
    gid = info.get("publisher_gid")
    return "" if gid is None else _process(gid["data"])


def _process(gid: Any) -> str:
    return bytes(gid[:_PARTICIPANT]).hex()


@contextmanager
def _refusing(topic: str) -> Iterator[None]:
    """Report a name that ROS 2 does not permit as ours."""
    try:
        yield
    except Exception as error:
        if isinstance(error, (TopicError, BackendLoadError)):
            raise
        raise TopicError(f"{topic} cannot be a topic of ROS 2: {error}") from error


@contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    """Set an environment variable for some time."""
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before
