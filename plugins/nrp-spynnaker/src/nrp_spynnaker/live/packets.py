"""Live spikes over UDP: from other programs to injectors, and from populations to other programs.

The packets are those of EIEIO, the protocol of SpiNNaker machines.
"""

from __future__ import annotations

import logging
import socket
import struct
from collections.abc import Iterator, Sequence
from math import ceil
from typing import Final

from nrp_core.errors import NetworkError
from nrp_spynnaker.dialect.connections import Hub, LiveOutput
from nrp_spynnaker.live.programs import Programs

KEY_16_BIT, KEY_PAYLOAD_16_BIT, KEY_32_BIT, KEY_PAYLOAD_32_BIT = range(4)
"""The types of packets."""
_HAS_PREFIX, _UPPER, _HAS_BASE, _IS_TIME = 1 << 7, 1 << 6, 1 << 5, 1 << 4
_TYPE_SHIFT: Final = 2
_LARGEST: Final = 256
"""Bytes in a packet that a machine takes."""


def packets(keys: Sequence[int], time: int, kind: int = KEY_32_BIT) -> Iterator[bytes]:
    """Yield the packets with the spikes of a time step.

    Args:
        keys: a key for each spike, of 32 bits.
        time: the number of the step.
        kind: ``KEY_32_BIT``, with one time for all keys, or ``KEY_PAYLOAD_32_BIT``, with a time for each.
    """
    flags = _IS_TIME | kind << _TYPE_SHIFT
    if kind == KEY_32_BIT:
        head, each = struct.Struct("<BBI"), 4
        flags |= _HAS_BASE
    else:
        head, each = struct.Struct("<BB"), 8
    most = (_LARGEST - head.size) // each
    for first in range(0, len(keys), most):
        some = keys[first : first + most]
        if kind == KEY_32_BIT:
            yield head.pack(len(some), flags, time) + struct.pack(f"<{len(some)}I", *some)
        else:
            pairs = [number for key in some for number in (key, time)]
            yield head.pack(len(some), flags) + struct.pack(f"<{len(pairs)}I", *pairs)


def keys_of(packet: bytes, upper: int = 0) -> list[int]:
    """Return the keys in a packet.

    Args:
        packet: its bytes.
        upper: the upper 16 bits of keys of 16 bits without a prefix.

    Raises:
        ValueError: it is not a packet of spikes, or is shorter than its header states.
    """
    if len(packet) < 2:
        raise ValueError(f"it has {len(packet)} bytes; there must be a count and flags")
    count, flags = packet[0], packet[1]
    if flags & _UPPER and not flags & _HAS_PREFIX:
        raise ValueError("it is a command, not spikes")
    kind = flags >> _TYPE_SHIFT & 3
    wide, has_payloads = (
        kind in (KEY_32_BIT, KEY_PAYLOAD_32_BIT),
        kind in (KEY_PAYLOAD_16_BIT, KEY_PAYLOAD_32_BIT),
    )
    size, at, prefix = (4 if wide else 2), 2, 0 if wide else upper << 16
    if flags & _HAS_PREFIX:
        if len(packet) < at + 2:
            raise ValueError("it ends before its prefix")
        prefix = int.from_bytes(packet[at : at + 2], "little") << (16 if flags & _UPPER else 0)
        at += 2
    at += size if flags & _HAS_BASE else 0
    stride = size * (2 if has_payloads else 1)
    if len(packet) < at + count * stride:
        raise ValueError(f"it says that it has {count} keys, and has {max(0, len(packet) - at) // stride}")
    starts = range(at, at + count * stride, stride)
    return [int.from_bytes(packet[start : start + size], "little") | prefix for start in starts]


_logger = logging.getLogger(__name__)
_LARGEST_READ: Final = 65536
_KEYS_OF_A_POPULATION: Final = 1 << 16
"""Populations with live output have multiples of so many keys, in the order in which they have it."""


