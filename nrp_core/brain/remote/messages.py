"""Messages between the two ends, which take turns.

A step of the loop is a few numbers through a socket, and columns in shared memory; any other request, answer
or error is a pickled object through the socket.
"""

from __future__ import annotations

import mmap
import os
import pickle
import socket
import struct
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.network.data import RECEPTORS

_BYTES: Final = 8
"""Size of each number, an integer or a float."""
_FIRST_SIZE: Final = 1 << 16


class SharedColumns:
    """Memory for the columns of one message; it grows when a message needs more.

    The two sides take turns: each reads the other's columns before it writes its own.

    Args:
        descriptor: of an open memory file, which this object then owns; None for a new one.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        number = os.memfd_create("nrp-core") if descriptor is None else descriptor
        self._file = os.fdopen(number, "r+b", buffering=0)
        self._integers: IntArray = np.empty(0, np.int64)
        self._floats: npt.NDArray[np.float64] = np.empty(0)

    @property
    def descriptor(self) -> int:
        """The file descriptor."""
        return self._file.fileno()

    def write(self, columns: Sequence[npt.NDArray[Any]]) -> int:
        """Write columns in sequence; return the number of values."""
        total = sum(map(len, columns))
        self._reach(total)
        at = 0
        for column in columns:
            numbers = self._floats if column.dtype.kind == "f" else self._integers
            numbers[at : at + len(column)] = column
            at += len(column)
        return total

    def read(self, total: int) -> IntArray:
        """Return a copy of the written values as integers; view floats in it as another type."""
        self._reach(total)
        return self._integers[:total].copy()

    def close(self) -> None:
        """Release the memory."""
        self._integers, self._floats = np.empty(0, np.int64), np.empty(0)
        self._file.close()

    def _reach(self, total: int) -> None:
        """Make room for this number of values; called by the writing side."""
        if total <= len(self._integers):
            return
        size = os.fstat(self.descriptor).st_size
        if size < total * _BYTES:
            size = max(_FIRST_SIZE, 1 << (total * _BYTES - 1).bit_length())
            os.ftruncate(self.descriptor, size)
        memory = mmap.mmap(self.descriptor, size)
        self._integers, self._floats = np.frombuffer(memory, np.int64), np.frombuffer(memory)


_BELL: Final = struct.Struct("<7q")
"""Header of every message: 0 and the length of a pickle, or 1 and the numbers of a step."""
_OBJECT: Final = 0
_STEP: Final = 1
_NUMBERS: Final = 6
_PART: Final = 1 << 20

Numbers = tuple[int, ...]


class Label(NamedTuple):
    """A projection as an argument of a request: the other process has it in its network.

    Args:
        label: its label.
    """

    label: str


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


class Inputs:
    """The inputs of a brain for its next step."""

    def __init__(self) -> None:
        self._fired: list[tuple[IntArray, FloatArray]] = []
        self._events: dict[str, list[SynapticEvents]] = {receptor: [] for receptor in RECEPTORS}
        self._currents_na: list[FloatArray] = []

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Add spikes of source cells."""
        self._fired.append((neurons, times_ms))

    def inject(self, events: SynapticEvents) -> None:
        """Add synaptic events."""
        self._events[events.receptor].append(events)

    def set_current(self, currents_na: FloatArray) -> None:
        """Set the currents; only the last ones are used."""
        self._currents_na = [currents_na]

    def write(self, memory: SharedColumns) -> Numbers:
        """Write everything; return the numbers of spikes, of events at each receptor, and of currents."""
        columns = [*(neurons for neurons, _ in self._fired), *(times_ms for _, times_ms in self._fired)]
        counts = [sum(map(len, columns)) // 2]
        for events in self._events.values():
            for name in ("neurons", "times_ms", "weights"):
                columns += [getattr(one, name) for one in events]
            counts.append(sum(map(len, events)))
        columns += self._currents_na
        counts.append(sum(map(len, self._currents_na)))
        memory.write(columns)
        return tuple(counts)


def carry_out(brain: Brain, memory: SharedColumns, counts: Numbers) -> None:
    """Pass the inputs written by :meth:`Inputs.write` to a brain."""
    n_fired, *n_events, n_currents = counts
    column = _Cutter(memory.read(2 * n_fired + 3 * sum(n_events) + n_currents))
    if n_fired:
        brain._do_fire(column.integers(n_fired), column.floats(n_fired))
    for receptor, n in zip(RECEPTORS, n_events, strict=True):
        if n:
            events = SynapticEvents(column.integers(n), column.floats(n), column.floats(n), receptor)
            brain._do_inject(events)
    if n_currents:
        brain._do_set_current(column.floats(n_currents))


def write_spikes(memory: SharedColumns, spikes: Spikes) -> int:
    """Write spikes and return their number."""
    memory.write([spikes.neurons, spikes.times_ms])
    return len(spikes)


def read_spikes(memory: SharedColumns, n: int) -> Spikes:
    """Return the spikes written by :func:`write_spikes`."""
    column = _Cutter(memory.read(2 * n))
    return Spikes(column.integers(n), column.floats(n))


class _Cutter:
    """Splits a block of numbers into consecutive columns."""

    def __init__(self, block: IntArray) -> None:
        self._block, self._at = block, 0

    def integers(self, n: int) -> IntArray:
        column = self._block[self._at : self._at + n]
        self._at += n
        return column

    def floats(self, n: int) -> FloatArray:
        return self.integers(n).view(np.float64)
