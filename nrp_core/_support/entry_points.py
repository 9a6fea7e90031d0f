"""Entry points of installed distributions, read as metadata; the last state read is kept."""

from __future__ import annotations

import importlib.metadata
import sys
from functools import lru_cache
from importlib.metadata import EntryPoints
from pathlib import Path
from typing import Any


def entries(group: str) -> EntryPoints:
    """Return the entry points of a group; the metadata is read once for all groups."""
    folders = (Path(entry) for entry in sys.path)
    state = tuple((str(one), one.stat().st_mtime_ns) for one in folders if one.is_dir())
    found: EntryPoints = _installed(state).select(group=group)
    return found


@lru_cache(maxsize=1)
def _installed(_state: tuple[tuple[str, int], ...]) -> Any:
    """Return all entry points.

    Args:
        _state: the folders of ``sys.path`` and the times of the last installation or removal there.
    """
    return importlib.metadata.entry_points()
