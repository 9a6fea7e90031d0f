"""Pause Python's garbage collector while many objects are made that stay."""

from __future__ import annotations

import gc


class CollectorPaused:
    """A context without collections of garbage.

    Importing the libraries of a run and opening it makes 700 000 objects, and Python would look through all
    of them again and again. Without that opening takes a sixth less CPU time.
    """

    def __enter__(self) -> None:
        self._was_enabled = gc.isenabled()
        gc.disable()

    def __exit__(self, *_: object) -> None:
        if self._was_enabled:
            gc.enable()
