"""Entry points of installed distributions, read as metadata; the last state read is kept."""

from __future__ import annotations

import importlib.metadata
import os
import sys
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import EntryPoints
from typing import Any

State = tuple[tuple[str, int], ...]
"""The folders of ``sys.path`` and the times of the last installation or removal there, ns."""


def installed() -> State:
    """Return what the entry points depend on, as a key of caches."""
    state = []
    for entry in sys.path:
        with suppress(OSError):  # a folder that is not there, as Python allows
            state.append((entry, os.stat(entry or os.curdir).st_mtime_ns))  # noqa: PTH116  this runs often
    return tuple(state)


def entries(group: str) -> EntryPoints:
    """Return the entry points of a group; the metadata is read once for all groups."""
    found: EntryPoints = _read(installed()).select(group=group)
    return found


@lru_cache(maxsize=1)
def _read(_state: State) -> Any:
    return importlib.metadata.entry_points()
