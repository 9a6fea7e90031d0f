"""Write messages into an MCAP file that ROS 2 tools open, and that is readable if it is truncated.

Rare records are written by the ``mcap`` library. Its writer is not used: it keeps an object for
every chunk until the end, and we close one every few steps; and it needs five times as long to add
a message. The layouts of messages, chunks and their indexes follow the specification of MCAP, version 0.
"""

from __future__ import annotations

import errno
import hashlib
import os
import struct
import time
from array import array
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import SpooledTemporaryFile, TemporaryFile
from typing import IO, Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, DataEnd, Footer, Header, Schema, Statistics
from mcap.writer import MCAP0_MAGIC

from nrp_core._support.closing import Closing
from nrp_core._support.files import lock
from nrp_core.messages.cdr import Codec
from nrp_core.recording.writing.encoding import Packed, Parts, frame, pack

RESERVE_BYTES = 1 << 20
"""Disk space that is reserved for the end of a file, bytes."""

LEAST_RESERVE_BYTES = 1 << 16
"""The same on a disk that is nearly full: enough for the index and ``run.json`` of a short run, bytes."""


class GrowingFile(Closing):
    """Writes a file; each piece is written completely or not at all.

    A second file without a name reserves disk space. When the disk is full, that file is removed,
    so that there is space for the end. Of a limited file size as much is reserved.

    Args:
        path: a new file; its folder exists.

    Attributes:
        size: number of bytes that were written.
        full: the error after which the reserve is used; None while there is space.
        failed: the error after which nothing more is written.
    """

    def __init__(self, path: Path) -> None:
        self.size = 0
        self.full: OSError | None = None
        self.failed: OSError | None = None
        self._file = path.open("wb", buffering=0)
        with suppress(OSError):  # a file system without locks
            lock(self._file)  # so that readers know that it is being written
        self._digest = hashlib.sha256()
        self._reserve = _reserve(path.parent)
        self._limit = _file_size_limit()

    def append(self, data: bytes | bytearray) -> None:
        """Pass bytes to the operating system.

        Raises:
            OSError: this write or an earlier one failed.
        """
        if self.failed is not None:
            raise self.failed
        with memoryview(data) as rest:
            try:
                written = 0
                while written < len(rest):
                    written += self._write_some(rest[written:])
            except OSError as error:
                self.failed = error
                self.cut(self.size)
                raise
        self._digest.update(data)
        self.size += len(data)

    def cut(self, size: int) -> None:
        """Truncate the file to a size after a failed write."""
        self._file.truncate(size)

    @property
    def digest(self) -> str:
        """The SHA-256 of the file."""
        return self._digest.hexdigest()

    @property
    def closed(self) -> bool:
        """Whether :meth:`close` was called."""
        return self._file.closed

    def close(self) -> None:
        """Close the file and remove the reserve; calling it again does nothing."""
        self._free_reserve()
        self._file.close()

    def _write_some(self, data: memoryview) -> int:
        if self._limit is not None and self.full is None and self.size + len(data) > self._limit:
            self.full = OSError(errno.EFBIG, os.strerror(errno.EFBIG))
        try:
            return self._file.write(data)
        except OSError as error:
            if self._reserve is None:
                raise
            self._free_reserve()
            self.full = error
            return self._file.write(data)

    def _free_reserve(self) -> None:
        if self._reserve is not None:
            self._reserve.close()
            self._reserve = None


def _reserve(folder: Path) -> IO[bytes] | None:
    """Reserve disk space in a folder: less on a disk that is nearly full, and None on a full one."""
    try:
        reserve = TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115  closed with the file
    except OSError:
        return None
    size = RESERVE_BYTES
    while size >= LEAST_RESERVE_BYTES:
        try:
            if reserve.seek(0) == 0 and reserve.write(bytes(size)) == size:
                return reserve
        except OSError:
            pass
        reserve.truncate(0)
        size //= 2
    reserve.close()
    return None


