"""The hub between the thread of a run and the clients: subscriptions, last messages and clients."""

from __future__ import annotations

import asyncio
import json
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import isfinite
from typing import Any, Protocol

from nrp_cockpit.wire.channels import Channel, Channels, Kind, Sent
from nrp_cockpit.wire.memory import MOST_MESSAGES, Memory
from nrp_cockpit.wire.playback import Playback

_MOST_BATCHES = 64
"""Number of batches that wait while nobody listens: waking the other thread takes longer than a batch."""

Service = Callable[..., Any]
"""Takes the fields of a request by name and returns a JSON value; any thread may call it."""


@dataclass(frozen=True)
class Services:
    """The services for clients.

    Args:
        steering: by name, services that change the run, only for clients that may control it.
        watching: by name, services that change nothing.
    """

    steering: Mapping[str, Service] = field(default_factory=dict)
    watching: Mapping[str, Service] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """All names, in a fixed order."""
        return [*self.watching, *self.steering]

    def __or__(self, more: Services) -> Services:
        """Return these services and more."""
        return Services({**self.steering, **more.steering}, {**self.watching, **more.watching})


class Listener(Protocol):
    """One client, as the hub sees it."""

    @property
    def dropped(self) -> int: ...

    @property
    def may_steer(self) -> bool: ...

    @property
    def is_embedded(self) -> bool: ...

    def tick(self, t_ns: int) -> None: ...

    def announce(self, channels: Iterable[Channel]) -> None: ...

    def withdraw(self, channels: Iterable[Channel]) -> None: ...

    def receive(self, sent: Sent) -> None: ...

    def recall(self, topics: Iterable[str], *, are_new: bool) -> None: ...

    def flush(self) -> None: ...


