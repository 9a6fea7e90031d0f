"""Messages between the two ends: any object that pickles.

A connection's own ``send`` makes a pickler that can share what processes share; nothing here needs it, and a
message a step is worth the time.
"""

from __future__ import annotations

import pickle
from multiprocessing.connection import Connection
from typing import Any


def send(connection: Connection, message: object) -> None:
    """Send one message."""
    connection.send_bytes(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))


def receive(connection: Connection) -> Any:
    """Wait for one message.

    Raises:
        EOFError: the other end is closed.
    """
    return pickle.loads(connection.recv_bytes())
