"""A participant: it finds others, and connects its ends of topics with theirs; DDSI-RTPS 2.3, section 8.5."""

from __future__ import annotations

import os
import struct
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress

from nrp_core.world import Closing

from nrp_world_ros.ros2.rtps import packets
from nrp_world_ros.ros2.rtps.ends import ANY, Reader, Writer
from nrp_world_ros.ros2.rtps.packets import PREFIX, Data, Gap, Heartbeat, Nack
from nrp_world_ros.ros2.rtps.parameters import (
    GONE,
    Address,
    Description,
    End,
    P,
    Participant,
    description,
    locator,
    octets,
    text,
)
from nrp_world_ros.ros2.rtps.sockets import Sockets

_PARTICIPANT, _SPDP_WRITER, _SPDP_READER = b"\0\0\1\xc1", b"\0\1\0\xc2", b"\0\1\0\xc7"
_WRITERS, _READERS = (b"\0\0\3\xc2", b"\0\0\3\xc7"), (b"\0\0\4\xc2", b"\0\0\4\xc7")
"""The writer and the reader of descriptions of writers, and of readers."""

_ENDPOINTS = 0x3F
_VOLATILE, _KEPT = 0, 1
_LEASE_S, _PERIOD_S, _REMIND_S = 10, 1.0, 0.1
_MOST_OTHERS, _MOST_ENDS = 500, 20_000
"""Maximum numbers of known participants, and of their writers or readers."""


