"""What a hub passes to its listeners, and in how many pieces."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable, Iterator
from typing import cast

import pytest
from nrp_cockpit.wire.channels import Channel, Kind, Sent
from nrp_cockpit.wire.client import Client
from nrp_cockpit.wire.guard import Guard
from nrp_cockpit.wire.hub import Hub, Services
from nrp_cockpit.wire.playback import Playback
from nrp_cockpit.wire.server import Server
from visitors import Visitor, visit


class Written:
    """A listener that notes the messages of each write."""

    dropped = 0
    may_steer = is_embedded = False

    def __init__(self) -> None:
        self.writes: list[list[bytes | int]] = []
        self._waiting: list[bytes | int] = []

    def tick(self, t_ns: int) -> None:
        self._waiting.append(t_ns)

    def announce(self, channels: Iterable[Channel]) -> None: ...

    def withdraw(self, channels: Iterable[Channel]) -> None: ...

    def recall(self, topics: Iterable[str], *, are_new: bool) -> None: ...

    def receive(self, sent: Sent) -> None:
        self._waiting.append(sent.payload)

    def flush(self) -> None:
        self.writes.append(self._waiting)
        self._waiting = []


def test_messages_that_are_sent_together_are_written_together_and_in_order() -> None:
    hub, listener = Hub(), Written()
    hub.offer_json("/a")
    hub.enter(listener)
    with hub.together():
        hub.play_back(Playback(t_ns=7))
        hub.send_json("/a", 1)
        hub.send_json("/a", 2)
        assert listener.writes == []
    hub.send_json("/a", 3)
    hub.flush()
    assert listener.writes == [[7, b"1", b"2"], [b"3"]]


def test_messages_are_passed_although_their_block_fails() -> None:
    hub, listener = Hub(), Written()
    hub.offer_json("/a")
    hub.enter(listener)
    try:
        with hub.together():
            hub.send_json("/a", 1)
            raise ZeroDivisionError
    except ZeroDivisionError:
        pass
    assert listener.writes == [[b"1"]]


class Woken:
    """A loop of a server that counts how often it is woken, and then makes the call."""

    times = 0

    def call_soon_threadsafe(self, call: Callable[[], None]) -> None:
        self.times += 1
        call()


def test_a_server_without_clients_is_rarely_woken_and_who_enters_finds_all_that_was_sent() -> None:
    hub, loop, listener = Hub(), Woken(), Written()
    hub.attach(cast(asyncio.AbstractEventLoop, loop))
    hub.offer_json("/a")
    hub.remember(["/a"], 0)
    before = loop.times
    for number in range(1000):
        hub.send_json("/a", number, number)
    assert 1 < loop.times - before < 50
    hub.enter(listener)
    assert [int(sent.payload) for sent in hub.memory.of("/a")[1]] == list(range(1000))
    hub.send_json("/a", 1000, 1000)
    assert listener.writes[-1] == [b"1000"]


@pytest.fixture
def served() -> Iterator[tuple[Hub, Visitor]]:
    """A hub, and a client that subscribes to what is large and to what is small."""
    hub, guard = Hub(), Guard()
    hub.services = Services(watching={"/cockpit/nothing": lambda: None})
    hub.offer_json("/large", Kind.EVERY)
    hub.offer_json("/small")
    server = Server(hub, guard=guard)
    try:
        with visit(f"http://127.0.0.1:{server.port}/?token={guard.token}") as visitor:
            visitor.subscribe("/large", "/small")
            visitor.until(lambda: len(hub.subscribed) == 2)
            yield hub, visitor
    finally:
        server.close()


def test_the_last_message_reaches_a_client_that_did_not_read_when_it_was_sent(
    served: tuple[Hub, Visitor],
) -> None:
    hub, visitor = served
    (client,) = hub.listeners
    assert isinstance(client, Client)
    while not client._connection.paused:
        hub.send_json("/large", "x" * 200_000)
        time.sleep(0.01)
    hub.send_json("/small", "the end")  # and nothing comes after it
    visitor.until(lambda: visitor.heard["/small"])
