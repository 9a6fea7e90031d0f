"""Many messages in one write: a system call costs more than all else that is done for a small message."""

from __future__ import annotations

from asyncio import Transport
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

LARGE_BYTES = 1 << 16
"""What is as large is written by itself: to copy it into a bundle would cost more. Nor is a bundle larger."""


class Bundle:
    """A transport that keeps what is written while it is open, and then writes it in one piece.

    Args:
        transport: of a connection; it does everything else.
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
        """Whether it should be written now, so that whoever sends waits if the client does not read."""
        return self._bytes >= LARGE_BYTES

    @contextmanager
    def open(self) -> Iterator[None]:
        """Keep what is written in this block until its end."""
        self._bytes, self._is_open = 0, True
        try:
            yield
        finally:
            self._is_open = False
            self._write_parts()

    def write(self, data: bytes) -> None:
        """Write, or keep until the end of the block."""
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
