"""A process of an MPI job: ``python -m nrp_brain_pynn.rank SOCKET VERSION MODULE``.

All processes carry out the same requests. The first one talks with the loop, and passes each request on.
"""

from __future__ import annotations

import ctypes
import signal
import socket
import sys
from importlib import import_module
from importlib.metadata import version
from typing import Any, Final

from neuron import h

h.nrnmpi_init()  # before anything else starts to use NEURON

from nrp_core.brain.remote.messages import Channel, Numbers, SharedColumns  # noqa: E402
from nrp_core.brain.remote.server import serve  # noqa: E402

_PR_SET_PDEATHSIG: Final = 1
"""The request that a process ends with its parent, ``mpirun``, see prctl(2)."""


class FirstChannel(Channel):
    """The connection with the loop.

    Args:
        parallel: NEURON's access to the processes.
        connection: to the loop.
        columns: the memory that is shared with it.
    """

    def __init__(self, parallel: Any, connection: socket.socket, columns: SharedColumns) -> None:
        super().__init__(connection, columns)
        self._parallel = parallel

    def receive(self) -> tuple[Any, Numbers]:
        try:
            message, numbers = super().receive()
        except (EOFError, ConnectionError):
            self._parallel.py_broadcast(None, 0)
            raise
        block = None if message is not None else self.columns.read(_values_in(numbers))
        self._parallel.py_broadcast((message, numbers, block), 0)
        return message, numbers


class OtherChannel(Channel):
    """The requests that the first process passes on; it alone answers them.

    Args:
        parallel: NEURON's access to the processes.
    """

    def __init__(self, parallel: Any) -> None:
        self._parallel, self.columns = parallel, SharedColumns()

    def receive(self) -> tuple[Any, Numbers]:
        found = self._parallel.py_broadcast(None, 0)
        if found is None:
            raise EOFError
        message, numbers, block = found
        if block is not None:
            self.columns.write([block])
        return message, numbers

    def send(self, message: object) -> None:
        """Send nothing."""

    def send_step(self, *numbers: int) -> None:
        """Send nothing."""


def _values_in(numbers: Numbers) -> int:
    """Return how many values belong to a step: spikes have two, events three."""
    _, _, n_fired, *n_events, n_currents = numbers
    return 2 * n_fired + 3 * sum(n_events) + n_currents


def _connect(path: str) -> tuple[socket.socket, SharedColumns]:
    """Return the connection with the loop, and the memory that is shared with it."""
    with socket.socket(socket.AF_UNIX) as there:
        there.connect(path)
        _, (connection, memory), *_ = socket.recv_fds(there, 1, 2)
    return socket.socket(fileno=connection), SharedColumns(memory)


def main(path: str, wanted: str, module: str) -> None:
    """Carry out requests until the loop ends.

    Args:
        path: of the socket at which the first process gets the connection.
        wanted: the version of nrp-core at the other end.
        module: the module of the backend.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the other end decides when to stop
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    parallel = h.ParallelContext()
    import_module(module)
    found = version("nrp-core")
    channel: Channel = OtherChannel(parallel)
    if int(parallel.id()) == 0:
        near, columns = _connect(path)
        near.sendall(b"\n" if found == wanted else f"ImportError: it has nrp-core {found}\n".encode())
        channel = FirstChannel(parallel, near, columns)
    serve(channel)
    parallel.barrier()
    h.quit()  # ends MPI, too


if __name__ == "__main__":
    main(*sys.argv[1:])
