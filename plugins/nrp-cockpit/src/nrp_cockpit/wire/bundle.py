"""Many messages in one write, because a system call is the largest cost of a small message."""

from __future__ import annotations

from asyncio import Transport
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

LARGE_BYTES = 1 << 16
"""Maximum size of a bundle; larger messages are written alone, because copying them would cost more."""


class Bundle:
    """A transport that collects writes while a block is open, and then writes them in one piece.

    Args:
        transport: the transport of a connection, which does everything else.
    """

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._parts: list[bytes] = []
        self._bytes = 0
        self._is_open = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

    @property
    def is_full(self) -> bool:
        """Whether to write now, so that the sender waits if the client does not read."""
        return self._bytes >= LARGE_BYTES

    @contextmanager
    def open(self) -> Iterator[None]:
        """Collect the writes of this block until its end."""
        self._bytes, self._is_open = 0, True
        try:
            yield
        finally:
            self._is_open = False
            self._write_parts()

    def write(self, data: bytes) -> None:
        """Write, or collect until the end of the block."""
        self._bytes += len(data)
        if self._is_open and len(data) < LARGE_BYTES:
            self._parts.append(data)
        else:
            self._write_parts()
            self._transport.write(data)

    def _write_parts(self) -> None:
        if self._parts:
            parts, self._parts = self._parts, []
            self._transport.write(b"".join(parts))
