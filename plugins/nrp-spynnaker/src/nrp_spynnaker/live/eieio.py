"""Spikes as packets of EIEIO, the protocol by which a SpiNNaker machine and other programs exchange them.

A packet has a count, a byte of flags, a prefix of keys and a common payload where the flags say so, then that
many keys, each with its payload or without one. All numbers are little-endian.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Final

KEY_16_BIT, KEY_PAYLOAD_16_BIT, KEY_32_BIT, KEY_PAYLOAD_32_BIT = range(4)
"""The types of packets."""
_HAS_PREFIX, _UPPER, _HAS_BASE, _IS_TIME = 1 << 7, 1 << 6, 1 << 5, 1 << 4
_TYPE_SHIFT: Final = 2
_LARGEST: Final = 256
"""Bytes in a packet that a machine takes."""


def packets(keys: Sequence[int], time: int, kind: int = KEY_32_BIT) -> Iterator[bytes]:
    """Yield the packets with the spikes of a time step.

    Args:
        keys: a key for each spike, of 32 bits.
        time: the number of the step.
        kind: ``KEY_32_BIT``, with one time for all keys, or ``KEY_PAYLOAD_32_BIT``, with a time for each.
    """
    flags = _IS_TIME | kind << _TYPE_SHIFT
    if kind == KEY_32_BIT:
        head, each = struct.Struct("<BBI"), 4
        flags |= _HAS_BASE
    else:
        head, each = struct.Struct("<BB"), 8
    most = (_LARGEST - head.size) // each
    for first in range(0, len(keys), most):
        some = keys[first : first + most]
        if kind == KEY_32_BIT:
            yield head.pack(len(some), flags, time) + struct.pack(f"<{len(some)}I", *some)
        else:
            pairs = [number for key in some for number in (key, time)]
            yield head.pack(len(some), flags) + struct.pack(f"<{len(pairs)}I", *pairs)


def keys_of(packet: bytes, upper: int = 0) -> list[int]:
    """Return the keys in a packet.

    Args:
        packet: its bytes.
        upper: the upper 16 bits of keys of 16 bits without a prefix.

    Raises:
        ValueError: it is not a packet of spikes, or is shorter than it says.
    """
    if len(packet) < 2:
        raise ValueError(f"it has {len(packet)} bytes; there must be a count and flags")
    count, flags = packet[0], packet[1]
    if flags & _UPPER and not flags & _HAS_PREFIX:
        raise ValueError("it is a command, not spikes")
    kind = flags >> _TYPE_SHIFT & 3
    wide, has_payloads = (
        kind in (KEY_32_BIT, KEY_PAYLOAD_32_BIT),
        kind in (KEY_PAYLOAD_16_BIT, KEY_PAYLOAD_32_BIT),
    )
    size, at, prefix = (4 if wide else 2), 2, 0 if wide else upper << 16
    if flags & _HAS_PREFIX:
        if len(packet) < at + 2:
            raise ValueError("it ends before its prefix")
        prefix = int.from_bytes(packet[at : at + 2], "little") << (16 if flags & _UPPER else 0)
        at += 2
    at += size if flags & _HAS_BASE else 0
    stride = size * (2 if has_payloads else 1)
    if len(packet) < at + count * stride:
        raise ValueError(f"it says that it has {count} keys, and has {max(0, len(packet) - at) // stride}")
    starts = range(at, at + count * stride, stride)
    return [int.from_bytes(packet[start : start + size], "little") | prefix for start in starts]
