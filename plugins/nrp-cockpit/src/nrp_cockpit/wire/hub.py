"""Between the thread of a run and the clients: what is heard, what was said last, who is there."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from nrp_cockpit.wire.channels import Channel, Channels, Kind, Sent

Service = Callable[..., Any]
"""Takes the fields of a request by their names and returns what fits into JSON; any thread may call it."""


@dataclass(frozen=True)
class Services:
    """What clients can ask for.

    Args:
        steering: by name, what changes the run; only for those who may steer.
        watching: by name, what changes nothing.
    """

    steering: Mapping[str, Service] = field(default_factory=dict)
    watching: Mapping[str, Service] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """All names, in a fixed order."""
        return [*self.watching, *self.steering]


class Listener(Protocol):
    """One client, as the hub sees it."""

    @property
    def dropped(self) -> int: ...

    def announce(self, channels: Iterable[Channel]) -> None: ...

    def hear(self, sent: Sent) -> None: ...


class Hub:
    """Takes messages from the thread of a run and hands them to all clients that hear them.

    Methods for the run never wait for a client. The rest belongs to the thread of the server.

    Attributes:
        channels: all that are offered.
        services: what clients can ask for.
        heard: the topics that at least one client hears; the same object until it changes.
        joined: increases whenever a client begins to hear a topic.
    """

    def __init__(self) -> None:
        self.channels = Channels()
        self.services = Services()
        self.heard: frozenset[str] = frozenset()
        self.joined = 0
        self.listeners: dict[Listener, None] = {}
        self._counts: Counter[str] = Counter()
        self._last: dict[str, Sent] = {}
        self._waiting: list[Sent] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._dropped_before = 0

    # -- for the run

    def offer(self, topic: str, schema_name: str, schema: str, kind: Kind = Kind.EVERY) -> Channel:
        """Offer a topic in the encoding of ROS 2; clients that are there are told."""
        return self._announced(self.channels.open(topic, schema_name, schema, kind=kind))

    def tell(self, topic: str, value: Any, t_ns: int = 0, kind: Kind = Kind.LATEST) -> None:
        """Send a value as JSON; who comes later gets the last one."""
        if topic not in self.channels:
            self._announced(self.channels.open(topic, topic[1:], "{}", encoding="json", kind=kind))
        self.send(Sent(self.channels[topic], t_ns, json.dumps(value).encode()))
        self.flush()

    def send(self, sent: Sent, *, keep: bool = True) -> None:
        """Send a message with the next :meth:`flush`.

        Args:
            sent: the message.
            keep: whether who comes later gets it, as long as it is the last.
        """
        if keep:
            self._last[sent.channel.topic] = sent
        if sent.channel.topic in self.heard:
            self._waiting.append(sent)

    def forget(self, topics: Iterable[str]) -> None:
        """Forget the last messages of these topics: they are not true any more."""
        for topic in topics:
            self._last.pop(topic, None)

    def flush(self) -> None:
        """Hand what was sent to the thread of the server."""
        if self._waiting and self._loop is not None:
            waiting, self._waiting = self._waiting, []
            self._loop.call_soon_threadsafe(self._spread, waiting)

    @property
    def viewers(self) -> int:
        """Number of clients."""
        return len(self.listeners)

    @property
    def dropped(self) -> int:
        """Number of messages that clients were too slow for."""
        return self._dropped_before + sum(one.dropped for one in tuple(self.listeners))

    # -- for the server

    def attach(self, loop: asyncio.AbstractEventLoop | None) -> None:
        """Set the loop of the server's thread; None: the server has ended."""
        self._loop = loop

    def enter(self, listener: Listener) -> None:
        """Add a client."""
        self.listeners[listener] = None

    def leave(self, listener: Listener, heard: Iterable[str]) -> None:
        """Remove a client that heard these topics."""
        self.listeners.pop(listener, None)
        self._dropped_before += listener.dropped
        for topic in heard:
            self.unhear(topic)

    def hear(self, topic: str) -> Sent | None:
        """Count one more client of a topic; return its last message."""
        self._counts[topic] += 1
        self.heard = frozenset(self._counts)
        self.joined += 1
        return self._last.get(topic)

    def unhear(self, topic: str) -> None:
        """Count one client of a topic less."""
        self._counts[topic] -= 1
        if not self._counts[topic]:
            del self._counts[topic]
        self.heard = frozenset(self._counts)

    def _spread(self, waiting: list[Sent]) -> None:
        for listener in self.listeners:
            for sent in waiting:
                listener.hear(sent)

    def _announced(self, channel: Channel) -> Channel:
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._announce, channel)
        return channel

    def _announce(self, channel: Channel) -> None:
        for listener in self.listeners:
            listener.announce([channel])
