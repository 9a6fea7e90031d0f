"""Lists of parameters, by which participants and their topics are described; DDSI-RTPS 2.3, 9.6.2.2."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import TypeAlias

Parameters: TypeAlias = Mapping[int, list[bytes]]
"""The values of each parameter."""

Address: TypeAlias = tuple[str, int]
"""Address and port of UDP."""

_LITTLE = b"\x00\x03\x00\x00"
_UDP = 1
_SHORTEST_S = 1.0
_PORTS = range(1, 1 << 16)
_MOST_ADDRESSES = 16
"""Maximum number of addresses of an end: each packet to it is sent to all."""


class P(IntEnum):
    """Parameters."""

    END = 0x0001
    LEASE = 0x0002
    TOPIC = 0x0005
    TYPE = 0x0007
    VERSION = 0x0015
    VENDOR = 0x0016
    RELIABILITY = 0x001A
    DURABILITY = 0x001D
    USER_DATA = 0x002C
    UNICAST = 0x002F
    DEFAULT_UNICAST = 0x0031
    METATRAFFIC_UNICAST = 0x0032
    PARTICIPANT = 0x0050
    BUILTIN_ENDPOINTS = 0x0058
    ENDPOINT = 0x005A
    KEY = 0x0070
    STATUS = 0x0071
    RELATED_SAMPLE = 0x0083
    FAST_RELATED_SAMPLE = 0x800F


GONE = b"\x00\x00\x00\x03"
"""The status of what is deleted."""


@dataclass(frozen=True, slots=True)
class Participant:
    """Another participant.

    Args:
        prefix: the first part of its GUIDs.
        meta: where it takes descriptions.
        addresses: where it takes samples.
        lease_s: it has left if it is silent for so long, s.
    """

    prefix: bytes
    meta: tuple[Address, ...]
    addresses: tuple[Address, ...]
    lease_s: float


@dataclass(frozen=True, slots=True)
class End:
    """A writer or reader of a topic.

    Args:
        guid: its GUID.
        topic: the name in DDS.
        kind: name of the type in DDS.
        addresses: where it takes samples; none: where its participant does.
    """

    guid: bytes
    topic: str
    kind: str
    addresses: tuple[Address, ...] = ()


def listed(parameters: Iterable[tuple[int, bytes]]) -> bytes:
    """Return a list as bytes."""
    padded = [(pid, value + bytes(-len(value) % 4)) for pid, value in parameters]
    return b"".join(struct.pack("<HH", pid, len(value)) + value for pid, value in (*padded, (P.END, b"")))


def read_list(data: bytes, at: int, order: str) -> tuple[dict[int, list[bytes]], int]:
    """Return the parameters from a position on, and the position after them."""
    found: dict[int, list[bytes]] = {}
    while True:
        pid, length = struct.unpack_from(order + "HH", data, at)
        at += 4
        if pid == P.END:
            return found, at
        found.setdefault(pid, []).append(data[at : at + length])
        at += length


def description(parameters: Iterable[tuple[int, bytes]]) -> bytes:
    """Return a list as the data of a sample."""
    return _LITTLE + listed(parameters)


def text(value: str) -> bytes:
    """Return a string as the value of a parameter."""
    data = value.encode() + b"\0"
    return struct.pack("<I", len(data)) + data


def octets(value: bytes) -> bytes:
    """Return bytes as the value of a parameter."""
    return struct.pack("<I", len(value)) + value


def locator(address: Address) -> bytes:
    """Return an address as the value of a parameter."""
    return struct.pack("<iI12x4s", _UDP, address[1], socket.inet_aton(address[0]))


class Description:
    """Reads the data of a sample that describes a participant, writer or reader."""

    def __init__(self, payload: bytes) -> None:
        self._order = "<" if payload[1] & 1 else ">"
        self._values, _ = read_list(payload, 4, self._order)

    def participant(self) -> Participant:
        """Return the participant.

        Raises:
            KeyError: it is none.
        """
        seconds, _ = struct.unpack_from(self._order + "iI", self._values.get(P.LEASE, [b"\x7f" * 8])[0])
        return Participant(
            self._values[P.PARTICIPANT][0][:12],
            self._addresses(P.METATRAFFIC_UNICAST),
            self._addresses(P.DEFAULT_UNICAST),
            max(_SHORTEST_S, float(seconds)),
        )

    def end(self) -> End:
        """Return the writer or reader.

        Raises:
            KeyError: it is none.
        """
        return End(self.guid, self._text(P.TOPIC), self._text(P.TYPE), self._addresses(P.UNICAST))

    @property
    def guid(self) -> bytes:
        """The GUID of the writer or reader."""
        return self._values[P.ENDPOINT][0]

    def _text(self, pid: int) -> str:
        value = self._values[pid][0]
        (length,) = struct.unpack_from(self._order + "I", value)
        return value[4 : 3 + length].decode()

    def _addresses(self, pid: int) -> tuple[Address, ...]:
        found = []
        for value in self._values.get(pid, []):
            kind, port, address = struct.unpack_from(self._order + "iI12x4s", value)
            if kind == _UDP and port in _PORTS:
                found.append((socket.inet_ntoa(address), port))
        return tuple(found[:_MOST_ADDRESSES])
