"""Finds damage in the heaps of an HDF5 file, which hold its strings, before the library reads them.

In a heap with free space of size 0, libhdf5 2.0 searches for the next object
forever. The layout follows the format's specification, version 3, III.E "Global Heap".
"""

from __future__ import annotations

import mmap
import struct
from pathlib import Path

_SIGNATURE = b"GCOL\x01\x00\x00\x00"
_HEAD = struct.Struct("<8sQ")
_OBJECT = struct.Struct("<H6xQ")
_FREE = 0


def has_damaged_heap(path: Path) -> bool:
    """Return whether the consecutive objects of any heap do not fill it."""
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        place = data.find(_SIGNATURE)
        while place >= 0:
            if not _is_sound(data, place):
                return True
            place = data.find(_SIGNATURE, place + _HEAD.size)
    return False


def _is_sound(data: mmap.mmap, start: int) -> bool:
    if start + _HEAD.size > len(data):
        return False
    end: int = start + _HEAD.unpack_from(data, start)[1]
    place: int = start + _HEAD.size
    if not place <= end <= len(data):
        return False
    while place + _OBJECT.size <= end:
        index, size = _OBJECT.unpack_from(data, place)
        step = size if index == _FREE else _OBJECT.size + -(-size // 8) * 8
        if step == 0:
            return False
        place += step
    return place <= end