class Sockets:
    """The sockets of the live connections of a script.

    Args:
        hub: the connections, which name ports.

    Raises:
        NetworkError: a port is in use, a host has no address, a kind of packet is not sent, or populations
            have a key in common.
    """

    def __init__(self, hub: Hub) -> None:
        self._inputs: list[tuple[str, socket.socket]] = []
        self._outputs: dict[str, tuple[LiveOutput, tuple[str, int]]] = {}
        self._keys = _keys_of(hub)
        self._programs: Programs | None = None
        self._sender: socket.socket | None = None
        self._refused: set[str] = set()
        try:
            for label, given in hub.inputs.items():
                self._inputs.append((label, _bound(label, given.port)))
            for label, output in hub.outputs.items():
                self._outputs[label] = output, (_address(label, output), output.port)
            if self._outputs:
                self._sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            if hub.ports:
                self._programs = Programs(hub.ports, self._keys, list(hub.live_outputs), list(hub.injectors))
        except BaseException:
            self.close()
            raise

    @property
    def listens(self) -> bool:
        """Whether other programs may send spikes, so that the network keeps to the real time."""
        return bool(self._inputs) or self.has_programs

    @property
    def has_programs(self) -> bool:
        """Whether other programs take part in the run that has begun."""
        return self._programs is not None and self._programs.are_there

    def begin(self, timestep_ms: float, run_time_ms: float) -> None:
        """Tell other programs that a run begins, as :meth:`Programs.begin`."""
        if self._programs is not None:
            self._programs.begin(timestep_ms, run_time_ms)

    def end(self) -> None:
        """Tell other programs that the run has stopped."""
        if self._programs is not None:
            self._programs.end()

    def received(self) -> list[tuple[str, list[int]]]:
        """Return the spikes that have arrived: labels of injectors, and cells.

        Invalid packets, and keys that belong to no cell, are reported once for each population.
        """
        arrived = list(self._programs.packets()) if self._programs is not None else []
        for label, bound in self._inputs:
            while True:
                try:
                    arrived.append((label, bound.recv(_LARGEST_READ)))
                except BlockingIOError:
                    break
        found = [(label, self._cells(label, packet)) for label, packet in arrived]
        return [(label, cells) for label, cells in found if cells]

    def send(self, label: str, time: int, cells: Sequence[int]) -> None:
        """Send the spikes of a step to the targets of a population's live output."""
        if not cells:
            return
        keys = [self._keys[label].start + cell for cell in cells]
        if self._programs is not None and self._programs.are_there:
            for packet in packets(keys, time):
                self._programs.send(packet)
        if label in self._outputs:
            output, address = self._outputs[label]
            assert self._sender is not None
            for packet in packets(keys, time, output.kind):
                self._sender.sendto(packet, address)

    def close(self) -> None:
        """Close all sockets."""
        for _, bound in self._inputs:
            bound.close()
        if self._programs is not None:
            self._programs.close()
        if self._sender is not None:
            self._sender.close()
        self._inputs, self._outputs, self._sender, self._programs = [], {}, None, None

    def _cells(self, label: str, packet: bytes) -> list[int]:
        base, size = self._keys[label].start, len(self._keys[label])
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


def _keys_of(hub: Hub) -> dict[str, range]:
    """Return the keys of the cells of all populations with live output, and of injectors."""
    keys: dict[str, range] = {}
    free = 0
    for label, population in {**hub.live_outputs, **hub.injectors}.items():
        size = int(population.size)
        first = hub.inputs[label].key if label in hub.inputs else free
        free += ceil(size / _KEYS_OF_A_POPULATION) * _KEYS_OF_A_POPULATION
        keys[label] = range(first, first + size)
        for other in hub.live_outputs if label in hub.live_outputs else ():
            both = keys.get(other, range(0))
            if other != label and max(first, both.start) < min(keys[label].stop, both.stop):
                raise NetworkError(
                    f"live output of '{label}' and '{other}' has a key in common, "
                    f"{max(first, both.start):#x}; give the injector another virtual_key"
                )
    return keys


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
