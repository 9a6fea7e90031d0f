"""Messages between the two ends, which take turns.

A step of the loop is a few numbers through a socket, and columns in shared memory; any other request, answer
or error is a pickled object through the socket.
"""

from __future__ import annotations

import pickle
import socket
import struct
from collections.abc import Callable
from typing import Any, Final

from nrp_core.brain.remote.columns import SharedColumns

_BELL: Final = struct.Struct("<7q")
"""Header of every message: 0 and the length of a pickle, or 1 and the numbers of a step."""
_OBJECT: Final = 0
_STEP: Final = 1
_NUMBERS: Final = 6
_PART: Final = 1 << 20

Numbers = tuple[int, ...]


class Channel:
    """One end of the connection.

    Args:
        connection: to the other end.
        columns: the shared memory.
        when_silent: called when the socket times out; it may raise.
    """

    def __init__(
        self,
        connection: socket.socket,
        columns: SharedColumns,
        when_silent: Callable[[], None] = lambda: None,
    ) -> None:
        self._socket, self.columns, self._when_silent = connection, columns, when_silent

    def send(self, message: object) -> None:
        """Send an object."""
        data = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
        self._write(_BELL.pack(_OBJECT, len(data), *[0] * (_NUMBERS - 1)))
        self._write(data)

    def receive_line(self) -> str:
        """Wait for the line of text that precedes all messages.

        Raises:
            EOFError: the other end is closed.
        """
        line = bytearray()
        while not line.endswith(b"\n"):
            line += self._part(1)
        return line.decode().strip()

    def send_step(self, *numbers: int) -> None:
        """Send up to six numbers; their columns must already be written."""
        self._write(_BELL.pack(_STEP, *numbers, *[0] * (_NUMBERS - len(numbers))))

    def receive(self) -> tuple[Any, Numbers]:
        """Wait for a message: an object, or else None and the numbers of a step.

        Raises:
            EOFError: the other end is closed.
        """
        kind, *numbers = _BELL.unpack(self._read(_BELL.size))
        if kind == _STEP:
            return None, tuple(numbers)
        return pickle.loads(self._read(numbers[0])), ()

    def close(self) -> None:
        """Close this end."""
        self._socket.close()
        self.columns.close()

    def _write(self, data: bytes) -> None:
        left = memoryview(data)
        while left:
            try:
                left = left[self._socket.send(left) :]
            except BlockingIOError:
                self._when_silent()

    def _read(self, size: int) -> bytes | bytearray:
        data = self._part(size)
        if len(data) == size:
            return data
        whole = bytearray(data)
        while len(whole) < size:
            whole += self._part(size - len(whole))
        return whole

    def _part(self, size: int) -> bytes:
        while True:
            try:
                data = self._socket.recv(min(size, _PART))
            except BlockingIOError:
                self._when_silent()
                continue
            if not data:
                raise EOFError
            return data
