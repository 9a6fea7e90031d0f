"""The random numbers of the machine: KISS with a 64-bit multiply-with-carry, and variates from them.

Marsaglia's generator of 2003 (state x, y, z, c, four words of 32 bits); exponential variates by von Neumann's
comparison method, Poisson variates by Knuth's product of uniform ones.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from nrp_brain_spinnaker.machine.fixed_point import FRACTION_LARGEST, ONE
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit
from nrp_core.seeds import Seeds

_WORD: Final = 0xFFFFFFFF


def kiss_state(seeds: Seeds, name: str) -> IntArray:
    """Return the state of the generator with a name."""
    return valid_state([seeds.integer(f"{name}/{word}") for word in "xyzc"])


def valid_state(words: list[int]) -> IntArray:
    """Return a valid state: words from which the generator must not start are replaced."""
    x, y, z, c = words
    return np.array([x, y or 13031301, z, c % 698769068 + 1], np.int64)


@jit
def next_word(state: IntArray) -> int:
    """Return the next uniform 32-bit number."""
    x, y, z, c = state[0], state[1], state[2], state[3]
    x = (314527869 * x + 1234567) & _WORD
    y ^= (y << 5) & _WORD
    y ^= y >> 7
    y ^= (y << 22) & _WORD
    low = c - 382903 * z  # 4294584393 z + c, less 2**32 z, which would not fit
    z, c = low & _WORD, z + (low >> 32)
    state[0], state[1], state[2], state[3] = x, y, z, c
    return int((x + y + z) & _WORD)


@jit
def exponential_variate(state: IntArray) -> int:
    """Return an exponential variate of mean 1, s16.15."""
    whole = 0
    while True:
        first = word = next_word(state)
        while True:
            other = next_word(state)
            if word < other:
                return whole + (first >> 17)
            word = next_word(state)
            if word >= other:
                break
        whole += ONE


@jit
def poisson_variate(state: IntArray, exp_minus_mean: int) -> int:
    """Return a Poisson variate, given exp(-mean) as u0.32."""
    product, count = FRACTION_LARGEST, -1
    while True:
        word = next_word(state)
        product = (product * (word >> 16) + ((product * (word & 0xFFFF)) >> 16)) >> 16
        count += 1
        if product <= exp_minus_mean:
            return count
