"""The messages of a recording at any time, found by the index of its file without unpacking all chunks."""

from __future__ import annotations

import struct
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

import lz4.frame  # type: ignore[import-untyped]
import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from mcap.writer import MCAP0_MAGIC

from nrp_core.brain import IntArray
from nrp_core.recording import RecordedTopic

Records = Iterator[tuple[int, int, int]]
"""Records of a file: opcode, position of the content, and its length."""

_HEAD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
_INDEX = struct.Struct("<QQQQI")
_PLACE = struct.Struct("<HQ")
_MESSAGE_INDEX = struct.Struct("<HI")
_FOOTER = struct.Struct("<BQQQI")
_LENGTH = struct.Struct("<Q")
_MOST_UNPACKED = 24
"""Number of chunks in memory, about a megabyte each."""
_MOST_INDEXES = 4096
_MESSAGE = struct.Struct("<BQHIQQ")
_BEFORE_LENGTH = 9
_ENTRY = np.dtype([("t_ns", "<u8"), ("offset", "<u8")])


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


class Stored(NamedTuple):
    """A message of a recording: its topic, its simulated time, and its recorded bytes."""

    topic: str
    t_ns: int
    data: bytes


class _Place(NamedTuple):
    """The position of a message: its chunk, its offset there, its time and its topic."""

    chunk: int
    offset: int
    t_ns: int
    topic: str


class StoredMessages:
    """Finds messages by their time; of a long file only the required chunks are read.

    Args:
        path: an MCAP file with chunks and indexes; its end may be missing, and chunks may be damaged.

    Attributes:
        topics: all topics, by name.
        span_ns: the first and the last time.
        closed: whether the file was closed, so that its end is complete.
    """

    def __init__(self, path: Path) -> None:
        self._chunks = Chunks(path)
        self.topics: Mapping[str, RecordedTopic] = self._chunks.topics
        self.span_ns = self._chunks.span_ns
        self.closed = self._chunks.closed
        self._unpacked = lru_cache(_MOST_UNPACKED)(self._chunks.unpacked)
        self._entries = lru_cache(_MOST_INDEXES)(self._read_entries)

    def close(self) -> None:
        """Close the file."""
        self._chunks.close()

    def last(self, topic: str, t_ns: int) -> Stored | None:
        """Return the last message of a topic at or before a time, or None."""
        place = self._chunks.places[topic]
        end = bisect_right(place.chunks, int(np.searchsorted(self._chunks.starts, t_ns, "right")) - 1)
        for nth in range(end - 1, -1, -1):
            times, offsets = self._entries(place.indexes[nth], place.channel)
            for one in range(int(np.searchsorted(times, t_ns, "right")) - 1, -1, -1):
                at = _Place(place.chunks[nth], int(offsets[one]), int(times[one]), topic)
                found = self._message(at)
                if found is not None:
                    return found
        return None

    def between(self, topics: Iterable[str], after_ns: int, until_ns: int) -> list[Stored]:
        """Return the messages of some topics after one time and up to another, in order of time."""
        places = [place for topic in topics for place in self._between(topic, after_ns, until_ns)]
        places.sort()  # in this order each chunk is unpacked once
        found = [message for place in places if (message := self._message(place)) is not None]
        found.sort(key=lambda one: one.t_ns)
        return found

    def timed(self, topic: str, after_ns: int, until_ns: int) -> list[tuple[int, bytes]]:
        """Return times and bytes of the messages of a topic after one time and up to another."""
        return [(one.t_ns, one.data) for one in self.between([topic], after_ns, until_ns)]

    def _between(self, topic: str, after_ns: int, until_ns: int) -> Iterator[_Place]:
        chunks, topic_place = self._chunks, self._chunks.places[topic]
        begin = bisect_left(topic_place.chunks, int(np.searchsorted(chunks.ends, after_ns, "right")))
        end = bisect_right(topic_place.chunks, int(np.searchsorted(chunks.starts, until_ns, "right")) - 1)
        for nth in range(begin, end):
            times, offsets = self._entries(topic_place.indexes[nth], topic_place.channel)
            first, last = np.searchsorted(times, (after_ns, until_ns), "right").tolist()
            chunk = topic_place.chunks[nth]
            for t_ns, offset in zip(times[first:last].tolist(), offsets[first:last].tolist(), strict=True):
                yield _Place(chunk, offset, t_ns, topic)

    def _message(self, place: _Place) -> Stored | None:
        """Return a message; None if the index is wrong because the file is damaged."""
        records, offset = self._unpacked(place.chunk), place.offset
        if not 0 <= offset <= len(records) - _MESSAGE.size:
            return None
        opcode, length, channel, _, t_ns, _ = _MESSAGE.unpack_from(records, offset)
        end = offset + _BEFORE_LENGTH + length
        wanted = (Opcode.MESSAGE, self._chunks.places[place.topic].channel, place.t_ns)
        if (opcode, channel, t_ns) != wanted or end > len(records):
            return None
        return Stored(place.topic, t_ns, records[offset + _MESSAGE.size : end])

    def _read_entries(self, at: int, channel: int) -> tuple[IntArray, IntArray]:
        """Return times and positions of the messages of a channel in the intact part of a chunk."""
        head = self._chunks.read(at, _MESSAGE_INDEX.size)
        found, size = _MESSAGE_INDEX.unpack(head) if len(head) == _MESSAGE_INDEX.size else (0, 0)
        data = self._chunks.read(at + _MESSAGE_INDEX.size, size) if found == channel else b""
        entries = np.frombuffer(data[: len(data) // _ENTRY.itemsize * _ENTRY.itemsize], _ENTRY)
        return entries["t_ns"].astype(np.int64), entries["offset"].astype(np.int64)
