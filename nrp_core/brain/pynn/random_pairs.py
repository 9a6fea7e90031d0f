"""Pairs of random integers, drawn as arrays with the same result as drawing them one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from pyNN.random import NumpyRNG

from nrp_core.brain.network.drawing import compiled, pairs_among

Indices = npt.NDArray[np.int32]

_BLOCK = 1 << 20
_FEW = 1 << 14
"""Up to this number of pairs, Python takes less time than loading a compiler."""


def random_pairs(rng: Any, n_first: int, n_second: int, n: int) -> tuple[Indices, Indices]:
    """Return ``n`` pairs of integers below ``n_first`` and ``n_second``.

    The numbers equal those of PyNN's loop over synapses (one integer, one choice, and so on), and the
    generator ends in the same state.
    """
    if not isinstance(rng, NumpyRNG):
        return _one_by_one(rng, n_first, n_second, n)
    state: np.random.RandomState = rng.rng
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
    high = np.array([n_first, n_second], np.uint32)
    masks = np.array([(1 << (size - 1).bit_length()) - 1 for size in (n_first, n_second)], np.uint32)
    pairs, at = np.empty((2, n), np.int32), np.zeros(2, np.int64)
    take = pairs_among if n <= _FEW else compiled(pairs_among)
    while at[0] < n:
        before = state.get_state(legacy=False)
        words, at[1] = _words(state, min(_BLOCK, 8 * (n - int(at[0])) + 8)), 0
        take(words, high, masks, pairs, at)
        state.set_state(before)
        _words(state, int(at[1]))
    return pairs[0], pairs[1]


def _words(state: np.random.RandomState, n: int) -> npt.NDArray[np.uint32]:
    return state.randint(0, 1 << 32, size=n, dtype=np.uint32)
