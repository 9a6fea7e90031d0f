"""The process of a brain: ``python -m nrp_core.brain.remote FD``, with the number of an open socket."""

import signal
import sys
from multiprocessing.connection import Connection

from nrp_core.brain.remote.server import serve

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the near end decides when to stop
    serve(Connection(int(sys.argv[1])))
