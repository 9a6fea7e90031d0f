"""Named, typed topics: the one way to talk to a world, as in ROS."""

from __future__ import annotations

import dataclasses
import posixpath
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import Flag, auto
from typing import Any

from nrp_core.errors import TopicError
from nrp_core.world.messages.base import invalid_field, type_name


class Direction(Flag):
    """Which way messages go."""

    OUT = auto()
    """From the world: can be subscribed to."""
    IN = auto()
    """To the world: can be published on."""
    BOTH = OUT | IN


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """What is known of a topic.

    Args:
        name: absolute, ``/husky/camera``.
        type: the message class.
        direction: which way messages go.
        rate_hz: messages a second; None: the value now, at any time.
        what: one line for people.
        limits: what every field of a message lies between, all of them numbers; None: anywhere.
        delay: from a sample to the arrival of its message, s.
        drop_out: share of the samples that get lost.
    """

    name: str
    type: type
    direction: Direction
    rate_hz: float | None = None
    what: str = ""
    limits: tuple[float, float] | None = None
    delay: float = 0.0
    drop_out: float = 0.0


@dataclass(frozen=True, slots=True)
class Stamped:
    """A message and the time it came, ns; without a delay that is when it was taken."""

    t_ns: int
    message: Any


class Subscription:
    """What came on a topic since it was subscribed; reading changes nothing.

    Args:
        topic: the topic.
        depth: how many messages are kept for :meth:`since`.
        current: gives the value now, for topics without a rate.
    """

    def __init__(
        self, topic: TopicInfo, depth: int = 1, current: Callable[[], Stamped | None] | None = None
    ) -> None:
        self.topic = topic
        self._kept: deque[Stamped] = deque(maxlen=depth)
        self._current = current

    @property
    def latest(self) -> Stamped | None:
        """The last message, or None before the first one."""
        if self._current is not None:
            return self._current()
        return self._kept[-1] if self._kept else None

    def since(self, t_ns: int) -> list[Stamped]:
        """Return the kept messages that came after ``t_ns``, oldest first."""
        if self._current is not None:
            now = self._current()
            return [now] if now is not None and now.t_ns > t_ns else []
        return [stamped for stamped in self._kept if stamped.t_ns > t_ns]

    def push(self, stamped: Stamped) -> None:
        """Add a message (for the world)."""
        self._kept.append(stamped)

    def clear(self) -> None:
        """Forget all messages."""
        self._kept.clear()

    def kept(self) -> list[Stamped]:
        """Return all kept messages, oldest first."""
        return list(self._kept)


class Publication:
    """The right to publish on a topic."""

    def __init__(self, topic: TopicInfo, deliver: Callable[[Any], None]) -> None:
        self.topic = topic
        self._deliver = deliver

    def publish(self, message: Any) -> None:
        """Send a message; it takes effect now.

        Raises:
            TopicError: the topic cannot carry the message.
        """
        check_message(self.topic, message)
        self._deliver(message)


def resolve_name(name: str, namespace: str) -> str:
    """Return the absolute name of a topic: a relative one lies below the namespace, as in ROS."""
    return posixpath.normpath(posixpath.join("/", namespace, name.removeprefix("~/")))


def check_message(topic: TopicInfo, message: Any) -> None:
    """Refuse a message that the topic cannot carry.

    Raises:
        TopicError: it is of another type, or holds a number that is not finite or beyond the topic's limits.
    """
    if not isinstance(message, topic.type) and type_name(type(message)) != type_name(topic.type):
        raise TopicError(
            f"{topic.name} carries {type_name(topic.type)}, not {type(message).__name__} ({message!r:.80})"
        )
    if dataclasses.is_dataclass(message):
        wrong = invalid_field(message)
        if wrong:
            raise TopicError(f"{topic.name}: in {type_name(topic.type)}, {wrong}")
    if topic.limits is not None:
        low, high = topic.limits
        for field in dataclasses.fields(topic.type):
            value = getattr(message, field.name)
            if not low <= value <= high:
                raise TopicError(f"{topic.name}: {field.name} must be from {low:g} to {high:g}, not {value}")
