"""Other programs that take part in a run by sPyNNaker's database, such as a view of spikes.

Before each run a program gets the name of the database's file by a message to its port, and confirms that it
has read it. It is notified that the run begins, and in the end that it has stopped. A program that takes the
network for one on a machine reads the keys of cells there, and sets where spikes go by the board's UDP port.
"""

from __future__ import annotations

import logging
import socket
import sqlite3
import struct
import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from select import select
from tempfile import TemporaryDirectory
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
        NetworkError: all are used.
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
        """Answer the received messages, and yield packets of spikes: the number of a core, and its data."""
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


_TABLES = """
CREATE TABLE configuration_parameters(parameter_id TEXT PRIMARY KEY, value REAL);
CREATE TABLE proxy_configuration(kind TEXT, name TEXT, value TEXT);
CREATE TABLE label_event_atom_view(label TEXT, event INTEGER, atom INTEGER);
CREATE TABLE app_output_tag_view(
    pre_vertex_label TEXT, post_vertex_label TEXT, ip_address TEXT, port INTEGER, strip_sdp INTEGER,
    board_address TEXT, tag INTEGER, chip_x INTEGER, chip_y INTEGER);
CREATE TABLE application_vertex_placements(vertex_label TEXT, x INTEGER, y INTEGER, p INTEGER);
CREATE TABLE chip_eth_info(x INTEGER, y INTEGER, eth_x INTEGER, eth_y INTEGER, eth_ip_address TEXT);
"""
_RECEIVER = "LiveSpikeReceiver"
"""What connections call the part of the machine that passes spikes on."""
_FOREVER = -1.0


def write_database(
    path: Path, address: str, keys: Mapping[str, range], sent: list[str], cores: list[str],
    timestep_ms: float, run_time_ms: float,
) -> None:  # fmt: skip
    """Write the database; replace an existing file.

    Args:
        path: its file.
        address: the IP address of the board.
        keys: of the cells of populations, in their order, by label.
        sent: the populations whose spikes are sent.
        cores: the populations that receive spikes, in the order of their cores.
        timestep_ms: the time step.
        run_time_ms: the time to run, or infinity.
    """
    path.unlink(missing_ok=True)
    with closing(sqlite3.connect(path)) as database, database:
        database.executescript(_TABLES)
        fill = database.executemany
        fill(
            "INSERT INTO configuration_parameters VALUES (?, ?)",
            [
                ("machine_time_step", 1000.0 * timestep_ms),
                ("time_scale_factor", 1.0),
                ("runtime", run_time_ms if run_time_ms < float("inf") else _FOREVER),
            ],
        )
        for label, numbers in keys.items():
            rows = ((label, key, cell) for cell, key in enumerate(numbers))
            fill("INSERT INTO label_event_atom_view VALUES (?, ?, ?)", rows)
        outputs = [(label, _RECEIVER, address, PORT, 1, address, TAG, 0, 0) for label in sent]
        fill("INSERT INTO app_output_tag_view VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", outputs)
        places = [(label, *place_of(core)) for core, label in enumerate(cores)]
        fill("INSERT INTO application_vertex_placements VALUES (?, ?, ?, ?)", places)
        database.execute("INSERT INTO chip_eth_info VALUES (0, 0, 0, 0, ?)", (address,))


_logger = logging.getLogger(__name__)
_NOTICE: Final = 1 << 14
_DATABASE, _STOPPED, _BEGINS = (struct.pack("<H", _NOTICE | number) for number in (1, 10, 11))
_PATIENCE_S: Final = 60.0
_NAME: Final = "input_output_database.sqlite3"


class Programs:
    """The programs that listen at some ports of this machine.

    Args:
        ports: the ports; those without a listening program are skipped.
        keys: the keys of the cells of populations, by label.
        sent: the populations whose spikes the programs receive.
        heard: the populations to which they send spikes.
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
                except ConnectionRefusedError:  # no program listens there
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
