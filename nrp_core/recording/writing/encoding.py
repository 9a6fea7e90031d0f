"""Encode the messages of every step, several times as fast as the general codec.

In CDR the offset of each number after the header of four bytes is a multiple of its size
(OMG, DDS-XTYPES 1.3, 7.4.3). Parts that are the same in all messages of a topic are encoded once.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import Final

import lz4.block  # type: ignore[import-untyped]
import lz4.frame  # type: ignore[import-untyped]
import numpy as np
import xxhash

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import NS_PER_S
from nrp_core.messages.sensor_msgs import Image
from nrp_core.scene.rigid import ModelMotion

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


Parts = tuple[bytes | memoryview | Packed, ...]
"""The bytes of a message as several pieces, to avoid copies."""

PACKED_BYTES = 1 << 12
"""Minimum size from which the pixels of an image are compressed separately."""

_HEAD = b"\x00\x01\x00\x00"
_FLOAT64 = struct.Struct("<4sd")
_STAMP = struct.Struct("<4siI")
_LENGTH = struct.Struct("<I")
_FLOAT64S = struct.Struct("<4s4xIIxxxx")
_STEP_HASH = struct.Struct("<4siI5s3xq" + 4 * "I17s3x" + "I33s")
_EMPTY = b"\x01\x00\x00\x00\x00"  # an empty string and its end


def float64(value: float) -> Parts:
    """Return a ``std_msgs/Float64``."""
    return (_FLOAT64.pack(_HEAD, value),)


def float64s(values: FloatArray) -> Parts:
    """Return a ``std_msgs/Float64MultiArray`` of one or more values, without names of dimensions."""
    return (_FLOAT64S.pack(_HEAD, 0, len(values)) + values.tobytes(),)


class SpikesEncoder:
    """Encodes ``nrp_msgs/Spikes`` of one population."""

    def __init__(self, population: str) -> None:
        body = _pad(_EMPTY, 8, 4) + _text(population)
        self._fixed = _pad(body, 8, 4)

    def __call__(self, now_ns: int, ids: IntArray, times_ms: FloatArray) -> Parts:
        """Return the spikes of one step, ids within the population."""
        count = _LENGTH.pack(len(ids))
        head = stamp(now_ns) + self._fixed + count
        ids_end = len(head) - 4 + 4 * len(ids) + 4
        return (
            b"".join((head, ids.astype("<u4").tobytes(), count, bytes(-ids_end % 8), times_ms.tobytes())),
        )


class ModelStatesEncoder:
    """Encodes ``gazebo_msgs/ModelStates`` of fixed models."""

    def __init__(self, names: Sequence[str]) -> None:
        count = _LENGTH.pack(len(names))
        body = count
        for name in names:
            body = _pad(body, 0, 4) + _text(name)
        body = _pad(body, 0, 4) + count
        self._head = _HEAD + (_pad(body, 0, 8) if names else body)
        self._middle = count + (b"\0\0\0\0" if names else b"")
        self._poses, self._twists = struct.Struct(f"<{7 * len(names)}d"), struct.Struct(f"<{6 * len(names)}d")

    def __call__(self, motions: Sequence[ModelMotion]) -> Parts:
        """Return the states of the models, in the order of their names."""
        poses = [x for m in motions for x in (*m.pose.position, *m.pose.orientation)]
        twists = [x for m in motions for x in (*m.linear, *m.angular)]
        return (self._head + self._poses.pack(*poses) + self._middle + self._twists.pack(*twists),)


class TransformsEncoder:
    """Encodes ``tf2_msgs/TFMessage`` of fixed frames.

    Args:
        parent: the parent frame of all of them.
        children: their names.
    """

    def __init__(self, parent: str, children: Sequence[str]) -> None:
        body, stamps, poses = _LENGTH.pack(len(children)), [], []
        for child in children:
            body = _pad(body, 0, 4)
            stamps.append(len(body))
            body = _pad(body + bytes(8) + _text(parent), 0, 4) + _text(child)
            body = _pad(body, 0, 8)
            poses.append(len(body))
            body += bytes(56)
        self._body = np.frombuffer(_HEAD + body, np.uint8).copy()
        self._stamps = len(_HEAD) + np.add.outer(np.array(stamps, int), np.arange(8))
        self._poses = len(_HEAD) + np.add.outer(np.array(poses, int), np.arange(56))

    def __call__(self, now_ns: int, poses: FloatArray) -> Parts:
        """Return the poses, positions and orientations (x, y, z, w), shape ``(n, 7)``."""
        self._body[self._stamps] = np.frombuffer(stamp(now_ns), np.uint8)[len(_HEAD) :]
        self._body[self._poses] = poses.view(np.uint8)
        return (self._body.tobytes(),)


def image(message: Image, *, pack: bool = True) -> Parts:
    """Return a ``sensor_msgs/Image``; the pixels of a large one are compressed, others are not copied."""
    at = message.header.stamp
    data = message.data
    if not isinstance(data, np.ndarray):
        data = np.frombuffer(data, np.uint8)
    pixels = np.ascontiguousarray(data).reshape(-1).view(np.uint8)  # for depths, the bytes of each number
    body = _pad(_text(message.header.frame_id), 8, 4)
    body += struct.pack("<II", message.height, message.width) + _text(message.encoding)
    body = _pad(body + bytes([message.is_bigendian]), 8, 4)
    body += struct.pack("<II", message.step, len(pixels))
    head = _STAMP.pack(_HEAD, at.sec, at.nanosec) + body
    if not pack:
        return head, pixels.data
    return head, Packed(pixels.data) if len(pixels) >= PACKED_BYTES else pixels.tobytes()


def step_hash(now_ns: int, step: int, hashes: Sequence[str], chain: str) -> Parts:
    """Return a ``nrp_msgs/StepHash``; all hashes have their full length."""
    seconds, nanoseconds = divmod(now_ns, NS_PER_S)
    brain, world, inputs, outputs = (text.encode() for text in hashes)
    return (
        _STEP_HASH.pack(
            _HEAD, seconds, nanoseconds, _EMPTY, step, 17, brain, 17, world, 17, inputs, 17, outputs,
            33, chain.encode(),
        ),
    )  # fmt: skip


def snapshot(now_ns: int, step: int, data: bytes) -> Parts:
    """Return a ``nrp_msgs/Snapshot``; the data is not copied."""
    return _pad(stamp(now_ns) + _EMPTY, -4, 8) + struct.pack("<qI", step, len(data)), data


def join_parts(parts: Parts) -> bytes:
    """Return a message in one piece."""
    return b"".join(part if isinstance(part, memoryview) else bytes(part) for part in parts)


def stamp(now_ns: int) -> bytes:
    """Return the beginning of a message with a header: the CDR header, and the time."""
    seconds, nanoseconds = divmod(now_ns, NS_PER_S)
    return _STAMP.pack(_HEAD, seconds, nanoseconds)


def _text(text: str) -> bytes:
    data = text.encode() + b"\0"
    return _LENGTH.pack(len(data)) + data


def _pad(body: bytes, before: int, size: int) -> bytes:
    """Pad to a multiple of a size, given the number of bytes before."""
    return body + b"\0" * (-(before + len(body)) % size)
