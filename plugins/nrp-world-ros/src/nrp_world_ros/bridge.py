"""The topics of a world in ROS: its sensor messages are published, and received commands are passed to it."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from queue import Empty, Full, Queue
from typing import Any

from nrp_core.errors import NrpError, SceneError, TopicError
from nrp_core.messages.base import Time
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.world import Closing, Code, Direction, Findings, Scene, Stamped, Subscription, TopicInfo, World

from nrp_world_ros.frames import TF, TF_STATIC, Frames
from nrp_world_ros.guard import UNSTAMPED, TwistStamped
from nrp_world_ros.node import PATIENCE_S, Node, Publisher, ros_type
from nrp_world_ros.timekeeping import CLOCK, Sent
from nrp_world_ros.urdf import described, urdf

_PATIENCE_S = 5.0
"""Time in which nodes that run already have found this one, s."""


class Audience:
    """Waits for a first subscriber or publisher in ROS.

    Args:
        node: in ROS.
        tell: is given the report, once.
    """

    def __init__(self, node: Node, tell: Callable[[str], None]) -> None:
        self._node, self._tell = node, tell
        self._until_s: float | None = time.monotonic() + _PATIENCE_S

    def update(self) -> None:
        """Report when the time is over; calling it often is cheap."""
        if self._until_s is None:
            return
        if self._node.met():
            self._until_s = None
        elif time.monotonic() > self._until_s:
            self._until_s = None
            self._tell(self._report())

    def _report(self) -> str:
        if unmatched := self._node.unmatched():
            return (
                f"no node can be connected to {', '.join(unmatched)}: the nodes there have another type of "
                "messages, or request a quality of service that is not offered"
            )
        return f"no other node listens or publishes here after {_PATIENCE_S:g} s; {self._node.reach}"


MOST = 256
"""Maximum number of calls that wait for the world."""


@dataclass(frozen=True, slots=True)
class _Call:
    """A request from ROS, and the place for its answer."""

    service: str
    do: Callable[[], Any]
    answer: Future[Any] = field(default_factory=Future)
    asked_s: float = field(default_factory=time.monotonic)


class Calls:
    """Answers calls from ROS on request.

    Args:
        world: the world that answers them.
        node: in ROS.
        warnings: receive failed calls in a ROS that does not report them to the caller.

    Attributes:
        services: their names.
    """

    def __init__(self, world: World, node: Node, warnings: Findings) -> None:
        self._world, self._node, self._codec = world, node, node.codec
        self._warnings = warnings
        self._waiting: Queue[_Call] = Queue(MOST)
        self._refused, self._closed = 0, False
        self.services: list[str] = []

    def offer(self) -> None:
        """Offer all services of the world in ROS."""
        for info in self._world.topics.values():
            if info.response is not None:
                request, response = map(self._codec.name, (info.type, info.response))
                self._node.serve(info.name, request, response, partial(self._take, info.name, request))
                self.services.append(info.name)

    def _take(self, service: str, kind: str, request: bytes) -> Future[memoryview]:
        return self.ask(service, lambda: self._do(service, kind, request))

    def ask(self, service: str, do: Callable[[], Any]) -> Future[Any]:
        """Accept a call, in a thread of ROS; in :meth:`answer`, ``do`` returns its response."""
        call = _Call(service, do)
        try:
            self._waiting.put_nowait(call)
        except Full:
            self._refused += 1
            call.answer.set_exception(TopicError(f"{service}: {MOST} calls wait already"))
        if self._closed:
            self._refuse()
        return call.answer

    def close(self) -> None:
        """Refuse the calls that wait, and all later ones."""
        self._closed = True
        self._refuse()

    def _refuse(self) -> None:
        while (call := self._next()) is not None:
            with suppress(InvalidStateError):  # no thread waits any more
                call.answer.set_exception(TopicError(f"{call.service}: this world has been closed"))

    def answer(self) -> None:
        """Answer all waiting calls; those that timed out are not executed."""
        if self._refused:
            message = f"{self._refused} calls were refused, because {MOST} waited already"
            self._warnings.add(Code.NRP282, message, subject="services")
            self._refused = 0
        while (call := self._next()) is not None:
            late = time.monotonic() > call.asked_s + PATIENCE_S
            if late or not call.answer.set_running_or_notify_cancel():
                continue
            try:
                call.answer.set_result(call.do())
            except NrpError as error:
                call.answer.set_exception(error)
                if not self._node.returns_errors:
                    message = f"a call got no answer, because ROS 2 cannot carry its error: {error}"
                    self._warnings.add(Code.NRP282, message, subject=call.service)

    def _do(self, service: str, kind: str, request: bytes) -> memoryview:
        return self._codec.encode(self._world.call(service, self._codec.decode(request, kind)))

    def _next(self) -> _Call | None:
        try:
            return self._waiting.get_nowait()
        except Empty:
            return None


_DEPTH = 256
"""Maximum number of messages of a topic in one step of the loop."""

Publish = Callable[[str, Any], None]


@dataclass(frozen=True, slots=True)
class Style:
    """What a program in ROS expects of the messages.

    Args:
        stamped: whether it sends ``TwistStamped`` to drives.
        bare: the robot whose frames it knows without the prefix ``robot/``.
        folders: those of models that it may spawn.
    """

    stamped: bool = False
    bare: str | None = None
    folders: tuple[Path, ...] = ()

    def frame(self, name: str) -> str:
        """Return the name of a frame."""
        return name if self.bare is None else name.removeprefix(f"{self.bare}/")

    def message(self, message: Any) -> Any:
        """Return a message with these names of frames."""
        header = getattr(message, "header", None)
        if self.bare is None or header is None:
            return message
        child = (
            {"child_frame_id": self.frame(message.child_frame_id)}
            if hasattr(message, "child_frame_id")
            else {}
        )
        return replace(message, header=replace(header, frame_id=self.frame(header.frame_id)), **child)


PLAIN = Style()


@dataclass(slots=True)
class Outlet:
    """A topic published in ROS, and its subscription in the world."""

    publisher: Publisher
    subscription: Subscription | None = None


class Bridge(Closing):
    """Transfers messages between a world and ROS on request.

    A topic without subscribers in ROS costs nothing. Besides the world's own topics and services there are
    ``/clock``, ``/tf`` with the links of all models that can move, and ``/tf_static``.

    Args:
        world: the world.
        node: in ROS.
        publish: publishes a message in the world.
        tell: receives warnings, also when no ROS node is found; None: a node exists that calls no
            services.
        style: of the messages.

    Attributes:
        left: topics whose subscriber has announced that it does not need more messages.
        warnings: warnings about messages that ROS 1 cannot carry, and about refused messages from ROS.
        incoming, outgoing: the topics from and to ROS.
    """

    def __init__(
        self, world: World, node: Node, publish: Publish, tell: Callable[[str], None] | None = None,
        style: Style = PLAIN,
    ) -> None:  # fmt: skip
        self._world, self._node, self._publish, self._style = world, node, publish, style
        self._stamped: dict[str, str] = {}
        self._outlets: dict[str, Outlet] = {}
        self.left: Collection[str] = ()
        self.warnings = Findings()
        self.incoming: list[str] = []
        self.follow()
        self._clock_type = ros_type("rosgraph_msgs/msg/Clock")
        self._clock = node.publisher(CLOCK, self._clock_type)
        self._frames = Frames(world, node, style.frame)
        self._calls = Calls(world, node, self.warnings)
        self._step_standard: Callable[[], None] = lambda: None
        self._audience = None
        self._tell, self._n_told = tell, 0
        if tell is not None:
            self._calls.offer()
            self._audience = Audience(node, tell)
            if not node.returns_errors:  # ROS 2, which has standards for controllers and simulators
                from nrp_world_ros.ros2.standard import Standard

                ros2: Any = node
                self._step_standard = Standard(world, ros2, publish, self._calls.ask, style.folders).step
        self._described: Scene | None = None
        self._sent_ns = -1

    def check(self) -> None:
        """Check the connection to ROS, and whether any node exists; report new warnings.

        Raises:
            SimulationError: it was lost.
        """
        self._node.check()
        self._describe()
        self.report()
        if self._audience is not None:
            self._audience.update()

    def _describe(self) -> None:
        """Transfer the topics of each new scene, and offer its URDFs, except for a body of another loop."""
        scene = self._world.scene
        if self._tell is None or scene is self._described:
            return
        if self._described is not None:
            self.follow()
        self._described = scene
        for name, model in described(scene).items():
            try:
                text, style = urdf(model), self._style
                self._node.keep(name, text if style.bare is None else text.replace(f'"{style.bare}/', '"'))
            except SceneError as error:
                self.warnings.add(Code.NRP282, f"{name} is not in ROS: {error}", subject=name)

    def report(self) -> None:
        """Tell the warnings since the last call, each once."""
        if self._tell is not None:
            for warning in self.warnings[self._n_told :]:
                self._tell(str(warning))
            self._n_told = len(self.warnings)

    def follow(self) -> None:
        """Transfer the present topics of the world; models may have been added and deleted."""
        topics = self._world.topics
        for name in self._outlets.keys() - topics.keys():
            self._mute(self._outlets.pop(name))
        self.incoming = [name for name in self.incoming if name in topics]
        for info in topics.values():
            if info.name not in self._outlets and info.name not in self.incoming:
                try:
                    self._connect(info)
                except TopicError as error:
                    self.warnings.add(Code.NRP282, f"{info.name} is not in ROS: {error}", subject=info.name)

    def _mute(self, outlet: Outlet) -> None:
        if outlet.subscription is not None:
            self._world.unsubscribe(outlet.subscription)
            outlet.subscription = None

    @property
    def outgoing(self) -> list[str]:
        """The topics that ROS can subscribe to."""
        return [*self._outlets, CLOCK, TF, TF_STATIC]

    def _connect(self, info: TopicInfo) -> None:
        if info.response is not None:
            return  # services are called instead
        if info.direction is Direction.OUT:
            self._outlets[info.name] = Outlet(self._node.publisher(info.name, info.type))
        else:
            stamped = info.name.removesuffix(UNSTAMPED)
            is_twist = info.type is Twist
            if is_twist and (self._style.stamped or stamped != info.name):
                self._node.listen(stamped, TwistStamped)
                self._stamped[stamped] = info.name
            if not (is_twist and self._style.stamped):
                self._node.listen(info.name, info.type)
            self.incoming.append(info.name)

    @property
    def services(self) -> list[str]:
        """The services that ROS can call."""
        return self._calls.services

    def answer(self) -> None:
        """Answer waiting calls of services, and follow the goals of actions."""
        self._calls.answer()
        self._step_standard()

    def receive(self) -> None:
        """Pass messages from ROS to the world; refused ones are dropped with a warning."""
        self.answer()
        for letter in self._node.inbox.take():
            topic = self._stamped.get(letter.topic, letter.topic)
            if topic in self.incoming:
                try:
                    message = letter.message
                    self._publish(topic, message.twist if letter.topic in self._stamped else message)
                except NrpError as error:
                    text = f"a message from {letter.sender} was dropped: {error}"
                    self.warnings.add(Code.NRP282, text, subject=letter.topic)

    def send(self) -> Sent:
        """Publish the new messages of the world since the last call.

        Returns:
            The published messages.
        """
        sent: Sent = {}
        for name, outlet in self._outlets.items():
            for stamped in _new(outlet, self._sent_ns):
                outlet.publisher.publish(self._style.message(stamped.message))
                sent.setdefault(name, []).append(stamped.t_ns)
        now_ns = self._world.now_ns
        self._frames.send(now_ns)
        self._clock.publish(self._clock_type(Time.from_ns(now_ns)))
        self._sent_ns = now_ns
        return sent

    def attend(self) -> None:
        """Subscribe in the world to exactly those topics that have subscribers in ROS."""
        for name, outlet in self._outlets.items():
            if outlet.publisher.peers() > (name in self.left):
                outlet.subscription = outlet.subscription or self._world.subscribe(name, depth=_DEPTH)
            else:
                self._mute(outlet)

    def restart(self, sent_ns: int = -1) -> None:
        """Continue at another time of the world, by default 0; earlier messages are not sent again."""
        self._sent_ns = sent_ns

    def close(self) -> None:
        """Leave ROS."""
        for outlet in self._outlets.values():
            self._mute(outlet)
        self._calls.close()
        self._node.close()


def _new(outlet: Outlet, since_ns: int) -> list[Stamped]:
    return [] if outlet.subscription is None else outlet.subscription.since(since_ns)
