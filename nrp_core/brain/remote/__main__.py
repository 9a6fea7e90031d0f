"""The process of a brain: ``python -m nrp_core.brain.remote SOCKET MEMORY``, by numbers of open files."""

import signal
import socket
import sys

from nrp_core.brain.remote.columns import SharedColumns
from nrp_core.brain.remote.messages import Channel
from nrp_core.brain.remote.server import serve

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the near end decides when to stop
    connection, memory = map(int, sys.argv[1:])
    serve(Channel(socket.socket(fileno=connection), SharedColumns(memory)))
