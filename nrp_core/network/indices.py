"""Indices of cells, one for each synapse, in compact form.

Connectors make synapses target by target, so the indices at one end of a projection ascend: then only the
start of each cell's synapses is stored. The other end takes two bytes where there are at most 65536 cells.
Readers get arrays of 32-bit integers; those of large projections are created for each read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import IndexArray
from nrp_core.errors import NetworkError

T = TypeVar("T")

Change = Callable[[Any], Any]


def stored(*names: str, store: Change, read: Change) -> Callable[[type[T]], type[T]]:
    """Make a class store attributes in another form.

    Args:
        names: the attributes.
        store: returns the stored form of a value that is set.
        read: returns the array of a stored form.
    """

    def decorate(owner: type[T]) -> type[T]:
        for name in names:
            setattr(owner, name, _Stored(name, store, read))
        return owner

    return decorate


def stored_form(owner: object, name: str) -> Any:
    """Return the stored form of an attribute."""
    return vars(owner)[name]


class _Stored:
    def __init__(self, name: str, store: Change, read: Change) -> None:
        self._name, self._store, self._read = name, store, read

    def __get__(self, owner: object | None, kind: type) -> Any:
        return self if owner is None else self._read(stored_form(owner, self._name))

    def __set__(self, owner: object, value: Any) -> None:
        vars(owner)[self._name] = self._store(value)


_FEW: Final = 1 << 16
"""Up to this number, indices are not compressed."""
_PART: Final = 1 << 17


@dataclass(frozen=True, slots=True)
class Indices:
    """Immutable indices.

    Args:
        values: one index for each synapse; or, if they ascend, the start of each cell's synapses, shape
            ``(highest + 2,)``, where the last is the number of synapses.
        ascending: whether ``values`` holds these starts.
    """

    values: npt.NDArray[Any]
    ascending: bool = False

    @staticmethod
    def of(values: npt.ArrayLike) -> Indices:
        """Return indices in their smallest form."""
        array = np.asarray(values)
        if array.ndim != 1 or (array.dtype.kind not in "iu" and not _are_whole(array)):
            raise NetworkError(f"indices of cells are whole numbers, not {array.ravel()[:3]}")
        if len(array) < _FEW:
            return Indices(np.asarray(array, np.int32))
        plain = Indices(array)
        lowest, highest = plain.bounds()
        if lowest >= 0 and 8 * (highest + 2) < len(array) and plain._ascends():
            begins = np.searchsorted(
                array, np.arange(highest + 1, dtype=array.dtype)
            )  # mixed types would make a copy
            return Indices(np.append(begins, len(array)), ascending=True)
        return Indices(array.astype(index_type(highest + 1) if lowest >= 0 else np.int32, copy=False))

    @staticmethod
    def repeated(cells: npt.ArrayLike, counts: npt.ArrayLike) -> Indices:
        """Return ascending indices of cells, each repeated by its count."""
        cells, counts = np.asarray(cells, np.int64), np.asarray(counts, np.int64)
        if counts.sum() < _FEW:
            return Indices(np.repeat(cells.astype(np.int32), counts))
        each = np.zeros(int(cells[-1]) + 1, np.int64)
        each[cells] = counts
        return Indices(np.append(0, np.cumsum(each)), ascending=True)

    def __len__(self) -> int:
        return int(self.values[-1]) if self.ascending else len(self.values)

    def bounds(self) -> tuple[int, int]:
        """Return the lowest and the highest index, or (0, -1) without indices."""
        if self.ascending:
            used = np.flatnonzero(np.diff(self.values))
            return int(used[0]), int(used[-1])
        lows_highs = [(int(part.min()), int(part.max())) for part in self.parts()]
        return min((low for low, _ in lows_highs), default=0), max(
            (high for _, high in lows_highs), default=-1
        )

    def part(self, first: int, last: int) -> IndexArray:
        """Return the indices of consecutive synapses."""
        if not self.ascending:
            return self.values[first:last].astype(np.int32, copy=False)
        low, high = np.searchsorted(self.values, (first, last - 1), "right")
        counts = np.diff(np.clip(self.values[low - 1 : high + 1], first, last))
        return np.repeat(np.arange(low - 1, high, dtype=np.int32), counts)

    def parts(self) -> Iterator[IndexArray]:
        """Yield all indices in small parts."""
        for first in range(0, len(self), _PART):
            yield self.part(first, min(first + _PART, len(self)))

    def whole(self) -> IndexArray:
        """Return all indices."""
        return self.part(0, len(self)) if len(self) else np.empty(0, np.int32)

    def _ascends(self) -> bool:
        last = -1
        for part in self.parts():
            if part[0] < last or (part[1:] < part[:-1]).any():
                return False
            last = int(part[-1])
        return True


def _are_whole(array: npt.NDArray[Any]) -> bool:
    return array.dtype.kind == "f" and bool((array == np.asarray(array, np.int32)).all())


def index_type(size: int) -> type[np.integer[Any]]:
    """Return the smallest integer type for the indices of this number of cells."""
    return np.uint16 if size <= 1 << 16 else np.int32


def folded(*names: str) -> Callable[[type[T]], type[T]]:
    """Make a class store attributes as :class:`Indices` and return them as arrays."""
    return stored(*names, store=_compact, read=Indices.whole)


def indices_of(owner: object, name: str) -> Indices:
    """Return the stored form of a :func:`folded` attribute."""
    indices: Indices = stored_form(owner, name)
    return indices


def ends_of(projection: object, synapse: int) -> tuple[int, int]:
    """Return ``pre_index`` and ``post_index`` of one synapse of an object that stores them :func:`folded`."""
    pre, post = (
        indices_of(projection, name).part(synapse, synapse + 1) for name in ("pre_index", "post_index")
    )
    return int(pre[0]), int(post[0])


def _compact(values: npt.ArrayLike | Indices) -> Indices:
    return values if isinstance(values, Indices) else Indices.of(values)
