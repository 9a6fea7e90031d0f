"""Entry points of installed distributions, read as metadata; the last state read is kept."""

from __future__ import annotations

import importlib.metadata
import os
import re
import sys
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, EntryPoints

State = tuple[tuple[str, int], ...]
"""The folders of ``sys.path`` and the times of the last installation or removal there, ns."""


def installed() -> State:
    """Return what the entry points depend on, as a key of caches."""
    state = []
    for entry in sys.path:
        with suppress(OSError):  # a folder that is not there, as Python allows
            state.append((entry, os.stat(entry or os.curdir).st_mtime_ns))  # noqa: PTH116  this runs often
    return tuple(state)


def entries(group: str) -> list[EntryPoint]:
    """Return the entry points of a group; of two distributions of one name the first on the path counts."""
    found: dict[str, list[EntryPoint]] = {}
    for folder, changed_ns in installed():
        for distribution, every in _read(folder, changed_ns):
            if of_group := list(every.select(group=group)):
                found.setdefault(_normalized_name(distribution), of_group)
    return [entry for some in found.values() for entry in some]


@lru_cache(maxsize=64)
def _read(folder: str, _changed_ns: int) -> list[tuple[Distribution, EntryPoints]]:
    """Return the distributions in a folder that have entry points."""
    every = ((one, one.entry_points) for one in importlib.metadata.distributions(path=[folder]))
    return [(distribution, entries) for distribution, entries in every if entries]


@lru_cache(maxsize=64)
def _normalized_name(distribution: Distribution) -> str:
    return re.sub(r"[-_.]+", "_", distribution.name).lower()
