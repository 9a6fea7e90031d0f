"""What a hub passes to its listeners, and in how many pieces."""

from __future__ import annotations

from collections.abc import Iterable

from nrp_cockpit.wire.channels import Channel, Sent
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.playback import Playback


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
