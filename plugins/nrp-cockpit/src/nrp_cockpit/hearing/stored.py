"""The messages of a recording at any time, found by the index of its file."""

from __future__ import annotations

import struct
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode

from nrp_cockpit.hearing.chunks import Chunks
from nrp_core._support.arrays import IntArray
from nrp_core.recording.reading.mcap_messages import RecordedTopic

_MOST_UNPACKED = 24
"""Number of chunks in memory, about a megabyte each."""
_MOST_INDEXES = 4096

_MESSAGE = struct.Struct("<BQHIQQ")
_BEFORE_LENGTH = 9
_MESSAGE_INDEX = struct.Struct("<HI")
_ENTRY = np.dtype([("t_ns", "<u8"), ("offset", "<u8")])


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
        """Return the last message of a topic at or before a time; None if there is none."""
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
