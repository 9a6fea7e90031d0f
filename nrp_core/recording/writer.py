"""Write messages into an MCAP file that ROS 2 tools open and that survives being cut.

The records are those of the ``mcap`` library. Its writer is not used: it keeps an object for every chunk
until the end, and we close one every few steps; and its way to add a message costs five times as much.
"""

from __future__ import annotations

import shutil
import struct
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import SpooledTemporaryFile
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, Schema, Statistics
from mcap.writer import MCAP0_MAGIC

from nrp_core.world.messages.cdr import Codec

FLUSH_S = 0.08
"""Wall time after which what was written so far goes to disk; a kill loses no more than this and a step."""

_CHUNK_BYTES = 1 << 17
"""About a camera picture: what is packed right after it was copied is still in the processor's cache."""
_BLOCK = lz4.frame.BLOCKSIZE_MAX1MB
"""A picture in one block is packed three times as fast as in the four that LZ4 would make of it."""
_INDEX_BYTES = 1 << 20
"""The index of chunks is kept in memory up to this size, then in a passing file."""

_MESSAGE = struct.Struct("<BQHIQQ")
_HEAD_BYTES = 9
"""Opcode and length, which the length of a record does not count."""
_MESSAGE_BYTES = _MESSAGE.size - _HEAD_BYTES
_MESSAGE_CODE = int(Opcode.MESSAGE)
_NEVER_NS = (1 << 64) - 1
_MESSAGE_INDEX = struct.Struct("<BQHI")


