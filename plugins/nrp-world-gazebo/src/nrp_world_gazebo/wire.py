"""The protocol between the engine and the plugin in Gazebo.

A request is a length (uint32) and that many bytes: operations, each a letter and its numbers. They are
carried out in order. The answer is a length, a byte that is 0, and the answers of the operations that have
one; or a byte that is 1 and the text of an error. Everything is little-endian.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterable

import numpy as np

from nrp_core.world import FloatArray

VERSION = 3
"""The version of the protocol; ``gazebo/wire.hh`` has the same one."""

LINK_ROW, JOINT_ROW = 13, 3
"""Numbers of a link and of a joint in a state."""
_LENGTH = struct.Struct("<I")
_CONTACT = np.dtype([("links", "<u4", 2), ("numbers", "<f8", 10)])


class EndedError(Exception):
    """The other side has closed the connection."""


class RefusedError(Exception):
    """The other side answers with an error; its text is the argument."""


def operation(letter: str, *numbers: int, values: Iterable[float] = ()) -> bytes:
    """Return an operation: a letter, unsigned integers of 4 bytes, and floating-point numbers of 8 bytes."""
    row = [float(value) for value in values]
    return struct.pack(f"<c{len(numbers)}I{len(row)}d", letter.encode(), *numbers, *row)


def named(letter: str, name: str, values: Iterable[float]) -> bytes:
    """Return an operation on an object that is identified by its name."""
    text, row = name.encode(), [float(value) for value in values]
    return struct.pack(f"<cI{len(text)}s{len(row)}d", letter.encode(), len(text), text, *row)


def frame(content: bytes) -> bytes:
    """Return content with its length in front."""
    return _LENGTH.pack(len(content)) + content


def contacts(answer: memoryview) -> tuple[list[tuple[int, int]], FloatArray, memoryview]:
    """Return the contacts in front of an answer, and what follows them.

    Returns:
        The numbers of the links of each contact; position, normal out of the second link, depth and force of
        the second on the first, shape ``(n, 10)``; the rest of the answer.
    """
    (count,) = _LENGTH.unpack_from(answer)
    end = _LENGTH.size + count * _CONTACT.itemsize
    rows = np.frombuffer(answer[_LENGTH.size : end], _CONTACT)
    links = [(int(one), int(other)) for one, other in rows["links"]]
    return links, rows["numbers"].astype(float), answer[end:]


class Channel:
    """A connected socket.

    Args:
        connected: the socket; its time-out is that of an answer.
    """

    def __init__(self, connected: socket.socket) -> None:
        self._socket = connected

    def ask(self, content: bytes) -> memoryview:
        """Send operations and return their answers.

        Raises:
            EndedError: the other side has ended.
            RefusedError: it refuses an operation.
            TimeoutError: it does not answer in time.
        """
        try:
            self._socket.sendall(frame(content))
            (length,) = _LENGTH.unpack(self._read(_LENGTH.size))
            answer = self._read(length)
        except (ConnectionError, BrokenPipeError) as error:
            raise EndedError(str(error)) from error
        if not length or answer[0]:
            raise RefusedError(bytes(answer[1:]).decode(errors="replace"))
        return answer[1:]

    def close(self) -> None:
        """Close the socket, which ends the other side."""
        self._socket.close()

    def _read(self, size: int) -> memoryview:
        content = memoryview(bytearray(size))
        done = 0
        while done < size:
            more = self._socket.recv_into(content[done:])
            if not more:
                raise EndedError("the connection was closed")
            done += more
        return content
