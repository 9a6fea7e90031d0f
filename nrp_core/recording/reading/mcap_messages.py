"""The messages of an MCAP file, which may be truncated or damaged."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from itertools import chain
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, Schema, Statistics
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC

_HEAD = struct.Struct("<BQ")
_COMPRESSIONS = ("lz4", "zstd")
_CHUNK_OPCODE = bytes([Opcode.CHUNK])
_COMPRESSION = _HEAD.size + 3 * 8 + 4
"""Place of the name of its compression in a chunk, after two times, a size and a checksum."""
_CHUNK_FIELDS = 3 * 8 + 2 * 4 + 8
"""Size of the other fields of a chunk than the name of its compression and its data, bytes."""
_COMPRESSION_FIELDS = tuple(struct.pack("<I", len(name)) + name.encode() for name in ("", *_COMPRESSIONS))


@dataclass(frozen=True, slots=True)
class RecordedTopic:
    """A topic of a recording.

    Args:
        name: the name under which it was published or subscribed to.
        type_name: full name of its type.
        definition: definition of its type and of the types in it.
        about: its metadata: ``role``, ``unit`` if its values have one, and ``elements``, names of the numbers
            of an array, as JSON.
    """

    name: str
    type_name: str
    definition: str
    about: Mapping[str, str]

    @property
    def role(self) -> str:
        """One of :class:`~nrp_core.recording.layout.Role`, or the empty string in a foreign file."""
        return self.about.get("role", "")

    @property
    def elements(self) -> list[str]:
        """Names of the numbers of an array; none in most topics."""
        try:
            names = json.loads(self.about.get("elements", "[]"))
        except ValueError:  # from another program
            return []
        return list(map(str, names)) if isinstance(names, list) else []


def is_mcap(path: Path) -> bool:
    """Return whether a file begins like every MCAP file."""
    with path.open("rb") as file:
        return bool(file.read(len(MCAP0_MAGIC)) == MCAP0_MAGIC)


class McapMessages:
    """Reads the messages of a file once, up to the first gap or damage.

    In a file with chunks only these are read, because they have checksums.

    Args:
        path: the file.
        past_damage: whether to continue with the next intact chunk after damage.

    Attributes:
        read_bytes: size of the intact beginning of the file.
        chunks: start and end of the chunks that were read.
        ends: whether the record after the last message was read.
        broken: whether reading ended at an invalid but complete record, or at a gap between messages.
        count: number of messages that were read.
        expected: the number of messages by the file's statistics; None if it has none.
    """

    def __init__(self, path: Path, *, past_damage: bool = False) -> None:
        self.path = path
        self._past_damage = past_damage
        self.read_bytes = 0
        self.chunks: list[tuple[int, int]] = []
        self.ends = self.broken = False
        self.count = 0
        self.expected: int | None = None

    def __iter__(self) -> Iterator[tuple[RecordedTopic, Message | None]]:
        """Yield every new topic (without a message) and every message, up to the first missing one."""
        schemas: dict[int, Schema] = {}
        topics: dict[int, RecordedTopic] = {}
        next_number: dict[int, int] = {}
        for record in chain(self._definitions(), self._records()):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel) and record.id not in topics and record.schema_id in schemas:
                schema = schemas[record.schema_id]
                topic = RecordedTopic(record.topic, schema.name, schema.data.decode(), record.metadata)
                topics[record.id] = topic
                yield topic, None
            elif isinstance(record, Message) and record.channel_id in topics:
                if record.sequence not in (0, next_number.get(record.channel_id, 0)):
                    self.broken = True
                    if not self._past_damage:
                        return
                next_number[record.channel_id] = record.sequence + 1
                self.count += 1
                yield topics[record.channel_id], record

    @property
    def all_read(self) -> bool:
        """Whether every message that was written has been read."""
        return self.ends and not self.broken and self.expected in (None, self.count)

    @property
    def whole(self) -> bool:
        """Whether every message has been read, and the file ends as it should."""
        return self.all_read and self.closed

    @property
    def closed(self) -> bool:
        """Whether the file has the end of a closed file."""
        with self.path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - len(MCAP0_MAGIC)))
            return size > len(MCAP0_MAGIC) and file.read() == MCAP0_MAGIC

    def _definitions(self) -> list[McapRecord]:
        """Return the definitions in the whole file, if a lost chunk may have held those of later ones."""
        if not self._past_damage:
            return []
        everything = McapMessages(self.path, past_damage=True)
        return [record for record in everything._records() if isinstance(record, Schema | Channel)]

    def _records(self) -> Iterator[McapRecord]:
        with self.path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            is_damaged = file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC
            # the length of a damaged record would lead past others, so it does not lead to the next chunk
            while self._past_damage and _seek_chunk(file, file.tell(), size):
                yield from self._next(file, size)[1]
            is_over = is_damaged and not self._past_damage
            while not is_over:
                is_over, records = self._next(file, size)
                yield from records

    def _next(self, file: BinaryIO, size: int) -> tuple[bool, list[McapRecord]]:
        """Return whether the file ends with its next record, or before it, and the records in it."""
        self.read_bytes = file.tell()
        found = _next_content(file, size)
        if found is None:
            return True, []
        try:
            return found[0] == Opcode.FOOTER, self._within(*found)
        except _BrokenRecordError:
            self.broken = True
            return True, []

    def _within(self, opcode: int, content: bytes) -> list[McapRecord]:
        """Return the records in a record, or the record itself."""
        record, inner = _unpack(opcode, content)
        if isinstance(record, Chunk):
            self.chunks.append((self.read_bytes, self.read_bytes + _HEAD.size + len(content)))
            return inner
        if isinstance(record, DataEnd):
            self.ends = True
        elif isinstance(record, Statistics):
            self.expected = record.message_count
        defines = self._past_damage and isinstance(record, Schema | Channel)
        return [] if record is None or ((self.chunks or self.ends) and not defines) else [record]


class _BrokenRecordError(Exception):
    """A record has invalid contents."""


def _unpack(opcode: int, content: bytes) -> tuple[McapRecord | None, list[McapRecord]]:
    """Return a record of a relevant kind, and the records in it if it is a chunk."""
    try:
        record = _parse(opcode, content)
        if not isinstance(record, Chunk):
            return record, []
        _require_known(record)
        if len(content) != _CHUNK_FIELDS + len(record.compression) + len(record.data):
            raise _BrokenRecordError
        return record, breakup_chunk(record, validate_crc=True)
    except Exception as error:
        raise _BrokenRecordError from error  # damage causes a different exception for each kind of record


def _require_known(chunk: Chunk) -> None:
    """Refuse chunks with an unknown compression."""
    is_plain = chunk.compression == "" and len(chunk.data) == chunk.uncompressed_size
    if not is_plain and chunk.compression not in _COMPRESSIONS:
        raise _BrokenRecordError


_READ = {
    Opcode.SCHEMA: lambda stream, _: Schema.read(stream),
    Opcode.CHANNEL: lambda stream, _: Channel.read(stream),
    Opcode.MESSAGE: Message.read,
    Opcode.CHUNK: lambda stream, _: Chunk.read(stream),
    Opcode.DATA_END: lambda stream, _: DataEnd.read(stream),
    Opcode.STATISTICS: lambda stream, _: Statistics.read(stream),
}
"""Readers of the kinds of records that are needed here."""


def _parse(opcode: int, content: bytes) -> McapRecord | None:
    read = _READ.get(opcode)
    return None if read is None else read(ReadDataStream(BytesIO(content)), len(content))


def _next_content(file: BinaryIO, size: int) -> tuple[int, bytes] | None:
    """Return opcode and content of the next record; None if the file ends within it."""
    head = file.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    opcode, length = _HEAD.unpack(head)
    return None if length > size - file.tell() else (opcode, file.read(length))


def _seek_chunk(file: BinaryIO, start: int, size: int) -> bool:
    """Go to the first intact chunk from a place on, or to the place itself; return whether one is found."""
    if not size:
        return False
    with mmap(file.fileno(), 0, access=ACCESS_READ) as data:
        place = data.find(_CHUNK_OPCODE, start)
        while place >= 0:
            file.seek(place)
            if data[place + _COMPRESSION : place + _COMPRESSION + 8].startswith(_COMPRESSION_FIELDS):
                found = _next_content(file, size)
                with suppress(_BrokenRecordError):
                    if found is not None and _unpack(*found)[1]:
                        file.seek(place)
                        return True
            place = data.find(_CHUNK_OPCODE, place + 1)
    file.seek(start)
    return False
