"""What arrives from the network may be anything: it ends nothing, takes no time, and fills no memory."""

from __future__ import annotations

import struct
import tracemalloc
from collections.abc import Iterable, Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_world_ros.ros2.rtps import packets
from nrp_world_ros.ros2.rtps.parameters import Address, P, description, text
from nrp_world_ros.ros2.rtps.participant import RtpsParticipant

ME = bytes(range(1, 13))
CALLER = b"\0\0\1\3"
SPDP, SEDP = b"\0\1\0\xc2", b"\0\0\3\xc2"
HERE: Address = ("127.0.0.1", 7410)


class Wire:
    """Sockets that deliver the given packets in the calling thread, and send as the system does."""

    addresses = [HERE]  # noqa: RUF012

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def everywhere(self) -> Iterable[Address]:
        return ()

    def send(self, packet: bytes, addresses: Iterable[Address]) -> None:
        for _, port in addresses:
            if not 0 <= port < 1 << 16:
                raise OverflowError("sendto(): port must be 0-65535.")  # socket.sendto does
            self.sent.append(packet)

    def received(self, timeout_s: float) -> Iterator[bytes]:
        return iter(())

    def close(self) -> None:
        pass


class Target:
    """A participant with a service's request reader, which has met one caller."""

    def __init__(self) -> None:
        self.taken: list[bytes] = []
        self.participant = RtpsParticipant(Wire())  # type: ignore[arg-type]
        self.participant.reader("rqask", "Ask_", lambda _data, payload: self.taken.append(payload))
        self.hears(packets.data(SPDP, bytes(4), 1, met(HERE[1]), {})[0])
        self.hears(packets.data(SEDP, bytes(4), 1, asks(ME + CALLER), {})[0])

    def hears(self, submessage: bytes) -> None:
        self.participant.handle(packets.packet(ME, bytes(12), submessage))


def met(port: int) -> bytes:
    place = struct.pack("<iI12x4B", 1, port, 127, 0, 0, 1)
    return description(
        [(P.PARTICIPANT, ME + b"\0\0\1\xc1"), (P.METATRAFFIC_UNICAST, place), (P.DEFAULT_UNICAST, place)]
    )


def asks(guid: bytes) -> bytes:
    return description([(P.ENDPOINT, guid), (P.TOPIC, text("rqask")), (P.TYPE, text("Ask_"))])


@pytest.fixture
def target() -> Iterator[Target]:
    found = Target()
    yield found
    found.participant.close()


def fragment(number: int, first: int, size: int, total: int, payload: bytes) -> bytes:
    head = struct.pack(
        "<HH4s4siIIHHI", 0, 28, bytes(4), CALLER, number >> 32, number & 0xFFFFFFFF, first, 1, size, total
    )
    return packets._submessage(packets._DATA_FRAG, 0, head + payload)


LAST = (1 << 62) - 1
ODD = {
    "fragments without a length": fragment(1, 1, 0, 100, b"x"),
    "fragment 0": fragment(1, 0, 10, 100, b"x" * 10),
    "a fragment behind the end": fragment(1, 50, 10, 100, b"x" * 10),
    "4 GB in fragments": fragment(1, 1, 60_000, 0xFFFFFFFF, b"x"),
    "16 million fragments": fragment(1, 1, 1, 1 << 24, b"x"),
    "a heartbeat of the distant future": packets.heartbeat(CALLER, bytes(4), LAST, LAST, 1),
    "a gap without an end": packets._submessage(
        packets._GAP, 0, bytes(4) + CALLER + struct.pack("<iIiII", 0, 1, LAST >> 32, 0, 0)
    ),
    "the end of nobody": packets.data(SEDP, bytes(4), 2, b"", {P.STATUS: b"\0\0\0\3", P.KEY: b""})[0],
}


@pytest.mark.parametrize("submessage", ODD.values(), ids=list(ODD))
def test_no_packet_costs_memory_or_time(target: Target, submessage: bytes) -> None:
    tracemalloc.start()
    try:
        target.hears(submessage)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1_000_000
    assert target.participant._thread.is_alive()


def test_calls_arrive_in_any_order_once_and_in_fragments(target: Target) -> None:
    for number in (2, 1, 2):
        target.hears(packets.data(CALLER, bytes(4), number, b"%d..." % number, {})[0])
    whole = bytes(range(250)) * 1000
    parts = packets.data(CALLER, bytes(4), 3, whole, {})
    for part in (*reversed(parts), *parts):
        target.hears(part)
    assert target.taken == [b"2...", b"1...", whole]


def test_samples_that_never_end_do_not_pile_up(target: Target) -> None:
    tracemalloc.start()
    try:
        for number in range(1, 300):
            target.hears(fragment(number, 1, 60_000, 1_000_000, b"x" * 60_000))
            target.hears(packets.data(CALLER, bytes(4), number * 10**6, b"far", {})[0])
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert held < 8_000_000


def test_those_who_announce_themselves_without_end_do_not_pile_up(target: Target) -> None:
    for i in range(2000):
        me = struct.pack(">III", 1, 2, i)
        what = packets.data(SPDP, bytes(4), 1, met(HERE[1]), {})[0]
        target.participant.handle(packets.packet(me, bytes(12), what))
    assert len(target.participant._others) <= 500


def test_a_port_that_is_none_is_not_sent_to(target: Target) -> None:
    other = struct.pack(">III", 1, 2, 3)
    what = packets.data(SPDP, bytes(4), 1, met(1 << 20), {})[0]
    target.participant.handle(packets.packet(other, bytes(12), what))
    assert target.participant._others[other][0].meta == ()


def test_one_participant_cannot_speak_for_another(target: Target) -> None:
    gone = {P.STATUS: b"\0\0\0\3", P.KEY: ME + CALLER}
    other = struct.pack(">III", 1, 2, 3)
    announced, ends = (
        packets.data(SPDP, bytes(4), 1, met(HERE[1]), {}),
        packets.data(SEDP, bytes(4), 1, b"", gone),
    )
    for what in (*announced, *ends):
        target.participant.handle(packets.packet(other, bytes(12), what))
    target.hears(packets.data(CALLER, bytes(4), 1, b"still heard.", {})[0])
    assert target.taken == [b"still heard."]
    target.hears(packets.data(SEDP, bytes(4), 2, b"", gone)[0])
    target.hears(packets.data(CALLER, bytes(4), 2, b"it has left.", {})[0])
    assert target.taken == [b"still heard."]


SOUND = [
    *ODD.values(), fragment(1, 1, 4, 8, b"abcd"),
    packets.data(CALLER, bytes(4), 5, b"a" * 20, {P.KEY: ME})[0],
    packets.acknack(b"\0\0\1\4", b"\0\0\3\xc2", 1, [2, 3], 1), packets.gap(CALLER, bytes(4), [1, 3]),
    packets.data(SEDP, bytes(4), 2, asks(ME + CALLER), {})[0],
]  # fmt: skip


@settings(max_examples=300)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(SOUND), st.lists(st.tuples(st.integers(0, 120), st.integers(0, 255)), max_size=6)
        ),
        max_size=6,
    )
)
def test_sound_packets_with_random_bytes_in_them_are_taken_or_ignored(changed: list[Any]) -> None:
    target = Target()
    try:
        for submessage, bytes_ in changed:
            spoilt = bytearray(submessage)
            for at, byte in bytes_:
                spoilt[at % len(spoilt)] = byte
            target.hears(bytes(spoilt))
    finally:
        target.participant.close()
