"""A process that performs tasks for :mod:`nrp_core._support.worker_pool`; it ends with its parent."""

from __future__ import annotations

import os
import select
import signal
import sys
from multiprocessing.connection import Connection
from pickle import PicklingError
from threading import Thread
from typing import Any


def serve(descriptor: int) -> None:
    """Perform the tasks that arrive on a socket until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends Ctrl-C to all processes
    Thread(target=_end_with_parent, args=(descriptor,), daemon=True).start()
    parent: Connection[Any, Any] = Connection(descriptor)
    if (path := parent.recv()) is not None:
        sys.path[:] = path
    while True:
        try:
            function, task = parent.recv()
        except EOFError:
            return
        except Exception as error:  # noqa: BLE001  of whatever cannot be imported here
            _send(parent, None, error)
            continue
        try:
            _send(parent, function(task), None)
        except BaseException as error:  # noqa: BLE001  the parent decides what it means
            _send(parent, None, error)


def _send(parent: Connection[Any, Any], value: Any, error: BaseException | None) -> None:
    try:
        parent.send((value, error))
    except (PicklingError, TypeError, AttributeError) as problem:
        parent.send((None, RuntimeError(f"{error or value!r} ({problem})")))


def _end_with_parent(descriptor: int) -> None:
    """End this process, also within a task, when the other end of the socket is closed."""
    watch = select.poll()
    watch.register(descriptor, 0)  # only POLLHUP and POLLERR, which are always reported
    watch.poll()
    os._exit(1)


if __name__ == "__main__":
    serve(int(sys.argv[1]))
