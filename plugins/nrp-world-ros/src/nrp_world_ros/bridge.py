"""The topics of a world in ROS: its sensor messages are published, and received commands are passed to it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

from nrp_core.errors import NrpError, SceneError, TopicError
from nrp_core.world import Closing, Code, Direction, Findings, Scene, Stamped, Subscription, TopicInfo, World
from nrp_core.world.messages.base import Time

from nrp_world_ros.audience import Audience
from nrp_world_ros.calls import Calls
from nrp_world_ros.description import described, urdf
from nrp_world_ros.frames import TF, TF_STATIC, Frames
from nrp_world_ros.lockstep import Sent
from nrp_world_ros.node import Node, Publisher, ros_type
from nrp_world_ros.times import CLOCK

_DEPTH = 256
"""Maximum number of messages of a topic in one step of the loop."""

Publish = Callable[[str, Any], None]


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
        tell: is told of warnings, and when nobody in ROS is found; None: somebody is there, who calls no
            services.

    Attributes:
        left: topics whose subscriber has announced that it does not need more messages.
        warnings: warnings about messages that ROS 1 cannot carry, and about refused messages from ROS.
        incoming, outgoing: the topics from and to ROS.
    """

    def __init__(
        self, world: World, node: Node, publish: Publish, tell: Callable[[str], None] | None = None
    ) -> None:
        self._world, self._node, self._publish = world, node, publish
        self._outlets: dict[str, Outlet] = {}
        self.left: Collection[str] = ()
        self.warnings = Findings()
        self.incoming: list[str] = []
        self.follow()
        self._clock_type = ros_type("rosgraph_msgs/msg/Clock")
        self._clock = node.publisher(CLOCK, self._clock_type)
        self._frames = Frames(world, node)
        self._calls = Calls(world, node, self.warnings)
        self._audience = None
        self._tell, self._n_told = tell, 0
        if tell is not None:
            self._calls.offer()
            self._audience = Audience(node, tell)
        self._described: Scene | None = None
        self._sent_ns = -1

    def check(self) -> None:
        """Check the connection to ROS, and whether anybody is there; tell new warnings.

        Raises:
            SimulationError: it was lost.
        """
        self._node.check()
        self._describe()
        self.report()
        if self._audience is not None:
            self._audience.look()

    def _describe(self) -> None:
        """Offer the URDF of the robots, once for each scene; a body of another loop needs none."""
        scene = self._world.scene
        if self._tell is None or scene is self._described:
            return
        self._described = scene
        for name, model in described(scene).items():
            try:
                self._node.keep(name, urdf(model))
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
            self._node.listen(info.name, info.type)
            self.incoming.append(info.name)

    @property
    def services(self) -> list[str]:
        """The services that ROS can call."""
        return self._calls.services

    def answer(self) -> None:
        """Answer waiting calls of services."""
        self._calls.answer()

    def receive(self) -> None:
        """Pass messages from ROS to the world; refused ones are dropped with a warning."""
        self.answer()
        for letter in self._node.inbox.take():
            if letter.topic in self.incoming:
                try:
                    self._publish(letter.topic, letter.message)
                except NrpError as error:
                    message = f"a message from {letter.sender} was dropped: {error}"
                    self.warnings.add(Code.NRP282, message, subject=letter.topic)

    def send(self) -> Sent:
        """Publish the new messages of the world since the last call.

        Returns:
            The published messages.
        """
        sent: Sent = {}
        for name, outlet in self._outlets.items():
            for stamped in _new(outlet, self._sent_ns):
                outlet.publisher.publish(stamped.message)
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
