"""The positions of the chunks of an MCAP file, and the topics in each, without unpacking them all."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import lz4.frame  # type: ignore[import-untyped]
import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from mcap.writer import MCAP0_MAGIC

from nrp_core.recording.reading.mcap_messages import RecordedTopic

Records = Iterator[tuple[int, int, int]]
"""Records of a file: opcode, position of the content, and its length."""

_HEAD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
_INDEX = struct.Struct("<QQQQI")
_PLACE = struct.Struct("<HQ")
_MESSAGE_INDEX = struct.Struct("<HI")
_FOOTER = struct.Struct("<BQQQI")
_LENGTH = struct.Struct("<Q")


@dataclass(slots=True)
class MessagePositions:
    """The positions of the messages of one topic.

    Args:
        channel: the number of the topic in the file.
        chunks: the numbers of the chunks with messages of it, ascending.
        indexes: for each of these, the position in the file of the index of its messages.
    """

    channel: int
    chunks: array[int] = field(default_factory=lambda: array("I"))
    indexes: array[int] = field(default_factory=lambda: array("Q"))


class Chunks:
    """The chunks of a file, by its summary, or by the headers of the chunks if the file was not closed.

    Args:
        path: the file; its end may be missing.

    Attributes:
        topics: all topics, by name.
        places: the positions of their messages, by name.
        closed: whether the file was closed, so that its end is complete.
    """

    def __init__(self, path: Path) -> None:
        self._file: BinaryIO = path.open("rb")
        self._size = self._file.seek(0, 2)
        self._begin()
        summary = self._summary()
        self.closed = summary is not None
        if summary is None or not self._could_read_summary(summary):
            self._walk()
        starts, ends = np.array(self._starts, np.int64), np.array(self._ends, np.int64)
        self.span_ns = (int(starts.min()), int(ends.max())) if len(starts) else (0, 0)
        # chunks overlap a little; these bounds are ascending, so that no chunk is missed
        self.starts = np.minimum.accumulate(starts[::-1])[::-1]
        self.ends = np.maximum.accumulate(ends)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def read(self, at: int, size: int) -> bytes:
        """Return bytes of the file, fewer at its end."""
        self._file.seek(min(at, self._size))
        return self._file.read(size)

    def unpacked(self, number: int) -> bytes:
        """Return the records in a chunk; nothing if it is damaged."""
        return self._unpacked(self._at[number])

    # -- reading the positions of chunks

    def _begin(self) -> None:
        self.topics: dict[str, RecordedTopic] = {}
        self.places: dict[str, MessagePositions] = {}
        self._at, self._starts, self._ends = array("Q"), array("Q"), array("Q")
        self._schemas: dict[int, Schema] = {}
        self._by_channel: dict[int, MessagePositions] = {}

    def _summary(self) -> int | None:
        """Return the position of the summary; None if the file was not closed."""
        length = _FOOTER.size + len(MCAP0_MAGIC)
        end = self.read(max(0, self._size - length), length)
        if len(end) < length or end[_FOOTER.size :] != MCAP0_MAGIC:
            return None
        opcode, _, start, _, _ = _FOOTER.unpack_from(end)
        return start if opcode == Opcode.FOOTER and 0 < start < self._size else None

    def _could_read_summary(self, start: int) -> bool:
        try:
            self._read_summary(start)
        except Exception:  # noqa: BLE001  damage shows in as many ways as there are kinds of records
            self._begin()
            return False
        return True

    def _read_summary(self, start: int) -> None:
        for opcode, at, length in self._records(start):
            if opcode == Opcode.CHUNK_INDEX:
                content = self.read(at, length)
                first, last, place, _, size = _INDEX.unpack_from(content)
                self._add_chunk(place + _HEAD.size, first, last)
                for channel, index in _PLACE.iter_unpack(content[_INDEX.size : _INDEX.size + size]):
                    self._add_index(channel, index + _HEAD.size)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._define(opcode, self.read(at, length))

    def _walk(self) -> None:
        """Go from chunk to chunk while the file is intact; the first chunk of a topic describes it."""
        for opcode, at, _ in self._records(len(MCAP0_MAGIC)):
            if opcode == Opcode.CHUNK:
                first, last, *_ = _CHUNK.unpack(self.read(at, _CHUNK.size))
                self._add_chunk(at, first, last)
            elif opcode == Opcode.MESSAGE_INDEX and self._at:
                channel, _ = _MESSAGE_INDEX.unpack(self.read(at, _MESSAGE_INDEX.size))
                if channel not in self._by_channel:
                    self._define_all(self._unpacked(self._at[-1]))
                self._add_index(channel, at)
            elif opcode == Opcode.DATA_END:
                return

    def _records(self, at: int) -> Records:
        while at + _HEAD.size <= self._size:
            opcode, length = _HEAD.unpack(self.read(at, _HEAD.size))
            at += _HEAD.size
            if not opcode or at + length > self._size:
                return
            yield opcode, at, length
            at += length

    def _add_chunk(self, at: int, first_ns: int, last_ns: int) -> None:
        self._at.append(at)
        self._starts.append(first_ns)
        self._ends.append(last_ns)

    def _add_index(self, channel: int, at: int) -> None:
        place = self._by_channel.get(channel)
        if place is not None:
            place.chunks.append(len(self._at) - 1)
            place.indexes.append(at)

    def _define_all(self, records: bytes) -> None:
        at = 0
        while at + _HEAD.size <= len(records):
            opcode, length = _HEAD.unpack_from(records, at)
            at += _HEAD.size
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._define(opcode, records[at : at + length])
            at += length

    def _define(self, opcode: int, content: bytes) -> None:
        stream = ReadDataStream(BytesIO(content))
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            self._schemas[schema.id] = schema
            return
        channel = Channel.read(stream)
        schema = self._schemas.get(channel.schema_id)
        if schema is not None and channel.id not in self._by_channel:
            text = schema.data.decode()
            self.topics[channel.topic] = RecordedTopic(channel.topic, schema.name, text, channel.metadata)
            self.places[channel.topic] = self._by_channel[channel.id] = MessagePositions(channel.id)

    def _unpacked(self, at: int) -> bytes:
        """Return the records in the chunk whose content begins at a position; nothing if it is damaged."""
        try:
            *_, length = _CHUNK.unpack(self.read(at, _CHUNK.size))
            unpack = _UNPACK[self._file.read(min(length, self._size))]
            (packed,) = _LENGTH.unpack(self._file.read(_LENGTH.size))
            return unpack(self._file.read(min(packed, self._size)))
        except (struct.error, KeyError, RuntimeError, EOFError):
            return b""


def _as_it_is(data: bytes) -> bytes:
    return data


_UNPACK: dict[bytes, Callable[[bytes], bytes]] = {b"": _as_it_is, b"lz4": lz4.frame.decompress}
"""How to unpack chunks; recordings are packed with LZ4."""
