"""``os._exit`` in the code of users, which would end the program without a word."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn


@contextmanager
def noticed_exits() -> Iterator[None]:
    """Let ``os._exit`` raise SystemExit within the block, in this thread and this process.

    A process that the block forks, as ``multiprocessing`` does, still ends by it.
    """
    leave, own = os._exit, (os.getpid(), threading.get_ident())

    def refuse(status: int) -> NoReturn:
        if (os.getpid(), threading.get_ident()) != own:
            leave(status)
        raise SystemExit(f"os._exit({status}) would end the whole program")

    os._exit = refuse
    try:
        yield
    finally:
        os._exit = leave
