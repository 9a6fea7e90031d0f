"""The script of a brain's process: ``python far_end.py SOCKET MEMORY VERSION MODULE``.

The named Python runs the near end's copy of this file, so the script can report missing requirements of
that Python: the first line that it sends, before any message, is the reason why it cannot start, or empty
if it can.
"""

import signal
import socket
import sys
from importlib import import_module
from importlib.metadata import version
from pathlib import Path


def main(connection: int, memory: int, wanted: str, module: str) -> None:
    """Answer requests.

    Args:
        connection: file descriptor of an open socket.
        memory: file descriptor of an open file.
        wanted: the near end's version of nrp-core.
        module: the module of the backend.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the near end decides when to stop
    sys.path[:] = [entry for entry in sys.path if entry != str(Path(__file__).parent)]
    near = socket.socket(fileno=connection)
    try:
        found = version("nrp-core")
        if found != wanted:
            raise ImportError(f"it has nrp-core {found}")
        from nrp_core.brain.remote.messages import Channel, SharedColumns
        from nrp_core.brain.remote.server import serve

        import_module(module)
    except Exception as error:  # noqa: BLE001  whatever it is, the other side raises it
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        near.sendall(f"{reason}\n".encode())
        return
    near.sendall(b"\n")
    serve(Channel(near, SharedColumns(memory)))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:])
