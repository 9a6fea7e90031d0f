"""Named, typed topics, as in ROS: the only interface for data to and from a world."""

from __future__ import annotations

import builtins
import dataclasses
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Flag, auto
from math import isfinite
from typing import Any, Protocol

from nrp_core.clock import NS_PER_S
from nrp_core.errors import TopicError
from nrp_core.messages.base import holds_finite_floats, invalid_field, layout_of, type_name


class Direction(Flag):
    """The direction of messages."""

    OUT = auto()
    """From the world: can be subscribed to."""
    IN = auto()
    """To the world: can be published on."""
    BOTH = OUT | IN


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """The description of a topic.

    Args:
        name: the absolute name, ``/husky/camera``.
        type: the message class.
        direction: the direction of messages.
        rate_hz: messages per second; None: the current value, at any time.
        what: a description in one line.
        limits: limits of every number of a message; None: unlimited. Others are refused.
        delay: from a sample to the arrival of its message, s.
        drop_out: share of lost samples.
        response: the message class of the answer, where the topic takes the requests of a service.
        unit: of a message that is one number.
        elements: names of the items of the arrays of a message, in their order.
        clips: whether numbers beyond the limits are clipped instead.
    """

    name: str
    type: type
    direction: Direction
    rate_hz: float | None = None
    what: str = ""
    limits: tuple[float, float] | None = None
    delay: float = 0.0
    drop_out: float = 0.0
    response: builtins.type | None = None
    unit: str = ""
    elements: tuple[str, ...] = ()
    clips: bool = False


@dataclass(frozen=True, slots=True)
class Stamped:
    """A message and the time of its arrival, ns, which is the time of the sample plus the delay."""

    t_ns: int
    message: Any


class Subscription:
    """The messages received on a topic since the subscription.

    :attr:`latest` is the last message, and :meth:`take` returns each message once. Without a ``depth``, no
    message of the present step is dropped, whatever the rate of the topic; of older messages that no reader
    has taken, those of the last :attr:`keep_ns` before the step stay.

    Args:
        topic: the topic.
        depth: number of messages stored; None: all until they are taken.
        current: returns the current value, for topics without a rate; it is the only message then.

    Attributes:
        is_read: whether the messages have a reader; samples without a reader are not taken.
        keep_ns: how long messages are stored that no reader takes, without a depth.
        dropped: number of messages that were dropped since the last :meth:`take`, without a depth.
    """

    def __init__(
        self, topic: TopicInfo, depth: int | None = 1, current: Callable[[], Stamped | None] | None = None
    ) -> None:
        self.topic, self.depth = topic, depth
        self.is_read = True
        self.keep_ns = NS_PER_S
        self.dropped = 0
        self._messages: deque[Stamped] = deque(maxlen=depth)
        self._taken: Stamped | None = None
        self._current = current

    @property
    def latest(self) -> Stamped | None:
        """The last message, or None before the first one."""
        if self._current is not None:
            return self._current()
        return self._messages[-1] if self._messages else self._taken

    @property
    def has_news(self) -> bool:
        """Whether it holds messages that :meth:`take` has not returned."""
        return bool(self._messages) or (self._current is not None and self._current() is not None)

    @property
    def messages(self) -> tuple[Stamped, ...]:
        """The stored messages that have not been taken, oldest first; they stay stored."""
        return (*self._messages, *self._now())

    def since(self, t_ns: int) -> list[Stamped]:
        """Return the stored messages with times after ``t_ns``, oldest first; they stay stored."""
        return [stamped for stamped in self.messages if stamped.t_ns > t_ns]

    def take(self, most: int | None = None) -> list[Stamped]:
        """Return the messages since the last call, oldest first, each with its time.

        Args:
            most: the largest number of messages, the first ones; None: all. A topic without a rate has one
                message in each call, its current value.
        """
        stored = self._messages
        if self._current is not None:
            return self._now()
        if not stored:
            return []
        if most is None or most >= len(stored):
            taken = list(stored)
            stored.clear()
        else:
            taken = [stored.popleft() for _ in range(most)]
        if taken:
            self._taken = taken[-1]
        self.dropped = 0
        return taken

    def push(self, stamped: Stamped) -> None:
        """Add a message (for the world)."""
        self._messages.append(stamped)

    def drop_old(self, now_ns: int) -> None:
        """Drop messages that have waited longer than :attr:`keep_ns` (for the world, before each step)."""
        stored, oldest_ns = self._messages, now_ns - self.keep_ns
        while len(stored) > 1 and stored[0].t_ns < oldest_ns:
            stored.popleft()
            self.dropped += 1

    def clear(self) -> None:
        """Remove all messages, the last one too."""
        self._messages.clear()
        self._taken, self.dropped = None, 0

    def save(self) -> tuple[list[Stamped], int]:
        """Return the stored messages, else the last one, and how many of them have not been taken."""
        stored = list(self._messages)
        return stored or ([] if self._taken is None else [self._taken]), len(stored)

    def restore(self, messages: Sequence[Stamped], untaken: int | None = None) -> None:
        """Restore a state from :meth:`save`; by default no message has been taken."""
        self.clear()
        self._messages.extend(messages)
        if not untaken and untaken is not None and messages:
            self._messages.clear()
            self._taken = messages[-1]

    def _now(self) -> list[Stamped]:
        now = None if self._current is None else self._current()
        return [] if now is None else [now]


