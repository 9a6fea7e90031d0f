"""Live spikes over UDP: from other programs to injectors, and from populations to other programs."""

from __future__ import annotations

import logging
import socket
from collections.abc import Mapping, Sequence
from typing import Final

from nrp_core.brain.pynn.spynnaker.connections import Hub, LiveInput, LiveOutput
from nrp_core.errors import NetworkError
from nrp_core.pynn.spynnaker.eieio import KEY_16_BIT, KEY_PAYLOAD_16_BIT, keys_of, packets

_logger = logging.getLogger(__name__)
_LARGEST: Final = 65536
KEYS_OF_A_POPULATION: Final = 1 << 16
"""The distance between the first keys of populations with live output, in the order in which they have it."""


class Sockets:
    """The sockets of the live connections of a script.

    Args:
        hub: the connections, which name ports.

    Raises:
        NetworkError: a port is in use, a host has no address, or a kind of packet is not sent.
    """

    def __init__(self, hub: Hub) -> None:
        self._inputs: list[tuple[str, LiveInput, socket.socket]] = []
        self._outputs: dict[str, tuple[LiveOutput, tuple[str, int], int]] = {}
        self._sender: socket.socket | None = None
        self._refused: set[str] = set()
        try:
            for label, given in hub.inputs.items():
                self._inputs.append((label, given, _bound(label, given.port)))
            for k, (label, output) in enumerate(hub.outputs.items()):
                base = hub.inputs[label].key if label in hub.inputs else k * KEYS_OF_A_POPULATION
                self._outputs[label] = output, (_address(label, output), output.port), base
            if self._outputs:
                self._sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        except NetworkError:
            self.close()
            raise

    @property
    def listens(self) -> bool:
        """Whether other programs may send spikes, so that the network keeps to the real time."""
        return bool(self._inputs)

    def received(self, sizes: Mapping[str, int]) -> list[tuple[str, list[int]]]:
        """Return the spikes that have arrived: labels of injectors, and cells.

        A packet that is not one, and keys that are not those of cells, are told once for each population.

        Args:
            sizes: the number of cells of each injector.
        """
        found = []
        for label, given, bound in self._inputs:
            while True:
                try:
                    packet = bound.recv(_LARGEST)
                except BlockingIOError:
                    break
                cells = self._cells(label, packet, given.key, sizes[label])
                if cells:
                    found.append((label, cells))
        return found

    def send(self, label: str, time: int, cells: Sequence[int]) -> None:
        """Send the spikes of a step to where the live output of a population goes."""
        if label not in self._outputs or not cells:
            return
        output, address, base = self._outputs[label]
        assert self._sender is not None
        for packet in packets([base + cell for cell in cells], time, output.kind):
            self._sender.sendto(packet, address)

    def close(self) -> None:
        """Close all sockets."""
        for _, _, bound in self._inputs:
            bound.close()
        if self._sender is not None:
            self._sender.close()
        self._inputs, self._outputs, self._sender = [], {}, None

    def _cells(self, label: str, packet: bytes, base: int, size: int) -> list[int]:
        try:
            cells = [key - base for key in keys_of(packet, base >> 16)]
        except ValueError as error:
            self._tell(f"a packet for population '{label}' is not used: {error}")
            return []
        for cell in cells:
            if not 0 <= cell < size:
                self._tell(
                    f"key {cell + base:#x} that was sent to population '{label}' is not that of a cell; they "
                    f"are {base:#x} to {base + size - 1:#x}"
                )
        return [cell for cell in cells if 0 <= cell < size]

    def _tell(self, text: str) -> None:
        if text not in self._refused:
            self._refused.add(text)
            _logger.warning("%s", text)


def _bound(label: str, port: int) -> socket.socket:
    """Return a socket that receives on this machine only, without waiting."""
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.setblocking(False)
    try:
        made.bind(("127.0.0.1", port))
    except OSError as error:
        made.close()
        raise NetworkError(
            f"population '{label}' cannot receive spikes at UDP port {port}: {error.strerror}; choose another"
        ) from error
    return made


def _address(label: str, output: LiveOutput) -> str:
    if output.kind in (KEY_16_BIT, KEY_PAYLOAD_16_BIT):
        raise NetworkError(
            f"live output of '{label}': keys of 16 bits are not sent; message_type may be KEY_32_BIT or "
            "KEY_PAYLOAD_32_BIT"
        )
    try:
        return socket.gethostbyname(output.host)
    except OSError as error:
        raise NetworkError(
            f"live output of '{label}': the host '{output.host}' has no address: {error.strerror}"
        ) from error
