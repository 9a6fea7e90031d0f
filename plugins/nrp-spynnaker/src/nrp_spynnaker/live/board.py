"""The UDP port of a SpiNNaker board, for programs that take the network for one on a machine.

A program sets the board's IP tag to its own address, and from then on spikes are sent there; spikes for an
injector come as SDP messages to its core. The messages are those of SpiNNMan and of SCAMP, the monitor of a
board.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from typing import Final

from nrp_core.errors import NetworkError

PORT: Final = 17893
"""The port at which every board listens."""
TAG: Final = 1
"""The tag through which spikes leave the board."""
_ADDRESSES: Final = [f"127.0.0.{k}" for k in range(1, 255)]
"""A board has its port to itself; the loopback addresses are boards of networks that run at the same time."""
_HEADER: Final = struct.Struct("<2xBBBBBBBB")
"""Flags, tag, port and core of destination and source, and y and x of the chips of both."""
_COMMAND: Final = struct.Struct("<HHI")
"""Number, sequence and first argument of a command."""
_REPLY_EXPECTED: Final = 0x80
_NO_REPLY: Final = 0x07
_CORES: Final = 16
"""Cores of a chip."""
_SET_TAG, _SET, _OK, _BAD_COMMAND = 26, 1, 0x80, 0x83
_LARGEST: Final = 65536


def place_of(core: int) -> tuple[int, int, int]:
    """Return the x and y of the chip, and the number on it, of a core; they are numbered from 0."""
    return core // _CORES, 0, core % _CORES + 1


class Board:
    """The board.

    Attributes:
        address: its IP address.

    Raises:
        NetworkError: there is none left.
    """

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._listeners: dict[tuple[str, int], None] = {}
        for self.address in _ADDRESSES:
            try:
                self._socket.bind((self.address, PORT))
            except OSError:  # another network's
                continue
            return
        self._socket.close()
        raise NetworkError(f"UDP port {PORT} is in use at every address of this machine")

    def fileno(self) -> int:
        """Return the descriptor to wait for."""
        return self._socket.fileno()

    def packets(self) -> Iterator[tuple[int, bytes]]:
        """Answer what has arrived, and yield packets of spikes: the number of a core, and what it is sent."""
        while True:
            try:
                message, sender = self._socket.recvfrom(_LARGEST)
            except BlockingIOError:
                return
            if len(message) < _HEADER.size:
                continue
            flags, _, to, _, _, x, _, _ = _HEADER.unpack_from(message)
            if to >> 5:  # a port of a program on a core; port 0 is that of the monitor
                core = x * _CORES + (to & 31) - 1
                yield core, message[_HEADER.size :]
            elif flags & _REPLY_EXPECTED and len(message) >= _HEADER.size + _COMMAND.size:
                self._socket.sendto(self._reply(message, sender), sender)

    def _reply(self, message: bytes, sender: tuple[str, int]) -> bytes:
        _, tag, to, source, y, x, source_y, source_x = _HEADER.unpack_from(message)
        command, sequence, argument = _COMMAND.unpack_from(message, _HEADER.size)
        is_set = command == _SET_TAG and argument >> 16 & 0xF == _SET
        if is_set:
            self._listeners[sender] = None
        header = _HEADER.pack(_NO_REPLY, tag, source, to, source_y, source_x, y, x)
        return header + _COMMAND.pack(_OK if is_set else _BAD_COMMAND, sequence, argument & 0xFF)

    def send(self, packet: bytes) -> None:
        """Send a packet of spikes to the programs that have set the tag."""
        for listener in self._listeners:
            self._socket.sendto(packet, listener)

    def forget(self) -> None:
        """Forget the programs: before a run they set the tag anew."""
        self._listeners.clear()

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()