class McapFile:
    """An MCAP file in ROS 2 encoding, being written.

    Messages are gathered into chunks; a chunk is closed and handed to the operating system by
    :meth:`flush`. Times in the file are simulated, from 0 on.

    Args:
        path: the file; its folder exists.
        codec: encodes the messages.
        clock: wall time in seconds.
    """

    def __init__(
        self, path: Path, codec: Codec | None = None, *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.codec = codec or Codec()
        self._clock = clock
        self._file = path.open("wb")
        self._file.write(MCAP0_MAGIC + _bytes_of(Header("ros2", "nrp-core")))
        self._definitions = bytearray()
        self._chunk = _Chunk()
        self._chunk_indexes = SpooledTemporaryFile(_INDEX_BYTES)  # noqa: SIM115  closed with the file
        self._chunks = 0
        self._span_ns: tuple[int, int] | None = None
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._counts: dict[str, int] = {}
        self._flushed_at = clock()

    def announce(self, topic: str, type_name: str, about: Mapping[str, str]) -> None:
        """Open a channel for a topic of a type that the codec knows.

        Args:
            topic: its name.
            type_name: the full name of its type.
            about: what readers are told of it besides its type.
        """
        if type_name not in self._schemas:
            number = self._schemas[type_name] = len(self._schemas) + 1
            text = self.codec.definition(type_name).encode()
            self._define(Schema(id=number, name=type_name, encoding="ros2msg", data=text))
        number = self._channels[topic] = len(self._channels) + 1
        metadata = {"offered_qos_profiles": "", "topic_type_hash": self.codec.hash(type_name), **about}
        self._define(Channel(number, topic, "cdr", metadata, self._schemas[type_name]))
        self._counts[topic] = 0

    def knows(self, topic: str) -> bool:
        """Return whether a topic was announced."""
        return topic in self._channels

    def write(self, topic: str, t_ns: int, *parts: bytes | memoryview) -> None:
        """Add an encoded message on an announced topic; its parts follow each other."""
        count = self._counts[topic]
        self._chunk.add(self._channels[topic], count, t_ns, parts)
        self._counts[topic] = count + 1
        if self._chunk.size > _CHUNK_BYTES:
            self._end_chunk()

    @property
    def is_due(self) -> bool:
        """Whether the last flush is long enough ago."""
        return self._clock() - self._flushed_at >= FLUSH_S

    def flush(self) -> None:
        """Hand everything to the operating system; from here on a kill of this process loses none of it."""
        self._end_chunk()
        self._file.flush()
        self._flushed_at = self._clock()

    @property
    def counts(self) -> dict[str, int]:
        """Messages written so far, by topic."""
        return dict(self._counts)

    @property
    def closed(self) -> bool:
        """Whether :meth:`close` was called."""
        return self._file.closed

    def close(self) -> None:
        """Write the index and close; calling it again does nothing."""
        if self._file.closed:
            return
        try:
            self._end_chunk()
            self._write_summary()
        finally:
            self._chunk_indexes.close()
            self._file.close()

    def _define(self, record: Schema | Channel) -> None:
        data = _bytes_of(record)
        self._definitions += data
        self._chunk.define(data)

    def _end_chunk(self) -> None:
        chunk = self._chunk
        if chunk.last_ns < 0:
            return
        self._chunk = _Chunk()
        self._chunks += 1
        first, last = chunk.first_ns, chunk.last_ns
        earliest, latest = self._span_ns or (first, last)
        self._span_ns = (min(first, earliest), max(last, latest))
        records = chunk.records()
        start, packed = self._file.tell(), lz4.frame.compress(records, block_size=_BLOCK)
        size, crc = len(records), zlib.crc32(records)
        length = self._file.write(_bytes_of(Chunk("lz4", packed, last, first, crc, size)))
        offsets, index = chunk.message_indexes(start + length)
        self._file.write(index)
        self._chunk_indexes.write(
            _bytes_of(ChunkIndex(length, start, "lz4", len(packed), last, len(index), offsets, first, size))
        )

    def _write_summary(self) -> None:
        """Write what lets a reader find its way: all definitions, counts, and where the chunks are."""
        self._file.write(_bytes_of(DataEnd(0)))
        start = self._file.tell()
        self._file.write(self._definitions)
        counts = {self._channels[topic]: count for topic, count in self._counts.items()}
        first, last = self._span_ns or (0, 0)
        statistics = Statistics(
            attachment_count=0, metadata_count=0, channel_count=len(counts), schema_count=len(self._schemas),
            chunk_count=self._chunks, message_count=sum(counts.values()), channel_message_counts=counts,
            message_start_time=first, message_end_time=last,
        )  # fmt: skip
        self._file.write(_bytes_of(statistics))
        self._chunk_indexes.seek(0)
        shutil.copyfileobj(self._chunk_indexes, self._file)
        self._file.write(_bytes_of(Footer(start, 0, 0)) + MCAP0_MAGIC)


class _Chunk:
    """Records that will be written together, and where the messages are among them."""

    def __init__(self) -> None:
        self.size = 0
        self._pieces: list[bytes | memoryview] = []
        self.first_ns, self.last_ns = _NEVER_NS, -1
        self._places: dict[int, list[int]] = {}

    def add(self, channel: int, sequence: int, t_ns: int, parts: Sequence[bytes | memoryview]) -> None:
        place = (t_ns, self.size)
        if channel in self._places:
            self._places[channel] += place
        else:
            self._places[channel] = [*place]
        if t_ns > self.last_ns:
            self.last_ns = t_ns
        if t_ns < self.first_ns:
            self.first_ns = t_ns
        size = _MESSAGE_BYTES + sum(map(len, parts))
        self._pieces.append(_MESSAGE.pack(_MESSAGE_CODE, size, channel, sequence, t_ns, t_ns))
        self._pieces += parts
        self.size += _HEAD_BYTES + size

    def define(self, record: bytes) -> None:
        """Add a schema or a channel."""
        self._pieces.append(record)
        self.size += len(record)

    def records(self) -> bytes:
        """Return all of it; only here it is copied, once."""
        return b"".join(self._pieces)

    def message_indexes(self, offset: int) -> tuple[dict[int, int], bytes]:
        """Return the index of each channel, and at which offset of the file it will be."""
        offsets: dict[int, int] = {}
        index = bytearray()
        for channel, places in self._places.items():
            offsets[channel] = offset + len(index)
            size = 8 * len(places)
            index += _MESSAGE_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size)
            index += struct.pack(f"<{len(places)}Q", *places)
        return offsets, bytes(index)


def _bytes_of(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
