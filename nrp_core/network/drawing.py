"""Random values and pairs of large projections, drawn as PyNN draws them.

300 million synapses with weights and delays of their own have 5 GB of them, which are read once, when a brain
is opened. So large projections keep only the state of the generator. Few numbers are treated by the loops
as they are, many by loops of :func:`compile_loop`, which loads a compiler.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final, TypeVar

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.network.indices import stored

Array = npt.NDArray[Any]
F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")

FEWEST: Final = 1 << 20
"""Up to this number, values are kept as an array."""
_AT_ONCE: Final = 1 << 20
_REDRAWN: Final = 1.0 / 8
"""Numbers drawn ahead for those that are replaced, as a share."""

_FEW = 1 << 16
"""Up to this number, a sort by comparing takes less time than loading a compiler."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Values of a clipped normal distribution, drawn column by column of a connection matrix.

    Args:
        generator: the generator before it drew them.
        mean, deviation, low, high: the distribution; values outside are replaced after each column, as
            PyNN does.
        counts: the number of values of each column.
        bounds: the lowest and the highest value.
    """

    generator: np.random.RandomState
    mean: float
    deviation: float
    low: float
    high: float
    counts: npt.NDArray[np.int64]
    bounds: FloatArray

    @staticmethod
    def by(
        generator: np.random.RandomState, distribution: tuple[float, float, float, float], counts: Any
    ) -> Drawn:
        """Draw values, and return them without keeping them; the generator advances."""
        counts = np.asarray(counts, np.int64)
        made = Drawn(deepcopy(generator), *distribution, counts, np.zeros(2))
        values = made._draw(generator)
        return replace(made, bounds=np.array([values.min(initial=np.inf), values.max(initial=-np.inf)]))

    def __len__(self) -> int:
        return int(self.counts.sum())

    @property
    def shape(self) -> tuple[int]:
        """The shape of the values."""
        return (len(self),)

    def whole(self) -> FloatArray:
        """Return all values."""
        return self._draw(deepcopy(self.generator))

    def _draw(self, generator: np.random.RandomState) -> FloatArray:
        """Draw all values; the generator ends behind the last number that was needed."""
        out, at = np.empty(len(self)), np.zeros(3, np.int64)
        ahead = np.empty(0)
        while at[0] < len(self.counts):
            before = generator.get_state(legacy=False)
            missing = min(len(out) - int(at[1]), _AT_ONCE) + int(self.counts[at[0]])
            more = max(missing + int(missing * _REDRAWN) + 8 - len(ahead), 8)
            drawn = np.concatenate([ahead, generator.normal(self.mean, self.deviation, more)])
            at[2] = 0
            compile_loop(fill_clipped)(drawn, self.low, self.high, self.counts, out, at)
            ahead = drawn[at[2] :]
        if len(ahead):
            generator.set_state(before)
            generator.normal(self.mean, self.deviation, more - len(ahead))
        return out


def are_drawn_again(n: int) -> bool:
    """Return whether a number of values is too large to be kept; without a compiler all are."""
    if n < FEWEST:
        return False
    from nrp_core._support.jit import COMPILED  # loads it

    return COMPILED


def redrawn(*names: str) -> Callable[[type[T]], type[T]]:
    """Make a class store attributes as arrays or :class:`Drawn`, and return them as arrays."""
    return stored(*names, store=_as_given, read=whole)


def whole(values: Any) -> FloatArray:
    """Return values as an array."""
    array: FloatArray = values.whole() if isinstance(values, Drawn) else values
    return array


def extremes(values: Any) -> FloatArray:
    """Return values, or their lowest and highest if they are drawn again."""
    array: FloatArray = values.bounds if isinstance(values, Drawn) else values
    return array


def in_parts(values: FloatArray) -> Iterator[FloatArray]:
    """Yield consecutive values in small parts, so that computations with them need little memory."""
    return (values[first : first + _FEW] for first in range(0, len(values), _FEW))


class Columns(dict[str, Any]):
    """Values by name that are arrays when they are looked up; in ``items`` they have their stored form."""

    def __getitem__(self, name: str) -> FloatArray:
        return whole(super().__getitem__(name))

    def extremes(self, name: str) -> FloatArray:
        """Return values, or their lowest and highest if they are drawn again."""
        return extremes(super().__getitem__(name))

    def get(self, name: str, default: Any = None) -> Any:
        """Return values, or the default."""
        return whole(super().get(name, default))


def _as_given(values: Any) -> Any:
    return values


@cache
def compile_loop(loop: F) -> F:
    """Return a compiled loop of this module; the first one loads a compiler."""
    from nrp_core._support.jit import jit

    return jit(loop)


def sorted_by(keys: Array, values: Array, n_keys: int) -> tuple[Array, Array]:
    """Return values in the stable order of their keys below ``n_keys``, and the number of each key."""
    counts = np.bincount(keys, minlength=n_keys)
    if len(keys) <= _FEW:
        return values[np.argsort(keys, kind="stable")], counts
    out = np.empty_like(values)
    compile_loop(place_by)(keys, values, np.cumsum(counts) - counts, out)
    return out, counts


def fill_clipped(drawn: Array, low: float, high: float, counts: Array, out: Array, at: Array) -> None:
    """Fill columns with numbers of a sequence; those out of range are replaced after each column.

    Args:
        drawn: the sequence.
        low: the lowest that is in range.
        high: the highest.
        counts: the length of each column.
        out: the columns, concatenated.
        at: the next column, its first element, and the next number: advanced by whole columns only.
    """
    column, first, taken = at[0], at[1], at[2]
    while column < len(counts):
        last = first + counts[column]
        used = taken
        missing = last - first
        if used + missing > len(drawn):
            return
        out[first:last] = drawn[used : used + missing]
        used += missing
        while missing > 0:
            missing = 0
            for k in range(first, last):
                if out[k] < low or out[k] > high:
                    if used == len(drawn):
                        return
                    out[k] = drawn[used]
                    used += 1
                    missing += 1
        column, first, taken = column + 1, last, used
        at[0], at[1], at[2] = column, first, taken


def pairs_among(words: Array, high: Array, masks: Array, out: Array, at: Array) -> None:
    """Take pairs of integers from words: masked, and rejected if they are too high.

    Args:
        words: random words.
        high: the numbers are below these two.
        masks: the bits of a word that count for each.
        out: the pairs, shape ``(2, n)``.
        at: the next pair and the next word: advanced by whole pairs only.
    """
    word = at[1]
    for pair in range(at[0], out.shape[1]):
        for side in range(2):
            while word < len(words) and words[word] & masks[side] >= high[side]:
                word += 1
            if word == len(words):
                return
            out[side, pair] = words[word] & masks[side]
            word += 1
        at[0], at[1] = pair + 1, word


def place_by(keys: Array, values: Array, at: Array, out: Array) -> None:
    """Write values in the order of their keys, equal keys in the given order; ``at`` has the first places."""
    for k in range(len(keys)):
        out[at[keys[k]]] = values[k]
        at[keys[k]] += 1
