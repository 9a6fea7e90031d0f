"""An MPI job in place of the process of a brain.

:func:`program_for` makes a program that is called as the interpreter of that process, with the arguments
``FAR_END SOCKET MEMORY VERSION MODULE``. The program becomes ``mpirun``. The first process of the job gets
the descriptors of the connection through a socket of the file system, because ``mpirun`` passes none on.
"""

from __future__ import annotations

import atexit
import os
import shlex
import shutil
import signal
import socket
import sys
import tempfile
from functools import cache
from pathlib import Path

_OPTIONS = {  # of Open MPI; others ignore them
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_mpi_yield_when_idle": "1",  # the cores that wait belong to the world
}
_AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
_CHECK_S = 0.5


@cache
def program_for(python: str, processes: int) -> str:
    """Return the path of a program that takes the place of an interpreter and starts a job of processes."""
    folder = Path(tempfile.mkdtemp(prefix="nrp-mpi-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    program = folder / f"python-in-{processes}-processes"
    program.write_text(f'#!/bin/sh\nexec {shlex.join([python, __file__, str(processes)])} "$@"\n')
    program.chmod(0o700)
    return str(program)


def main(processes: str, connection: int, memory: int, version: str, module: str) -> None:
    """Become ``mpirun``; a child waits to hand the descriptors over."""
    os.setpgid(0, 0)  # Ctrl-C is for the near end, which decides when to stop
    mpirun = shutil.which("mpirun")
    if mpirun is None:
        reason = (
            "several processes need mpirun, which is not installed: apt install openmpi-bin libopenmpi-dev"
        )
        socket.socket(fileno=connection).sendall(f"{reason}\n".encode())
        return
    folder = tempfile.mkdtemp(prefix="nrp-mpi-")
    path = f"{folder}/socket"
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(path)
    listener.listen()
    parent = os.getpid()
    if os.fork() == 0:
        try:
            _hand_over(listener, parent, [connection, memory])
        finally:
            shutil.rmtree(folder, ignore_errors=True)
            os._exit(0)
    os.closerange(3, max(connection, memory, listener.fileno()) + 1)
    job = [mpirun, "-n", processes, sys.executable, "-P", "-m", "nrp_brain_pynn.rank", path, version, module]
    root = _AS_ROOT if os.geteuid() == 0 else {}
    os.execve(mpirun, job, os.environ | _OPTIONS | root)


def _hand_over(listener: socket.socket, parent: int, descriptors: list[int]) -> None:
    """Send descriptors to the first process, unless the job ends before it asks for them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    listener.settimeout(_CHECK_S)
    while os.getppid() == parent:
        try:
            first, _ = listener.accept()
        except TimeoutError:
            continue
        socket.send_fds(first, [b"\0"], descriptors)
        return


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[3]), int(sys.argv[4]), *sys.argv[5:])
