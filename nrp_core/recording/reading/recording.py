"""Read recordings, also such whose writing was cut short."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from nrp_core.errors import ExperimentError
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, Role
from nrp_core.world.messages.cdr import Codec


@dataclass(frozen=True, slots=True)
class RecordedTopic:
    """A topic of a recording.

    Args:
        name: as it was published or subscribed to.
        type_name: full name of its type.
        definition: text of its type and of those in it.
        about: its metadata: ``role``, and ``unit`` where its values have one.
    """

    name: str
    type_name: str
    definition: str
    about: Mapping[str, str]

    @property
    def role(self) -> str:
        """One of :class:`~nrp_core.recording.layout.Role`, or the empty string in a foreign file."""
        return self.about.get("role", "")


@dataclass(frozen=True, slots=True)
class Recorded:
    """A message of a recording: topic, simulated time, and the message itself."""

    topic: str
    t_ns: int
    message: Any


class Recording:
    """A recording on disk.

    Args:
        path: the folder of a recording, or an MCAP file by itself.

    Raises:
        ExperimentError: there is no recording.
    """

    def __init__(self, path: Path | str) -> None:
        path = Path(path)
        self.folder = path if path.is_dir() else path.parent
        self.file = path / MCAP_NAME if path.is_dir() else path
        if not self.file.is_file():
            lacking = f"no file '{self.file.name}' is in it" if path.is_dir() else "the folder does not exist"
            raise ExperimentError(f"no recording: {lacking}", path=path)

    @cached_property
    def run(self) -> dict[str, Any]:
        """What ``run.json`` says: versions, seeds, machine, options, result; empty for a bare file."""
        path = self.folder / RUN_NAME
        if not path.is_file():
            return {}
        try:
            data = json.loads(path.read_text())
        except (ValueError, RecursionError) as error:
            raise ExperimentError(f"cannot be read as JSON: {error}", path=path) from error
        if not isinstance(data, dict) or data.get(DIGEST, digest_of(data)) != digest_of(data):
            raise ExperimentError("was changed or damaged since it was written", path=path)
        return data

    @cached_property
    def complete(self) -> bool:
        """Whether the file was closed and nothing in it is damaged; if not, what is whole of it is read.

        All of it is read to know.
        """
        with self.file.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - len(MCAP0_MAGIC)))
            closed = size > len(MCAP0_MAGIC) and file.read() == MCAP0_MAGIC
        if closed:
            for _ in self._read():
                pass
        return closed and self._whole

    @cached_property
    def topics(self) -> dict[str, RecordedTopic]:
        """Every topic by its name."""
        return {topic.name: topic for topic, _ in self._read()}

    def with_role(self, *roles: Role) -> list[RecordedTopic]:
        """Return the topics of these roles."""
        return [topic for topic in self.topics.values() if topic.role in roles]

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Recorded]:
        """Return messages in the order of writing, which is that of time.

        Args:
            topics: only these; all by default.

        Raises:
            ExperimentError: a message is not of its type, in a file that is not ours.
        """
        codec = Codec({})
        for topic, message in self.raw(topics):
            yield Recorded(topic.name, message.log_time, self.decoded(codec, topic, message.data))

    def decoded(self, codec: Codec, topic: RecordedTopic, data: bytes) -> Any:
        """Return a message.

        Raises:
            ExperimentError: it is none of that type, in a file that is not ours.
        """
        self.define(codec, topic)
        try:
            return codec.decode(data, topic.type_name)
        except Exception as error:  # whatever bytes may raise that are something else
            message = f"a message of {topic.name} ({topic.type_name}) cannot be read: {error}"
            raise ExperimentError(message, path=self.file) from error

    def define(self, codec: Codec, topic: RecordedTopic) -> None:
        """Let a codec know the type of a topic.

        Raises:
            ExperimentError: it is not defined as ROS 2 defines types, in a file that is not ours.
        """
        try:
            codec.define(topic.type_name, topic.definition)
        except Exception as error:
            message = f"the type of {topic.name} ({topic.type_name}) cannot be read: {error}"
            raise ExperimentError(message, path=self.file) from error

    def raw(self, topics: Collection[str] | None = None) -> Iterator[tuple[RecordedTopic, Message]]:
        """Return messages undecoded, as records of the file."""
        for topic, message in self._read():
            if message is not None and (topics is None or topic.name in topics):
                yield topic, message

    def _read(self) -> Iterator[tuple[RecordedTopic, Message | None]]:
        """Return every topic as it opens (without a message), and every message; end where one is missing."""
        schemas: dict[int, Schema] = {}
        topics: dict[int, RecordedTopic] = {}
        expected: dict[int, int] = {}
        self._whole = False
        for record in _records(self.file):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel) and record.id not in topics and record.schema_id in schemas:
                schema = schemas[record.schema_id]
                topic = RecordedTopic(record.topic, schema.name, schema.data.decode(), record.metadata)
                topics[record.id] = topic
                yield topic, None
            elif isinstance(record, Message) and record.channel_id in topics:
                if record.sequence not in (0, expected.get(record.channel_id, 0)):
                    return
                expected[record.channel_id] = record.sequence + 1
                yield topics[record.channel_id], record
            elif isinstance(record, DataEnd):
                self._whole = True


DIGEST = "digest"
"""Key of ``run.json``: what :func:`digest_of` says of all else in it."""


def digest_of(data: Any) -> str:
    """Return the SHA-256 of JSON data, but for its digest."""
    rest = {key: value for key, value in data.items() if key != DIGEST} if isinstance(data, dict) else data
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def _records(path: Path) -> Iterator[McapRecord]:
    """Return the records of an MCAP file up to where it was cut or stops making sense.

    In a file with chunks only these are believed, because they carry a checksum.
    """
    with path.open("rb") as file:
        reader = StreamReader(file, record_size_limit=path.stat().st_size, emit_chunks=True)
        outer, chunked = reader.records, False
        while True:
            try:
                record = next(outer, None)
                inner = breakup_chunk(record, validate_crc=True) if isinstance(record, Chunk) else [record]
            except Exception:  # noqa: BLE001  a cut shows in as many ways as there are kinds of records
                return
            if record is None:
                return
            if isinstance(record, (Chunk, DataEnd)) or not chunked:
                yield from inner
            chunked = chunked or isinstance(record, Chunk)
