"""Other programs that take part in a run by sPyNNaker's database, such as a view of spikes.

Before each run a program is told the file of the database, by a message to its port, and confirms that it has
read it; then it is told that the run begins, and in the end that it has stopped.
"""

from __future__ import annotations

import logging
import socket
import struct
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from select import select
from tempfile import TemporaryDirectory
from typing import Final

from nrp_core.errors import NetworkError
from nrp_spynnaker.live.board import Board
from nrp_spynnaker.live.database import write_database

_logger = logging.getLogger(__name__)
_COMMAND: Final = 1 << 14
_DATABASE, _STOPPED, _BEGINS = (struct.pack("<H", _COMMAND | number) for number in (1, 10, 11))
_PATIENCE_S: Final = 60.0
_NAME: Final = "input_output_database.sqlite3"


class Programs:
    """The programs that listen at some ports of this machine.

    Args:
        ports: the ports; where no program listens, there is nothing to do.
        keys: the keys of the cells of populations, by label.
        sent: the populations whose spikes the programs hear.
        heard: the populations into which they send spikes.
    """

    def __init__(
        self, ports: list[int], keys: Mapping[str, range], sent: list[str], heard: list[str]
    ) -> None:
        self._ports, self._keys, self._sent, self._heard = ports, keys, sent, heard
        self._board = Board()
        try:
            self._folder = TemporaryDirectory(prefix="nrp-")
        except BaseException:
            self._board.close()
            raise
        self._connections: list[socket.socket] = []
        self._have_begun = False

    @property
    def are_there(self) -> bool:
        """Whether a program takes part in the run."""
        return bool(self._connections)

    def begin(self, timestep_ms: float, run_time_ms: float) -> None:
        """Tell the programs that a run begins, and wait until they are ready.

        Raises:
            NetworkError: one does not confirm that it has read the database.
        """
        self._disconnect()
        self._board.forget()
        path = Path(self._folder.name, _NAME)
        write_database(
            path, self._board.address, self._keys, self._sent, self._heard, timestep_ms, run_time_ms
        )
        for port in self._ports:
            connection = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self._connections.append(connection)
            connection.connect(("127.0.0.1", port))
            connection.send(_DATABASE + str(path).encode())
        until = time.monotonic() + _PATIENCE_S
        for connection in list(self._connections):
            self._wait_for(connection, until)
        self._have_begun = True
        self._tell(_BEGINS)

    def _wait_for(self, connection: socket.socket, until_s: float) -> None:
        """Wait for the confirmation of a program, and answer it meanwhile as a board does."""
        port, waiting = connection.getpeername()[1], [connection.fileno(), self._board.fileno()]
        while (left_s := until_s - time.monotonic()) > 0.0:
            ready, _, _ = select(waiting, [], [], left_s)
            list(self._board.packets())
            if connection.fileno() in ready:
                try:
                    connection.recv(2)
                except ConnectionRefusedError:  # nobody listens there
                    self._connections.remove(connection)
                    connection.close()
                return
        raise NetworkError(
            f"the program at UDP port {port} has not confirmed within {_PATIENCE_S:g} s that it has read the "
            "database of keys; end it, or name another port (database_notify_port_num)"
        )

    def packets(self) -> Iterator[tuple[str, bytes]]:
        """Yield the packets with spikes that have arrived, each with the label of its population."""
        for core, packet in self._board.packets():
            if 0 <= core < len(self._heard):
                yield self._heard[core], packet

    def send(self, packet: bytes) -> None:
        """Send a packet of spikes."""
        self._board.send(packet)

    def end(self) -> None:
        """Tell the programs that the run has stopped, if it has begun."""
        if self._have_begun:
            self._have_begun = False
            self._tell(_STOPPED)

    def close(self) -> None:
        """End the connections."""
        self._disconnect()
        self._board.close()
        self._folder.cleanup()

    def _disconnect(self) -> None:
        for connection in self._connections:
            connection.close()
        self._connections.clear()

    def _tell(self, command: bytes) -> None:
        for connection in list(self._connections):
            try:
                connection.send(command)
            except ConnectionRefusedError:
                _logger.warning("the program at UDP port %d has ended", connection.getpeername()[1])
                self._connections.remove(connection)
                connection.close()
