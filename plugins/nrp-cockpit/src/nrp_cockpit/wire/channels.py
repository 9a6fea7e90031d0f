"""The channels that a server advertises, and their messages."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import Any, NamedTuple


class Kind(Enum):
    """The messages that a slow client loses."""

    LATEST = auto()
    """Older messages: the latest one wins (images, poses, states)."""
    EVERY = auto()
    """Only messages beyond a bound, which are counted (spikes, events, values)."""


@dataclass(frozen=True, slots=True)
class Channel:
    """An advertised topic.

    Args:
        id: its number.
        topic: its name.
        encoding: ``json`` or ``cdr``.
        schema_name: the name of its message type.
        schema: the definition of that type.
        kind: the messages that a slow client loses.
    """

    id: int
    topic: str
    encoding: str
    schema_name: str
    schema: str
    kind: Kind = Kind.EVERY

    def to_dict(self) -> dict[str, Any]:
        """Return its advertisement in the protocol."""
        return {
            "id": self.id, "topic": self.topic, "encoding": self.encoding, "schemaName": self.schema_name,
            "schema": self.schema,
            "schemaEncoding": "ros2msg" if self.encoding == "cdr" else "jsonschema",
        }  # fmt: skip


class Sent(NamedTuple):
    """A message on a channel.

    Args:
        channel: the channel.
        t_ns: its time.
        pieces: its content in pieces (items of one byte), because joining them would copy an image.
    """

    channel: Channel
    t_ns: int
    pieces: tuple[bytes | memoryview, ...]

    @property
    def size(self) -> int:
        """Size of the content, bytes."""
        return sum(map(len, self.pieces))

    @property
    def payload(self) -> bytes:
        """The content in one piece."""
        return b"".join(self.pieces)


class Channels:
    """The open channels by name; no number is used twice."""

    def __init__(self) -> None:
        self._by_topic: dict[str, Channel] = {}
        self._opened = 0

    def open(
        self, topic: str, schema_name: str, schema: str, *, encoding: str = "cdr", kind: Kind = Kind.EVERY
    ) -> Channel:
        """Return the channel of a topic, a new or the existing one."""
        if topic not in self._by_topic:
            self._opened += 1
            self._by_topic[topic] = Channel(self._opened, topic, encoding, schema_name, schema, kind)
        return self._by_topic[topic]

    def close(self, topic: str) -> Channel:
        """Remove the channel of a topic and return it."""
        return self._by_topic.pop(topic)

    def __iter__(self) -> Any:
        return iter(tuple(self._by_topic.values()))

    def __getitem__(self, topic: str) -> Channel:
        return self._by_topic[topic]

    def __contains__(self, topic: object) -> bool:
        return topic in self._by_topic
