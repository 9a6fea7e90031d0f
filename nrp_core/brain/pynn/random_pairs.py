"""Pairs of random integers, drawn as arrays with the same result as drawing them one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from pyNN.random import NumpyRNG

Indices = npt.NDArray[np.int32]

_BLOCK = 1 << 20


def random_pairs(rng: Any, n_first: int, n_second: int, n: int) -> tuple[Indices, Indices]:
    """Return ``n`` pairs of integers below ``n_first`` and ``n_second``.

    The numbers equal those of PyNN's loop over synapses (one integer, one choice, and so on), and the
    generator ends in the same state.
    """
    if not isinstance(rng, NumpyRNG):
        return _one_by_one(rng, n_first, n_second, n)
    state: np.random.RandomState = rng.rng
    if n_first == n_second:
        both = state.randint(0, n_first, size=2 * n).astype(np.int32)
        return both[::2].copy(), both[1::2].copy()
    if n_first == 1 or n_second == 1:  # drawing from a range of one does not advance the generator
        first, second = (state.randint(0, high, size=n).astype(np.int32) for high in (n_first, n_second))
        return first, second
    return _interleaved(state, n_first, n_second, n)


def _one_by_one(rng: Any, n_first: int, n_second: int, n: int) -> tuple[Indices, Indices]:
    pairs = np.empty((2, n), np.int32)
    choices = np.arange(n_second)
    for i in range(n):
        pairs[0, i] = rng.next(1, "uniform_int", {"low": 0, "high": n_first}, mask=None)[0]
        pairs[1, i] = rng.choice(choices, size=1)[0]
    return pairs[0], pairs[1]


def _interleaved(
    state: np.random.RandomState, n_first: int, n_second: int, n: int
) -> tuple[Indices, Indices]:
    """Draw by NumPy's rule for bounded integers: masked 32-bit words, those out of range rejected."""
    parts: list[tuple[Indices, Indices]] = []
    missing = n
    while missing:
        before = state.get_state(legacy=False)
        words = _words(state, min(_BLOCK, 8 * missing + 8))
        pairs, taken = _pairs_among(words, n_first, n_second, missing)
        state.set_state(before)
        _words(state, taken)
        parts.append(pairs)
        missing -= len(pairs[0])
    empty = np.empty(0, np.int32)
    return np.concatenate([empty, *(a for a, _ in parts)]), np.concatenate([empty, *(b for _, b in parts)])


def _words(state: np.random.RandomState, n: int) -> npt.NDArray[np.uint32]:
    return state.randint(0, 1 << 32, size=n, dtype=np.uint32)


def _pairs_among(
    words: npt.NDArray[np.uint32], n_first: int, n_second: int, limit: int
) -> tuple[tuple[Indices, Indices], int]:
    """Return up to ``limit`` pairs from a sequence of words, and the number of words used."""
    first, next_first = _accepted(words, n_first)
    second, next_second = _accepted(words, n_second)
    partner = next_second[np.minimum(next_first + 1, len(words))]
    following = np.minimum(partner + 1, len(words) + 1).tolist()
    starts: list[int] = []
    at = 0
    while len(starts) < limit and following[at] <= len(words):
        starts.append(at)
        at = following[at]
    chosen = next_first[starts]
    return (first[chosen], second[partner[starts]]), at


def _accepted(words: npt.NDArray[np.uint32], high: int) -> tuple[Indices, npt.NDArray[np.int64]]:
    """Return the integer below ``high`` of each word, and for each position the next word in range.

    The second array has one element more than there are words; the number of words means none.
    """
    values = words & np.uint32((1 << (high - 1).bit_length()) - 1)
    places = np.where(values < high, np.arange(len(words)), len(words))
    places = np.append(places, len(words))
    return values.astype(np.int32), np.minimum.accumulate(places[::-1])[::-1]