def _file_size_limit() -> int | None:
    """Return the size from which a file uses its reserve, if this process may not write files of any size."""
    try:
        import resource
    except ImportError:  # on Windows
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    return None if limit == resource.RLIM_INFINITY else limit - min(RESERVE_BYTES, limit // 2)


FLUSH_S = 0.065
"""Wall time between two flushes to disk, s."""

_CHUNK_BYTES = 1 << 20
"""Maximum size of a chunk, which a reader decompresses at once."""
_INDEX_BYTES = 1 << 20
"""The index of chunks is kept in memory up to this size, then in a temporary file."""

_MESSAGE = struct.Struct("<BQHIQQ")
_HEAD_BYTES = 9
"""Opcode and length, which the length of a record excludes."""
_MESSAGE_BYTES = _MESSAGE.size - _HEAD_BYTES
_MESSAGE_CODE = int(Opcode.MESSAGE)
_NO_CRC = 0
"""The checksum of a whole chunk is omitted; each block in it has its own."""
_MESSAGE_INDEX = struct.Struct("<BQHI")
_PLACE = struct.Struct("<HQ")
_CHUNK = struct.Struct("<BQQQQII3sQ")
_CHUNK_INDEX = struct.Struct("<BQQQQQI")
_SIZES = struct.Struct("<QI3sQQ")
_LZ4 = (3, b"lz4")


class McapFile:
    """An MCAP file in ROS 2 encoding, being written.

    Messages are collected in chunks; a chunk is closed and passed to the operating system by
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
        self._file = GrowingFile(path)
        self._file.append(MCAP0_MAGIC + _bytes_of(Header("ros2", "nrp-core")))
        self._definitions = bytearray()
        self._chunk = _Chunk()
        self._chunk_indexes = SpooledTemporaryFile(_INDEX_BYTES)  # noqa: SIM115  closed with the file
        self._chunks = 0
        self._span_ns: tuple[int, int] | None = None
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, _Channel] = {}
        self._flushed_at = clock()

    def announce(self, topic: str, type_name: str, about: Mapping[str, str]) -> None:
        """Open a channel for a topic of a type that the codec supports.

        Args:
            topic: its name.
            type_name: the full name of its type.
            about: its metadata besides its type.
        """
        if type_name not in self._schemas:
            number = self._schemas[type_name] = len(self._schemas) + 1
            text = self.codec.definition(type_name).encode()
            self._define(Schema(id=number, name=type_name, encoding="ros2msg", data=text))
        number = len(self._channels) + 1
        metadata = {"offered_qos_profiles": "", "topic_type_hash": self.codec.hash(type_name), **about}
        self._define(Channel(number, topic, "cdr", metadata, self._schemas[type_name]))
        self._channels[topic] = _Channel(number)

    def knows(self, topic: str) -> bool:
        """Return whether a topic was announced."""
        return topic in self._channels

    def write(self, topic: str, t_ns: int, parts: Parts) -> None:
        """Add an encoded message, a sequence of parts, on an announced topic."""
        self._chunk.add(self._channels[topic], t_ns, parts)
        if self._chunk.size > _CHUNK_BYTES:
            self._end_chunk()

    def is_due(self, after_s: float | None = None) -> bool:
        """Return whether the last flush was this wall time ago, by default :data:`FLUSH_S`."""
        return self._clock() - self._flushed_at >= (FLUSH_S if after_s is None else after_s)

    def flush(self) -> None:
        """Pass everything to the operating system, so that a kill of this process does not lose it."""
        self._end_chunk()
        self._flushed_at = self._clock()

    @property
    def counts(self) -> dict[str, int]:
        """Messages written so far, by topic."""
        return {topic: channel.count for topic, channel in self._channels.items()}

    @property
    def full(self) -> OSError | None:
        """The error of a full disk; the remaining space is reserved for the end of the file."""
        return self._file.full

    @property
    def digest(self) -> str | None:
        """The SHA-256 of the file once it is closed; None before, and if writing failed."""
        return self._file.digest if self._file.closed and self._file.failed is None else None

    @property
    def closed(self) -> bool:
        """Whether :meth:`close` was called."""
        return self._file.closed

    def close(self) -> None:
        """Write the index and close; calling it again does nothing.

        Raises:
            OSError: it cannot be written; the file then ends like that of a killed run.
        """
        if self._file.closed:
            return
        try:
            self._end_chunk()
            end = self._file.size
            try:
                self._write_summary()
            except OSError:
                self._file.cut(end)
                raise
        finally:
            self._chunk_indexes.close()
            self._file.close()

    def _define(self, record: Schema | Channel) -> None:
        data = _bytes_of(record)
        self._definitions += data
        self._chunk.define(data)

    def _end_chunk(self) -> None:
        chunk = self._chunk
        if chunk.span_ns is None:
            return
        first, last = chunk.span_ns
        self._chunk = _Chunk()
        self._chunks += 1
        earliest, latest = self._span_ns or (first, last)
        self._span_ns = (min(first, earliest), max(last, latest))
        packed, place = chunk.packed(), self._file.size
        head = _CHUNK.pack(
            Opcode.CHUNK, _CHUNK.size - _HEAD_BYTES + len(packed), first, last, chunk.size, _NO_CRC,
            *_LZ4, len(packed),
        )  # fmt: skip
        length = len(head) + len(packed)
        index, offsets = chunk.message_indexes(place + length)
        self._file.append(b"".join((head, packed, index)))
        self._chunk_indexes.write(
            _CHUNK_INDEX.pack(
                Opcode.CHUNK_INDEX, _CHUNK_INDEX.size + len(offsets) + _SIZES.size - _HEAD_BYTES, first, last,
                place, length, len(offsets),
            )
            + offsets
            + _SIZES.pack(len(index), *_LZ4, len(packed), chunk.size)
        )  # fmt: skip

    def _write_summary(self) -> None:
        """Write the summary section: all definitions, counts, and the places of chunks."""
        self._file.append(_bytes_of(DataEnd(0)))
        start = self._file.size
        self._file.append(self._definitions)
        counts = {channel.number: channel.count for channel in self._channels.values()}
        first, last = self._span_ns or (0, 0)
        statistics = Statistics(
            attachment_count=0, metadata_count=0, channel_count=len(counts), schema_count=len(self._schemas),
            chunk_count=self._chunks, message_count=sum(counts.values()), channel_message_counts=counts,
            message_start_time=first, message_end_time=last,
        )  # fmt: skip
        self._file.append(_bytes_of(statistics))
        self._chunk_indexes.seek(0)
        while block := self._chunk_indexes.read(_INDEX_BYTES):
            self._file.append(block)
        self._file.append(_bytes_of(Footer(start, 0, 0)) + MCAP0_MAGIC)


class _Channel:
    """A topic: its number, its number of messages, and the positions of those in the chunk."""

    __slots__ = ("count", "number", "places")

    def __init__(self, number: int) -> None:
        self.number, self.count = number, 0
        self.places: list[int] = []


class _Chunk:
    """Records that are written together, and the positions of the messages among them."""

    def __init__(self) -> None:
        self.size = 0
        self._blocks: list[bytes] = []
        self._pieces: list[bytes | memoryview] = []
        self._channels: list[_Channel] = []

    def add(self, channel: _Channel, t_ns: int, parts: Parts) -> None:
        """Add a message."""
        places = channel.places
        if not places:
            self._channels.append(channel)
        places += (t_ns, self.size)
        size = _MESSAGE_BYTES
        for part in parts:
            size += len(part)
        add = self._pieces.append
        add(_MESSAGE.pack(_MESSAGE_CODE, size, channel.number, channel.count, t_ns, t_ns))
        for part in parts:
            if isinstance(part, Packed):
                self._pack_pieces()
                self._blocks.append(part.blocks)
            else:
                add(part)
        self.size += _HEAD_BYTES + size
        channel.count += 1

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The first and the last time of its messages; None without messages."""
        if not self._channels:
            return None
        times = [channel.places[::2] for channel in self._channels]
        return min(map(min, times)), max(map(max, times))

    def define(self, record: bytes) -> None:
        """Add a schema or a channel."""
        self._pieces.append(record)
        self.size += len(record)

    def packed(self) -> bytes:
        """Return its compressed contents."""
        self._pack_pieces()
        return frame(self._blocks)

    def _pack_pieces(self) -> None:
        if self._pieces:
            self._blocks.append(pack(b"".join(self._pieces)))
            self._pieces.clear()

    def message_indexes(self, offset: int) -> tuple[bytes, bytes]:
        """Return the indexes of the channels in sequence, and the position of each in the file."""
        pieces, places_of, size = list[bytes](), bytearray(), 0
        for channel in self._channels:
            places, channel.places = array("Q", channel.places).tobytes(), []
            places_of += _PLACE.pack(channel.number, offset + size)
            head = _MESSAGE_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(places), channel.number, len(places))
            pieces += (head, places)
            size += len(head) + len(places)
        return b"".join(pieces), bytes(places_of)


def _bytes_of(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