class Board(Protocol):
    """Where publications deliver, by the names of topics: the switchboard of a world."""

    def deliver(self, name: str, message: Any, *, is_own: bool = False) -> None:
        """Deliver a checked message; it is copied unless nobody else has it."""

    def deliver_numbers(self, name: str, numbers: Sequence[float]) -> bool:
        """Deliver the finite numbers of a message to its only receiving part, if any."""


class Publication:
    """The right to publish on a topic.

    Args:
        topic: the topic, by the name for messages to the user.
        name: its name, never an alias.
        board: delivers the messages.
    """

    def __init__(self, topic: TopicInfo, name: str, board: Board) -> None:
        self.topic, self.name, self.board = topic, name, board

    def publish(self, message: Any) -> None:
        """Publish a message; it takes effect at once, or when all transfer functions of the step have run.

        Raises:
            TopicError: the topic cannot carry the message.
        """
        check_message(self.topic, message)
        self.board.deliver(self.name, message)

    def publish_numbers(self, numbers: Sequence[float]) -> None:
        """Publish a message of numbers, which is built only if it has a receiver other than its part.

        Args:
            numbers: the numbers in the message, in the order of its fields.

        Raises:
            TopicError: the topic cannot carry the message.
        """
        if not (isfinite(sum(numbers)) and self.board.deliver_numbers(self.name, numbers)):
            message = layout_of(self.topic.type).message(numbers)
            check_message(self.topic, message)
            self.board.deliver(self.name, message, is_own=True)


def require_finite(topic: str, numbers: Sequence[float]) -> None:
    """Require that the numbers of a command are finite.

    Raises:
        TopicError: one is not.
    """
    if not isfinite(sum(numbers)) and not all(map(isfinite, numbers)):  # of a sum first: it is faster
        raise TopicError(f"{topic}: every number must be finite, not {list(numbers)}")


def check_message(topic: TopicInfo, message: Any) -> None:
    """Refuse a message that the topic cannot carry.

    Raises:
        TopicError: it has another type, or a number in it is not finite or exceeds the topic's limits.
    """
    if type(message) is not topic.type or not holds_finite_floats(message):
        if not isinstance(message, topic.type) and type_name(type(message)) != type_name(topic.type):
            given = f"{type(message).__name__} ({message!r:.80})"
            raise TopicError(f"{topic.name} carries {type_name(topic.type)}, not {given}")
        if wrong := invalid_field(message):
            raise TopicError(f"{topic.name}: in {type_name(topic.type)}, {wrong}")
    if topic.limits is not None and not topic.clips:
        low, high = topic.limits
        for field in dataclasses.fields(topic.type):
            value = getattr(message, field.name)
            if not low <= value <= high:
                raise TopicError(f"{topic.name}: {field.name} must be from {low:g} to {high:g}, not {value}")