class Hub:
    """Takes messages from the thread of a run and passes them to all clients that subscribe to them.

    Methods for the run never wait for a client. All others, and the last messages, belong to the thread of
    the server, which gets everything in the order in which the run sent it.

    Attributes:
        channels: the channels offered.
        services: the services for clients, with those that are :attr:`constant`.
        constant: the services that stay when the others are replaced.
        memory: the past of topics that the run has it :meth:`remember`.
        subscribed: the topics with at least one subscriber; the same object until it changes.
        playback: the time and state of the session.
        joined: the number of subscriptions to each topic so far.
        beside: the hub of a second run on the same server, if any.
        wake: called when a client subscribes to a topic; the session sets it.
        hand_over: has the server serve another hub, to which all clients connect anew; the server sets it.
    """

    def __init__(self) -> None:
        self.channels = Channels()
        self._services = self.constant = Services()
        self.memory = Memory()
        self.subscribed: frozenset[str] = frozenset()
        self.joined: Counter[str] = Counter()
        self.listeners: dict[Listener, None] = {}
        self.playback = Playback()
        self.beside: Hub | None = None
        self.wake: Callable[[], None] = _nothing
        self.hand_over: Callable[[Hub], None] = lambda _: None
        self._counts: Counter[str] = Counter()
        self._last: dict[str, Sent] = {}
        self._waiting: list[tuple[Sent, bool]] = []
        self._tick_ns: int | None = None
        self._is_together = False
        self._handed: deque[tuple[Callable[[Any], None], Any]] = deque()  # calls for the server's thread
        self._loop: asyncio.AbstractEventLoop | None = None
        self._dropped_before = 0

    @property
    def services(self) -> Services:
        return self._services | self.constant

    @services.setter
    def services(self, services: Services) -> None:
        self._services = services

    # -- for the run

    def offer(self, topic: str, schema_name: str, schema: str, kind: Kind = Kind.EVERY) -> Channel:
        """Offer a topic in the encoding of ROS 2, and announce it to clients if it is new."""
        if topic not in self.channels:
            self._hand(self._announce, self.channels.open(topic, schema_name, schema, kind=kind))
        return self.channels[topic]

    def withdraw(self, topics: Iterable[str]) -> None:
        """Offer these topics no more, and end the subscriptions to them."""
        self.flush()
        self._hand(self._withdraw, [self.channels.close(topic) for topic in topics])

    def offer_json(self, topic: str, kind: Kind = Kind.LATEST) -> None:
        """Offer a topic for :meth:`send_json`."""
        if topic not in self.channels:
            channel = self.channels.open(topic, topic[1:], "{}", encoding="json", kind=kind)
            self._hand(self._announce, channel)

    def send_json(self, topic: str, value: Any, t_ns: int = 0) -> None:
        """Send a value as JSON; later subscribers get the last one."""
        self.send(Sent(self.channels[topic], t_ns, (to_json(value),)))
        self.flush()

    def send(self, sent: Sent, *, keep: bool = True) -> None:
        """Send a message with the next :meth:`flush`.

        Args:
            sent: the message.
            keep: whether later subscribers receive it, as long as it is the last.
        """
        self._waiting.append((sent, keep))

    def play_back(self, playback: Playback) -> None:
        """Send the time to all clients, and keep the state of the session."""
        before, self.playback = self.playback, playback
        if playback.t_ns != before.t_ns:
            self._tick_ns = playback.t_ns
            self.flush()

    def forget(self, topics: Iterable[str]) -> None:
        """Forget the last messages of these topics, which have become invalid."""
        self.flush()
        self._hand(self._forget, tuple(topics))

    def remember(self, topics: Iterable[str], from_ns: int, most: int = MOST_MESSAGES) -> None:
        """Keep the messages on these topics from a time on, and none from before.

        Args:
            topics: the topics.
            from_ns: the time.
            most: maximum number of messages of each.
        """
        self.flush()
        self._hand(self._remember, (tuple(topics), from_ns, most))

    def go_back(self, t_ns: int) -> None:
        """Delete all messages after a time, and send clients the earlier ones that they lost."""
        self.flush()
        self._hand(self._go_back, t_ns)

    def forget_past(self, topics: Iterable[str]) -> None:
        """Do not :meth:`remember` these topics any more."""
        self.flush()
        self._hand(self.memory.forget, tuple(topics))

    def flush(self) -> None:
        """Pass the waiting messages to the thread of the server, unless more come :meth:`together`."""
        if self._is_together or not (self._waiting or self._tick_ns is not None):
            return
        batch, self._waiting, self._tick_ns = (self._waiting, self._tick_ns), [], None
        self._handed.append((self._spread, batch))
        if self.listeners or len(self._handed) >= _MOST_BATCHES:
            self._wake_server()

    def past_of(self, topic: str) -> tuple[int, list[Sent]]:
        """Return the time from which a topic is remembered, ns, and its messages.

        Any thread but that of the server may call it.
        """
        found: Future[tuple[int, list[Sent]]] = Future()
        self._hand(lambda _: found.set_result(self.memory.of(topic)), None)
        return found.result()

    @contextmanager
    def together(self) -> Iterator[None]:
        """Pass all messages of a block at once: waking the other thread takes longer than a message."""
        self._is_together = True
        try:
            yield
        finally:
            self._is_together = False
            self.flush()

    @property
    def viewers(self) -> int:
        """Number of clients, without those inside another page."""
        return sum(not one.is_embedded for one in tuple(self.listeners))

    @property
    def controllers(self) -> int:
        """Number of these clients that may control the run."""
        return sum(one.may_steer and not one.is_embedded for one in tuple(self.listeners))

    @property
    def dropped(self) -> int:
        """Number of messages dropped for slow clients."""
        return self._dropped_before + sum(one.dropped for one in tuple(self.listeners))

    # -- for the server

    def attach(self, loop: asyncio.AbstractEventLoop | None) -> None:
        """Set the loop of the server's thread; None: the server has stopped."""
        self._loop = loop

    def open_second(self) -> Hub:
        """Return a new hub for a second run on the same server."""
        self.beside = Hub()
        self.beside.attach(self._loop)
        return self.beside

    def enter(self, listener: Listener) -> None:
        """Add a client."""
        self.listeners[listener] = None
        self._make_calls()  # it joins after all that was sent before

    def leave(self, listener: Listener, topics: Iterable[str]) -> None:
        """Remove a client and its subscriptions to these topics."""
        self.listeners.pop(listener, None)
        self._dropped_before += listener.dropped
        for topic in topics:
            self.unsubscribe(topic)

    def subscribe(self, topic: str) -> Sent | None:
        """Add a subscriber to a topic; return its last message."""
        self._counts[topic] += 1
        self.subscribed = frozenset(self._counts)
        self.joined[topic] += 1
        self.wake()
        return self._last.get(topic)

    def unsubscribe(self, topic: str) -> None:
        """Remove a subscriber from a topic."""
        self._counts[topic] -= 1
        if not self._counts[topic]:
            del self._counts[topic]
        self.subscribed = frozenset(self._counts)

    def _spread(self, batch: tuple[list[tuple[Sent, bool]], int | None]) -> None:
        waiting, tick_ns = batch
        if tick_ns is not None:
            for listener in self.listeners:
                listener.tick(tick_ns)
        for sent, keep in waiting:
            if keep:
                self._last[sent.channel.topic] = sent
            self.memory.add(sent)
            for listener in self.listeners:
                listener.receive(sent)
        for listener in self.listeners:
            listener.flush()

    def _forget(self, topics: tuple[str, ...]) -> None:
        for topic in topics:
            self._last.pop(topic, None)

    def _remember(self, begun: tuple[tuple[str, ...], int, int]) -> None:
        topics, from_ns, most = begun
        for topic in topics:
            self.memory.begin(topic, from_ns, most)
        for listener in self.listeners:
            listener.recall(topics, are_new=True)

    def _go_back(self, t_ns: int) -> None:
        self.memory.go_back(t_ns)
        for listener in self.listeners:
            listener.recall(self.memory.last_only, are_new=False)

    def _withdraw(self, channels: list[Channel]) -> None:
        topics = tuple(channel.topic for channel in channels)
        self._forget(topics)
        self.memory.forget(topics)
        for listener in self.listeners:
            listener.withdraw(channels)

    def _announce(self, channel: Channel) -> None:
        for listener in self.listeners:
            listener.announce([channel])

    def _hand(self, call: Callable[[Any], None], argument: Any) -> None:
        """Have the thread of the server make a call after all earlier ones."""
        self._handed.append((call, argument))
        self._wake_server()

    def _wake_server(self) -> None:
        """Have the thread of the server make the calls handed to it; without a server, make them here."""
        loop = self._loop
        if loop is None:
            self._make_calls()
            return
        try:
            loop.call_soon_threadsafe(self._make_calls)
        except RuntimeError:  # the server has stopped in the meantime
            self._make_calls()

    def _make_calls(self) -> None:
        while self._handed:
            call, argument = self._handed.popleft()
            call(argument)


def _nothing() -> None: ...


def to_json(value: Any) -> bytes:
    """Return a value as JSON; infinities and NaN become null."""
    try:
        return json.dumps(value, allow_nan=False).encode()
    except ValueError:
        return json.dumps(_finite(value)).encode()


def _finite(value: Any) -> Any:
    match value:
        case float():
            return value if isfinite(value) else None
        case dict():
            return {key: _finite(item) for key, item in value.items()}
        case list() | tuple():
            return [_finite(item) for item in value]
    return value
