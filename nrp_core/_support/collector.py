"""Pause Python's garbage collector during the creation of many lasting objects."""

from __future__ import annotations

import gc
import sys


class CollectorPaused:
    """A context without collections of garbage.

    Importing the libraries of a run and opening it makes 700 000 objects, and Python would look through all
    of them again and again. After a section that imported modules its objects count as old, so that only a
    full collection looks through them.
    """

    def __enter__(self) -> None:
        self._was_enabled = gc.isenabled()
        self._modules = len(sys.modules)
        gc.disable()

    def __exit__(self, *_: object) -> None:
        if not self._was_enabled:
            return
        if len(sys.modules) > self._modules and gc.get_freeze_count() == 0:  # a fork keeps what it has frozen
            gc.freeze()
            gc.unfreeze()  # into the oldest generation
        gc.enable()
