"""Parts whose body is behind ROS: sensor messages come from there, commands go there."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Protocol

from nrp_core.world import Direction, Part, PartProxy, Stamped, TopicInfo


class Post(Protocol):
    """Transfers messages between parts and ROS."""

    def is_heard(self, topic: TopicInfo) -> bool:
        """Return whether the messages of an outgoing topic are passed on as they come."""

    def attend(self, topics: Iterable[TopicInfo], subscribed: frozenset[str]) -> None:
        """Subscribe to those of the topics that are subscribed to here."""

    def arrived(self, topic: str) -> list[Stamped]:
        """Return the messages of a topic in the last step."""

    def last(self, topic: str) -> Any:
        """Return the current message of a topic, or None."""

    def tell(self, topic: TopicInfo, message: Any) -> None:
        """Publish a message."""


class RemotePart(PartProxy):
    """A part whose topics are in ROS. A bidirectional topic is also handled here.

    Args:
        inner: the core's part.
        post: transfers messages.
    """

    def __init__(self, inner: Part, post: Post) -> None:
        super().__init__(inner)
        self._post = post
        self._infos = {topic.name: topic for topic in inner.topics}
        self._remote = [topic for topic in inner.topics if topic.direction is not Direction.BOTH]
        outgoing = [topic for topic in self._remote if Direction.OUT in topic.direction]
        self.number_topics = frozenset()
        self.pushed_topics = frozenset(topic.name for topic in outgoing if post.is_heard(topic))

    def on_subscriptions_changed(self, subscribed: frozenset[str]) -> None:
        self._post.attend(self._remote, subscribed)

    def poll(self) -> Iterable[tuple[str, Stamped]]:
        for topic in self._infos:
            if topic in self.pushed_topics:
                for stamped in self._post.arrived(topic):
                    yield topic, stamped

    def read(self, topic: str, now_ns: int) -> Any:
        message = self._post.last(topic)
        return super().read(topic, now_ns) if message is None else message

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        info = self._infos[topic]
        if info.direction is Direction.BOTH:
            super().write(topic, message, now_ns)
        self._post.tell(info, message)
