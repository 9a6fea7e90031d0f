"""Packets of RTPS and their submessages, as bytes; standard DDSI-RTPS 2.3, section 9.4."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from nrp_world_ros.ros2.rtps.parameters import Parameters, listed, read_list

PREFIX = 12
"""Length of the part of a GUID that names its participant; the rest names the writer or reader."""

MOST = 60_000
"""Maximum length of the data of a packet; longer samples are sent in parts."""

_HEAD = struct.Struct("<4sBB2s12s")
_ACKNACK, _HEARTBEAT, _GAP, _INFO_DST, _DATA, _DATA_FRAG = 0x06, 0x07, 0x08, 0x0E, 0x15, 0x16
_NACK_FRAG = 0x12
_LITTLE, _INLINE, _FINAL, _HAS_DATA, _HAS_KEY = 0x01, 0x02, 0x02, 0x04, 0x08
_BITS = 256
"""Maximum length of a set of sequence numbers."""

Numbers: TypeAlias = frozenset[int]


@dataclass(frozen=True, slots=True)
class Part:
    """Some of the fragments of a sample.

    Args:
        first: number of the first, from 1.
        size: length of each fragment but the last.
        total: length of the sample.
    """

    first: int
    size: int
    total: int


@dataclass(frozen=True, slots=True)
class Data:
    """A sample, or some of its fragments.

    Args:
        writer: GUID of its writer.
        reader: the reader that it is for, without its participant; zeros: all.
        number: its sequence number.
        inline: parameters beside the data.
        payload: the data.
        vendor: the implementation of DDS it is from.
        part: which fragments these are; None: this is the whole sample.
    """

    writer: bytes
    reader: bytes
    number: int
    inline: Parameters
    payload: bytes
    vendor: bytes
    part: Part | None = None


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The numbers that a writer has."""

    writer: bytes
    reader: bytes
    first: int
    last: int
    final: bool


@dataclass(frozen=True, slots=True)
class Gap:
    """Numbers that a writer does not have for a reader: those up to ``until`` without it, and others."""

    writer: bytes
    reader: bytes
    first: int
    until: int
    others: Numbers


@dataclass(frozen=True, slots=True)
class Nack:
    """The numbers that a reader lacks, all above ``base``; unless ``final``, it asks for a heartbeat."""

    reader: bytes
    writer: bytes
    base: int
    lacks: Numbers = field(default_factory=frozenset)
    final: bool = True


Submessage: TypeAlias = Data | Heartbeat | Gap | Nack


def parsed(packet: bytes, me: bytes) -> Iterator[Submessage]:
    """Yield the submessages of a packet that are for a participant, ``me``, of the kinds that are needed.

    Raises:
        struct.error, IndexError, ValueError: it is not a packet of RTPS.
    """
    magic, _, _, vendor, sender = _HEAD.unpack_from(packet)
    if magic != b"RTPS" or sender == me:
        return
    at, is_mine = _HEAD.size, True
    while at + 4 <= len(packet):
        kind, flags = packet[at], packet[at + 1]
        order = "<" if flags & _LITTLE else ">"
        (length,) = struct.unpack_from(order + "H", packet, at + 2)
        end = at + 4 + length if length else len(packet)
        body, at = packet[at + 4 : end], end
        if kind == _INFO_DST:
            is_mine = body[:PREFIX] in (me, bytes(PREFIX))
        elif is_mine and kind in _READ:
            yield _READ[kind](order, flags, body, sender, vendor)


def _read_data(order: str, flags: int, body: bytes, sender: bytes, vendor: bytes) -> Data:
    offset, reader, writer, high, low = struct.unpack_from(order + "2xH4s4siI", body)
    inline, at = read_list(body, 4 + offset, order) if flags & _INLINE else ({}, 4 + offset)
    payload = body[at:] if flags & (_HAS_DATA | _HAS_KEY) else b""
    return Data(sender + writer, reader, (high << 32) + low, inline, payload, vendor)


def _read_part(order: str, flags: int, body: bytes, sender: bytes, vendor: bytes) -> Data:
    offset, reader, writer, high, low, first, _, size, total = struct.unpack_from(
        order + "2xH4s4siIIHHI", body
    )
    inline, at = read_list(body, 4 + offset, order) if flags & _INLINE else ({}, 4 + offset)
    part = Part(first, size, total)
    return Data(sender + writer, reader, (high << 32) + low, inline, body[at:], vendor, part)


def _read_heartbeat(order: str, flags: int, body: bytes, sender: bytes, _vendor: bytes) -> Heartbeat:
    reader, writer, high, low, last_high, last_low = struct.unpack_from(order + "4s4siIiI", body)
    last = (last_high << 32) + last_low
    return Heartbeat(sender + writer, reader, (high << 32) + low, last, bool(flags & _FINAL))


def _read_gap(order: str, _flags: int, body: bytes, sender: bytes, _vendor: bytes) -> Gap:
    reader, writer, high, low = struct.unpack_from(order + "4s4siI", body)
    until, others = _read_set(order, body, 16)
    return Gap(sender + writer, reader, (high << 32) + low, until, others)


