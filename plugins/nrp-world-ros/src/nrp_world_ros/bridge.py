"""The topics of a world in ROS: what it senses is published there, what comes from there is given to it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

from nrp_core.errors import NrpError, TopicError
from nrp_core.world import Closing, Direction, Stamped, Subscription, TopicInfo, World
from nrp_core.world.messages.base import Time
from nrp_core.world.services.service import PREFIX

from nrp_world_ros.calls import Calls
from nrp_world_ros.frames import TF, Frames
from nrp_world_ros.lockstep import Sent
from nrp_world_ros.node import Node, Publisher, ros_type
from nrp_world_ros.times import CLOCK

_DEPTH = 256
"""How many messages of a topic may come in one step of the loop."""

Publish = Callable[[str, Any], None]


@dataclass(slots=True)
class Outlet:
    """A topic that goes to ROS, and who listens in the world for it."""

    publisher: Publisher
    subscription: Subscription | None = None


class Bridge(Closing):
    """Carries messages between a world and ROS, whenever it is told to.

    A topic that nobody in ROS listens to costs nothing. Besides the world's own topics and services there are
    ``/clock`` and, with the links of all models that can move, ``/tf``.

    Args:
        world: the world.
        node: in ROS.
        publish: gives a message to the world.

    Attributes:
        left: topics of which one who listens has said that it wants nothing more.
        warnings: what ROS 1 cannot carry, and what came from there and was refused.
        incoming, outgoing: the topics from and to ROS.
    """

    def __init__(self, world: World, node: Node, publish: Publish) -> None:
        self._world, self._node, self._publish = world, node, publish
        self._outlets: dict[str, Outlet] = {}
        self.left: Collection[str] = ()
        self.warnings: list[str] = []
        self.incoming: list[str] = []
        self.follow()
        self._clock_type = ros_type("rosgraph_msgs/msg/Clock")
        self._clock = node.publisher(CLOCK, self._clock_type)
        self._frames = Frames(world, node)
        self._calls = Calls(world, node)
        self._sent_ns = -1

    def follow(self) -> None:
        """Carry the topics that the world has now; models may have come and gone."""
        topics = self._world.topics
        for name in self._outlets.keys() - topics.keys():
            self._mute(self._outlets.pop(name))
        self.incoming = [name for name in self.incoming if name in topics]
        for info in topics.values():
            if info.name not in self._outlets and info.name not in self.incoming:
                try:
                    self._connect(info)
                except TopicError as error:
                    self._warn(f"{info.name} is not in ROS: {error}")

    def _mute(self, outlet: Outlet) -> None:
        if outlet.subscription is not None:
            self._world.unsubscribe(outlet.subscription)
            outlet.subscription = None

    @property
    def outgoing(self) -> list[str]:
        """The topics that ROS can listen to."""
        return [*self._outlets, CLOCK, TF]

    def _connect(self, info: TopicInfo) -> None:
        if info.name.startswith(PREFIX) and info.direction is Direction.IN:
            return  # a service: it is called
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
        """Answer the calls of services that wait."""
        self._calls.answer()

    def receive(self) -> None:
        """Give the world what has come from ROS; what it refuses is dropped, with a warning."""
        self.answer()
        for letter in self._node.inbox.take():
            if letter.topic in self.incoming:
                try:
                    self._publish(letter.topic, letter.message)
                except NrpError as error:
                    self._warn(f"a message from {letter.sender} was dropped: {error}")

    def send(self) -> Sent:
        """Publish what is new in the world since the last time.

        Returns:
            what went out.
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
        """Listen in the world to what somebody in ROS listens to, and to nothing else."""
        for name, outlet in self._outlets.items():
            if outlet.publisher.peers() > (name in self.left):
                outlet.subscription = outlet.subscription or self._world.subscribe(name, depth=_DEPTH)
            else:
                self._mute(outlet)

    def restart(self, sent_ns: int = -1) -> None:
        """The world is at another time than it was, by default back at 0; all until then was sent."""
        self._sent_ns = sent_ns

    def _warn(self, warning: str) -> None:
        if warning not in self.warnings:
            self.warnings.append(warning)

    def close(self) -> None:
        """Leave ROS."""
        for outlet in self._outlets.values():
            self._mute(outlet)
        self._node.close()


def _new(outlet: Outlet, since_ns: int) -> list[Stamped]:
    return [] if outlet.subscription is None else outlet.subscription.since(since_ns)
