"""Whole messages as WebSocket frames (RFC 6455, 5.2), so that many can be written in one system call.

A system call is the largest cost of a small message, and each copy that of a large one.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

Pieces = Sequence[bytes | memoryview]

_TEXT, _BINARY = 0x81, 0x82  # the only frame of its message, of this kind
_SHORT, _MEDIUM, _LONG = struct.Struct("!BB"), struct.Struct("!BBH"), struct.Struct("!BBQ")


def frame(message: str | Pieces) -> list[bytes | memoryview]:
    """Return the pieces of the frame of a message, without copying it.

    Args:
        message: a text, or the pieces of a binary message.
    """
    if isinstance(message, str):
        text = message.encode()
        return [_head(_TEXT, len(text)), text]
    return [_head(_BINARY, sum(map(len, message))), *message]


def _head(kind: int, size: int) -> bytes:
    """Return the head of a frame from a server, which is not masked."""
    if size < 126:
        return _SHORT.pack(kind, size)
    return _MEDIUM.pack(kind, 126, size) if size < 1 << 16 else _LONG.pack(kind, 127, size)