class RtpsParticipant(Closing):
    """Has writers and readers of topics in a domain, all reliable and without history.

    Args:
        sockets: its connection to the network.
    """

    def __init__(self, sockets: Sockets) -> None:
        self._sockets = sockets
        self.prefix = packets.VENDOR + os.urandom(PREFIX - len(packets.VENDOR))
        self._others: dict[bytes, tuple[Participant, float]] = {}
        self._lock = threading.RLock()
        self._ends: dict[bytes, tuple[End, Writer | Reader]] = {}
        self._told = {kind: Writer(kind[0], self._send) for kind in (_WRITERS, _READERS)}
        self._hear = {
            kind: Reader(kind[1], self._send, take)
            for kind, take in ((_WRITERS, self._found_writer), (_READERS, self._found_reader))
        }
        self._remote: dict[tuple[bytes, bytes], dict[bytes, End]] = {_WRITERS: {}, _READERS: {}}
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="ros2 services", daemon=True)
        self._thread.start()

    # -- topics

    def writer(self, topic: str, kind: str) -> Writer:
        """Return a new writer of a topic."""
        with self._lock:
            end = self._end(topic, kind, 0x03)
            writer = Writer(end.guid[PREFIX:], self._send)
            self._ends[end.guid] = (end, writer)
            for other in self._on(end, _READERS):
                writer.match(other.guid, self._addresses(other), late=False)
            self._told[_WRITERS].write(self._described(end))
            return writer

    def reader(self, topic: str, kind: str, take: Callable[[Data, bytes], None]) -> Reader:
        """Return a new reader of a topic; ``take`` is called in the thread of this participant."""
        with self._lock:
            end = self._end(topic, kind, 0x04)
            reader = Reader(end.guid[PREFIX:], self._send, take)
            self._ends[end.guid] = (end, reader)
            for other in self._on(end, _WRITERS):
                reader.match(other.guid, self._addresses(other))
            self._told[_READERS].write(self._described(end))
            return reader

    def write(self, writer: Writer, payload: bytes, inline: dict[int, bytes], to: bytes) -> None:
        """Send a sample to a participant; any thread may."""
        with self._lock:
            writer.write(payload, inline, to)

    def _end(self, topic: str, kind: str, code: int) -> End:
        number = len(self._ends) + 1
        return End(self.prefix + struct.pack(">I", (number << 8) + code), topic, kind)

    def _described(self, end: End) -> bytes:
        reliable = struct.pack("<IiI", 2, 0, 0xFFFFFFFF // 10)
        return description([
            (P.VERSION, b"\2\3"), (P.VENDOR, packets.VENDOR), (P.PARTICIPANT, self.prefix + _PARTICIPANT),
            (P.ENDPOINT, end.guid), (P.KEY, end.guid), (P.TOPIC, text(end.topic)), (P.TYPE, text(end.kind)),
            (P.RELIABILITY, reliable), (P.DURABILITY, struct.pack("<I", _VOLATILE)),
        ])  # fmt: skip

    def _on(self, mine: End, kind: tuple[bytes, bytes]) -> list[End]:
        """Return the known writers or readers on a topic."""
        return [
            end for end in self._remote[kind].values() if (end.topic, end.kind) == (mine.topic, mine.kind)
        ]

    # -- the thread

    def _run(self) -> None:
        announce_s = remind_s = 0.0
        while not self._closed:
            for packet in self._sockets.received(_REMIND_S):
                self.handle(packet)
            now_s = time.monotonic()
            with self._lock:
                if now_s > announce_s:
                    announce_s = now_s + _PERIOD_S
                    self._announce(self._sockets.everywhere())
                    self._forget(now_s)
                if now_s > remind_s:
                    remind_s = now_s + _REMIND_S
                    for writer in self._writers():
                        writer.remind()

    def _writers(self) -> Iterator[Writer]:
        yield from self._told.values()
        yield from (end for _, end in self._ends.values() if isinstance(end, Writer))

    def _readers(self) -> Iterator[Reader]:
        yield from self._hear.values()
        yield from (end for _, end in self._ends.values() if isinstance(end, Reader))

    def handle(self, packet: bytes) -> None:
        """Handle a received packet; what is not of RTPS is ignored."""
        with self._lock, suppress(struct.error, IndexError, ValueError, KeyError):
            self._handle(packet)

    def _handle(self, packet: bytes) -> None:
        for each in packets.parsed(packet, self.prefix):
            if isinstance(each, Nack):
                for writer in self._writers():
                    if writer.entity == each.writer:
                        writer.acknowledged(each)
            elif isinstance(each, Data) and each.writer.endswith(_SPDP_WRITER):
                self._met(each)
            else:
                self._read(each)

    def _read(self, each: Data | Heartbeat | Gap) -> None:
        for reader in self._readers():
            if each.reader in (reader.entity, ANY):
                if isinstance(each, Data):
                    reader.took(each)
                elif isinstance(each, Heartbeat):
                    reader.asked(each)
                else:
                    reader.skipped(each)

    def _send(self, to: bytes, addresses: Iterable[Address], submessage: bytes) -> None:
        self._sockets.send(packets.packet(self.prefix, to, submessage), addresses)

    # -- discovery

    def _announce(self, addresses: Iterable[Address], *, gone: bool = False) -> None:
        """Tell where this participant is, or that it leaves."""
        guid = self.prefix + _PARTICIPANT
        here = [locator(address) for address in self._sockets.addresses]
        payload = description([
            (P.VERSION, b"\2\3"), (P.VENDOR, packets.VENDOR), (P.PARTICIPANT, guid),
            *((P.METATRAFFIC_UNICAST, each) for each in here), *((P.DEFAULT_UNICAST, each) for each in here),
            (P.LEASE, struct.pack("<iI", _LEASE_S, 0)), (P.BUILTIN_ENDPOINTS, struct.pack("<I", _ENDPOINTS)),
            (P.USER_DATA, octets(b"enclave=/;")),
        ])  # fmt: skip
        inline: dict[int, bytes] = {P.STATUS: GONE, P.KEY: guid} if gone else {}
        (what,) = packets.data(_SPDP_WRITER, _SPDP_READER, 1, payload, inline)
        self._send(bytes(PREFIX), addresses, what)

    def _met(self, data: Data) -> None:
        prefix = data.writer[:PREFIX]
        if _is_gone(data):
            self._lose(prefix)
            return
        other = Description(data.payload).participant()
        is_new = prefix not in self._others
        if is_new and len(self._others) >= _MOST_OTHERS:
            return
        self._others[prefix] = (other, time.monotonic() + other.lease_s)
        if not is_new:
            return
        self._announce(other.meta)
        for (writer, reader), ours in self._told.items():
            ours.match(prefix + reader, other.meta, late=True)
            self._hear[writer, reader].match(prefix + writer, other.meta)

    def _forget(self, now_s: float) -> None:
        for prefix in [prefix for prefix, (_, until_s) in self._others.items() if until_s < now_s]:
            self._lose(prefix)

    def _lose(self, guid: bytes) -> None:
        """Forget a participant, or a writer or reader."""
        self._others.pop(guid, None)
        for known in self._remote.values():
            for each in [each for each in known if each.startswith(guid)]:
                del known[each]
        for writer in self._writers():
            writer.leave(guid)
        for reader in self._readers():
            reader.leave(guid)

    def _found_writer(self, data: Data, payload: bytes) -> None:
        for end, ours in self._found(_WRITERS, data, payload):
            if isinstance(ours, Reader):
                ours.match(end.guid, self._addresses(end))

    def _found_reader(self, data: Data, payload: bytes) -> None:
        for end, ours in self._found(_READERS, data, payload):
            if isinstance(ours, Writer):
                ours.match(end.guid, self._addresses(end), late=False)

    def _found(
        self, kind: tuple[bytes, bytes], data: Data, payload: bytes
    ) -> Iterator[tuple[End, Writer | Reader]]:
        """Yield a described end with those of ours on its topic."""
        if _is_gone(data):
            guid = (data.inline.get(P.KEY) or [Description(payload).guid])[0]
            if _is_of(guid, data):
                self._lose(guid)
            return
        end = Description(payload).end()
        if not _is_of(end.guid, data) or len(self._remote[kind]) >= _MOST_ENDS:
            return
        self._remote[kind][end.guid] = end
        for mine, ours in self._ends.values():
            if (mine.topic, mine.kind) == (end.topic, end.kind):
                yield end, ours

    def _addresses(self, end: End) -> tuple[Address, ...]:
        other, _ = self._others[end.guid[:PREFIX]]
        return end.addresses or other.addresses or other.meta

    def close(self) -> None:
        """Leave the domain."""
        if self._closed:
            return
        self._closed = True
        self._thread.join()
        with self._lock:
            for other, _ in self._others.values():
                self._announce(other.meta, gone=True)
        self._sockets.close()


def _is_of(guid: bytes, data: Data) -> bool:
    """Return whether a GUID is of a writer or reader of the participant that sent a sample."""
    return len(guid) == PREFIX + len(ANY) and guid.startswith(data.writer[:PREFIX])


def _is_gone(data: Data) -> bool:
    """Return whether a sample says that what it describes is deleted."""
    return any(any(status) for status in data.inline.get(P.STATUS, []))
