"""Other viewers play, pause, seek and change the speed by the playback control of the protocol."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_cockpit.wire import protocol
from nrp_cockpit.wire.playback import Playback
from nrp_cockpit.wire.protocol import PlaybackRequest, PlaybackStatus, ProtocolError
from visitors import Cockpit, Visitor, cockpit

PLAY, PAUSE = 0, 1


def request(command: int, speed: float, seek_ns: int | None, name: str) -> bytes:
    """Return what the client of the Foxglove SDK sends."""
    data = name.encode()
    head = struct.pack("<BBf?QI", 3, command, speed, seek_ns is not None, seek_ns or 0, len(data))
    return head + data


@given(st.booleans(), st.floats(0, 100, width=32), st.none() | st.integers(0, (1 << 64) - 1), st.text())
def test_a_request_is_read_as_it_was_written(
    play: bool, speed: float, seek_ns: int | None, name: str
) -> None:
    frame = request(PLAY if play else PAUSE, speed, seek_ns, name)
    assert protocol.read_binary(frame) == PlaybackRequest(play, speed, seek_ns, name)


@pytest.mark.parametrize("frame", [request(2, 1.0, None, "a"), request(0, 1.0, None, "abc")[:-1]])
def test_an_unknown_or_cut_request_is_refused(frame: bytes) -> None:
    with pytest.raises(ProtocolError):
        protocol.read_binary(frame)


def test_a_state_has_the_bytes_that_the_sdk_sends() -> None:
    """Recorded from a server of foxglove-sdk 0.30.3."""
    state = protocol.playback_state(PlaybackStatus.PAUSED, 123_456_789, 2.0, did_seek=True, request_id="abc")
    assert state.hex() == "050115cd5b0700000000000000400103000000616263"


def test_a_request_to_play_at_the_end_asks_for_nothing() -> None:
    over = Playback("finished", 10, 10, 1.0)
    assert over.calls_for(PlaybackRequest(True, 1.0, None, "")) == []


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit() as opened:
        yield opened


def test_a_viewer_seeks_plays_faster_and_pauses(opened: Cockpit) -> None:
    with opened.visit() as visitor:
        visitor.subscribe("/cockpit/status")
        ask(visitor, request(PAUSE, 1.0, 1_000_000_000, "there"), "there")
        assert visitor.status(state="paused")["t_s"] == 1.0
        state = ask(visitor, request(PLAY, 4.0, None, "go"), "go")
        assert state[0] == PlaybackStatus.PLAYING
        assert visitor.status(state="running")["pace"] == 4.0
        ask(visitor, request(PAUSE, 4.0, None, "stop"), "stop")
        assert visitor.status(state="paused")["t_s"] > 1.0
        assert visitor.ticks == sorted(visitor.ticks)


def ask(visitor: Visitor, frame: bytes, name: str) -> tuple[int, int]:
    """Send a request; return status and time of the answer."""
    visitor.connection.send(frame)
    return visitor.until(lambda: visitor.playbacks.get(name))  # type: ignore[no-any-return]
