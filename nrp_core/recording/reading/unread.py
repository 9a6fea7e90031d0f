"""Find messages that damage has made unreachable in a file; a truncated file has none."""

from __future__ import annotations

import mmap
from collections.abc import Iterator

import lz4.frame  # type: ignore[import-untyped]

from nrp_core.recording.reading.mcap_messages import McapMessages
from nrp_core.recording.writing.packing import FRAME_HEADER

_BLOCK = 1 << 20


def unread_chunk(messages: McapMessages) -> int | None:
    """Return the position of a complete chunk that was skipped in reading a file; None if there is none.

    The content of each chunk is one frame, which contains its length.
    """
    with messages.path.open("rb") as file:
        if not file.seek(0, 2):
            return None
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return next((at for at in _outside(data, messages.chunks) if _is_whole(data, at)), None)


def _outside(data: mmap.mmap, chunks: list[tuple[int, int]]) -> Iterator[int]:
    """Return the positions of possible starts of frames outside the chunks, which are in order."""
    begin = 0
    for first, last in [*chunks, (len(data), len(data))]:
        at = data.find(FRAME_HEADER, begin, first)
        while at >= 0:
            yield at
            at = data.find(FRAME_HEADER, at + 1, first)
        begin = last


def _is_whole(data: mmap.mmap, at: int) -> bool:
    unpacking = lz4.frame.LZ4FrameDecompressor()
    try:
        while at < len(data) and not unpacking.eof:
            unpacking.decompress(data[at : at + _BLOCK])
            at += _BLOCK
    except (RuntimeError, EOFError):
        return False
    return bool(unpacking.eof)
