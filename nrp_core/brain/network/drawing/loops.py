"""Random numbers of a sequence as their users take them one by one, and a sort by small numbers.

Few numbers are treated by these functions as they are, many by :mod:`.compiled`: it loads a compiler.
"""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

Array = npt.NDArray[Any]


def clipped(drawn: Array, low: float, high: float, counts: Array, out: Array, at: Array) -> None:
    """Fill columns with numbers of a sequence; those out of range are replaced after each column.

    Args:
        drawn: the sequence.
        low: the lowest that is in range.
        high: the highest.
        counts: the length of each column.
        out: the columns, one after the other.
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
