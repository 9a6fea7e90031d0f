"""Compress data piece by piece into one frame that any LZ4 library reads.

A frame is a header, independent blocks, and an end (``lz4_Frame_format.md`` of the LZ4
project, version 1.6.4). Each block has the XXH32 of its bytes, which is checked before decompression:
this takes half a microsecond for an image, and the CRC of all its pixels would take thirty.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Final

import lz4.block  # type: ignore[import-untyped]
import lz4.frame  # type: ignore[import-untyped]
import xxhash

BLOCK_BYTES: Final = 1 << 22
"""The largest block of the format."""

_WORD = struct.Struct("<I")
_MAGIC = _WORD.pack(0x184D2204)
_DESCRIPTOR = bytes((0b01_1_1_0_0_0_0, 7 << 4))  # version 1, independent blocks with checksums, of 4 MB
FRAME_HEADER: Final = _MAGIC + _DESCRIPTOR + bytes((xxhash.xxh32_intdigest(_DESCRIPTOR) >> 8 & 0xFF,))
"""The header of every frame."""
_END = bytes(4)
_NOT_PACKED = 1 << 31


def frame(blocks: Iterable[bytes]) -> bytes:
    """Return a frame of blocks from :func:`pack`."""
    return b"".join((FRAME_HEADER, *blocks, _END))


def pack(data: bytes | memoryview) -> bytes:
    """Return the blocks of a frame with these bytes."""
    if len(data) <= BLOCK_BYTES:
        return _block(data)
    return b"".join(_block(data[i : i + BLOCK_BYTES]) for i in range(0, len(data), BLOCK_BYTES))


def _block(data: bytes | memoryview) -> bytes:
    packed = lz4.block.compress(data, store_size=False)
    size = len(packed)
    if size >= len(data):
        packed, size = bytes(data), len(data) | _NOT_PACKED
    return b"".join((_WORD.pack(size), packed, _WORD.pack(xxhash.xxh32_intdigest(packed))))


class Packed:
    """Many bytes of a message, hashed and compressed at once, while they are in the processor's cache.

    Args:
        data: contiguous bytes; not kept.

    Attributes:
        digest: their XXH3 of 128 bits.
        blocks: the blocks with them.
    """

    __slots__ = ("_size", "blocks", "digest")

    def __init__(self, data: memoryview) -> None:
        self._size = len(data)
        self.digest = xxhash.xxh3_128_digest(data)
        self.blocks = pack(data)

    def __len__(self) -> int:
        return self._size

    def __bytes__(self) -> bytes:
        """Decompress them."""
        return bytes(lz4.frame.decompress(frame([self.blocks])))
