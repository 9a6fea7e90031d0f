"""Write messages into an MCAP file that ROS 2 tools open and that survives being cut."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path

from mcap.writer import CompressionType, Writer

from nrp_core.world.messages.cdr import Codec

FLUSH_S = 0.05
"""Wall time after which what was written so far goes to disk; a kill loses no more than this and a step."""

_CHUNK_BYTES = 4 << 20


class McapFile:
    """An MCAP file in ROS 2 encoding, being written.

    Messages are gathered into chunks; a chunk is closed and handed to the operating system after
    :data:`FLUSH_S` of wall time. Times in the file are simulated, from 0 on.

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
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.LZ4)
        self._writer.start(profile="ros2", library="nrp-core")
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
            definition = self.codec.definition(type_name).encode()
            self._schemas[type_name] = self._writer.register_schema(type_name, "ros2msg", definition)
        metadata = {"offered_qos_profiles": "", "topic_type_hash": self.codec.hash(type_name), **about}
        schema = self._schemas[type_name]
        self._channels[topic] = self._writer.register_channel(topic, "cdr", schema, metadata)
        self._counts[topic] = 0

    def knows(self, topic: str) -> bool:
        """Return whether a topic was announced."""
        return topic in self._channels

    def write(self, topic: str, t_ns: int, data: bytes | memoryview) -> None:
        """Add an encoded message on an announced topic."""
        sequence = self._counts[topic]
        self._counts[topic] = sequence + 1
        self._writer.add_message(self._channels[topic], t_ns, bytes(data), t_ns, sequence)

    @property
    def is_due(self) -> bool:
        """Whether the last flush is long enough ago."""
        return self._clock() - self._flushed_at >= FLUSH_S

    def flush(self) -> None:
        """Hand everything to the operating system; from here on a kill of this process loses none of it."""
        self._writer.flush()
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
            self._writer.finish()
        finally:
            self._file.close()
