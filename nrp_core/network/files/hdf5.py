"""Opens and reads HDF5 files; every failure becomes a single error that names the file."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nrp_core.errors import ExperimentError, NetworkError, NrpError, did_you_mean
from nrp_core.network.memory import require_memory

if TYPE_CHECKING:
    import h5py

_HEAP_SIGNATURE = b"GCOL\x01\x00\x00\x00"
_HEAD = struct.Struct("<8sQ")
_OBJECT = struct.Struct("<H6xQ")
_FREE = 0


def has_damaged_heap(path: Path) -> bool:
    """Return whether the objects of a heap, which holds strings, do not fill it; h5py does not check it."""
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        place = data.find(_HEAP_SIGNATURE)
        while place >= 0:
            if not _is_sound(data, place):
                return True
            place = data.find(_HEAP_SIGNATURE, place + _HEAD.size)
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


_LARGEST_ID = np.iinfo(np.int64).max
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


@contextmanager
def reading(path: Path) -> Iterator[h5py.File]:
    """Open a file for a ``with`` block; errors in the block name the file.

    Raises:
        NetworkError: the file is missing, truncated, damaged, or not HDF5.
    """
    import h5py

    _require_signature(path)
    if has_damaged_heap(path):
        raise NetworkError("the file is damaged; make or copy it again", path=path)
    try:
        with h5py.File(path, "r") as file:
            yield file
    except NrpError as error:
        if isinstance(error, ExperimentError):
            error.path = error.path or path
        raise
    except (OSError, RuntimeError, KeyError) as error:  # h5py raises all three for damaged files
        reason = error.args[0] if error.args else error
        raise NetworkError(
            f"the file is cut short or damaged; make or copy it again ({reason})", path=path
        ) from error


def _require_signature(path: Path) -> None:
    """Check the first bytes; opening the file in Python also includes it in a recording of the run."""
    try:
        with path.open("rb") as file:
            begins = file.read(len(_SIGNATURE))
    except FileNotFoundError:
        raise NetworkError("there is no such file", path=path) from None
    except OSError as error:
        raise NetworkError(f"cannot be read: {error.strerror}", path=path) from error
    if begins != _SIGNATURE:
        raise NetworkError("this is not an HDF5 file", path=path)


def group(parent: Any, name: str) -> h5py.Group:
    """Return a group in a group.

    Raises:
        NetworkError: the group does not exist; the message names the nearest.
    """
    import h5py

    return _member(parent, name, h5py.Group, "group")


def groups(parent: Any) -> list[tuple[str, h5py.Group]]:
    """Return the subgroups of a group with their names.

    Raises:
        NetworkError: a member is not a group, or is damaged.
    """
    return [(name, group(parent, name)) for name in parent]


def _member(parent: Any, name: str, kind: type, what: str) -> Any:
    if name not in parent or not isinstance(found := parent[name], kind):  # h5py's get() hides damage
        raise NetworkError(f"the group '{parent.name}' has no {what} '{name}'{did_you_mean(name, parent)}")
    return found


def array(parent: Any, name: str, dtype: type | None = None) -> np.ndarray[Any, Any]:
    """Return a complete dataset of a group.

    Raises:
        NetworkError: it does not exist, does not fit into memory, or has values of another type.
    """
    import h5py

    found = _member(parent, name, h5py.Dataset, "dataset")
    require_memory(f"the dataset '{found.name}'", 8 * found.size, f"its {found.size} values")
    values = np.asarray(found[()])
    if dtype is None:
        return values
    if values.dtype.kind not in "iuf" or (dtype is not float and values.dtype.kind == "f"):
        raise NetworkError(
            f"the dataset '{found.name}' holds {values.dtype}, not numbers of kind {dtype.__name__}"
        )
    if values.dtype == np.uint64 and dtype is not float and values.max(initial=0) > _LARGEST_ID:
        raise NetworkError(
            f"the dataset '{found.name}' holds {values.max()}; a number in it can be at most {_LARGEST_ID}"
        )
    return values.astype(dtype, copy=False)


def column(parent: Any, name: str, dtype: type) -> np.ndarray[Any, Any]:
    """Return a dataset of a group that holds one number for each item, shape ``(n,)``.

    Raises:
        NetworkError: as :func:`array`, or it has another number of dimensions.
    """
    values = array(parent, name, dtype)
    if values.ndim != 1:
        shape = "one number" if not values.ndim else f"the shape {values.shape}"
        raise NetworkError(f"the dataset '{parent.name}/{name}' has {shape}; it must be a list of numbers")
    return values


def attribute(parent: Any, name: str, kind: type) -> Any:
    """Return an attribute of a group, as ``int``, ``float`` or ``str``.

    Raises:
        NetworkError: it does not exist, or is of another type.
    """
    value = parent.attrs.get(name)
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    try:
        if value is None or (kind is not str and isinstance(value, str)):
            raise ValueError
        return kind(value)
    except (TypeError, ValueError):
        raise NetworkError(
            f"the group '{parent.name}' has no attribute '{name}' of kind {kind.__name__}"
        ) from None