def _read_acknack(order: str, flags: int, body: bytes, sender: bytes, _vendor: bytes) -> Nack:
    reader, writer = struct.unpack_from("4s4s", body)
    return Nack(sender + reader, writer, *_read_set(order, body, 8), final=bool(flags & _FINAL))


def _read_nack_frag(order: str, _flags: int, body: bytes, sender: bytes, _vendor: bytes) -> Nack:
    reader, writer, high, low = struct.unpack_from(order + "4s4siI", body)
    number = (high << 32) + low
    return Nack(sender + reader, writer, number, frozenset({number}))


_READ: dict[int, Callable[[str, int, bytes, bytes, bytes], Submessage]] = {
    _DATA: _read_data,
    _DATA_FRAG: _read_part,
    _HEARTBEAT: _read_heartbeat,
    _GAP: _read_gap,
    _ACKNACK: _read_acknack,
    _NACK_FRAG: _read_nack_frag,
}


def _read_set(order: str, body: bytes, at: int) -> tuple[int, Numbers]:
    high, low, n_bits = struct.unpack_from(order + "iII", body, at)
    base = (high << 32) + low
    words = struct.unpack_from(f"{order}{(min(n_bits, _BITS) + 31) // 32}I", body, at + 12)
    bits = range(min(n_bits, _BITS))
    return base, frozenset(base + i for i in bits if words[i // 32] >> (31 - i % 32) & 1)


# -- to be sent


def packet(me: bytes, to: bytes, *submessages: bytes) -> bytes:
    """Return a packet for a participant; zeros: all."""
    head = _HEAD.pack(b"RTPS", 2, 3, VENDOR, me)
    return b"".join((head, _submessage(_INFO_DST, 0, to), *submessages))


VENDOR = bytes(2)
"""No registered implementation of DDS."""


def _submessage(kind: int, flags: int, body: bytes) -> bytes:
    body += bytes(-len(body) % 4)
    return struct.pack("<BBH", kind, flags | _LITTLE, len(body)) + body


def data(
    writer: bytes, reader: bytes, number: int, payload: bytes, inline: Mapping[int, bytes]
) -> list[bytes]:
    """Return a sample as submessages, each for a packet of its own.

    Args:
        writer: without its participant.
        reader: without its participant; zeros: all.
        number: its sequence number.
        payload: the data; none: the sample only says that its thing is gone.
        inline: parameters beside the data.
    """
    beside = listed(inline.items()) if inline else b""
    flags = _INLINE if inline else 0
    number_there = (number >> 32, number & 0xFFFFFFFF)
    if len(payload) <= MOST:
        head = struct.pack("<HH4s4siI", 0, 16, reader, writer, *number_there)
        return [_submessage(_DATA, flags | (_HAS_DATA if payload else 0), head + beside + payload)]
    parts = []
    for i, start in enumerate(range(0, len(payload), MOST), 1):
        place = (i, 1, MOST, len(payload))
        head = struct.pack("<HH4s4siIIHHI", 0, 28, reader, writer, *number_there, *place)
        parts.append(_submessage(_DATA_FRAG, flags, head + beside + payload[start : start + MOST]))
    return parts


def heartbeat(writer: bytes, reader: bytes, first: int, last: int, count: int) -> bytes:
    """Return a request for acknowledgement of the numbers that a writer has."""
    numbers = (first >> 32, first & 0xFFFFFFFF, last >> 32, last & 0xFFFFFFFF)
    return _submessage(_HEARTBEAT, 0, struct.pack("<4s4siIiIi", reader, writer, *numbers, count))


def acknack(reader: bytes, writer: bytes, base: int, lacks: Iterable[int], count: int) -> bytes:
    """Return an acknowledgement of all numbers below ``base``, and of those above it that do not lack."""
    numbers = struct.pack("<iI", base >> 32, base & 0xFFFFFFFF) + _set_of(base, lacks)
    return _submessage(_ACKNACK, _FINAL, reader + writer + numbers + struct.pack("<i", count))


def nack_frag(reader: bytes, writer: bytes, number: int, lacks: Iterable[int], count: int) -> bytes:
    """Return a request for fragments of a sample."""
    base = min(lacks)
    which = struct.pack("<iII", number >> 32, number & 0xFFFFFFFF, base) + _set_of(base, lacks)
    return _submessage(_NACK_FRAG, 0, reader + writer + which + struct.pack("<i", count))


def gap(writer: bytes, reader: bytes, numbers: Iterable[int]) -> bytes:
    """Return the report that a writer does not have these numbers for a reader."""
    first, *others = sorted(numbers)
    start, base = (struct.pack("<iI", each >> 32, each & 0xFFFFFFFF) for each in (first, first + 1))
    return _submessage(_GAP, 0, reader + writer + start + base + _set_of(first + 1, others))


def _set_of(base: int, numbers: Iterable[int]) -> bytes:
    """Return a set of numbers without its base."""
    places = [number - base for number in numbers if 0 <= number - base < _BITS]
    n_bits = max(places, default=-1) + 1
    words: list[Any] = [0] * ((n_bits + 31) // 32)
    for i in places:
        words[i // 32] |= 1 << (31 - i % 32)
    return struct.pack(f"<I{len(words)}I", n_bits, *words)
