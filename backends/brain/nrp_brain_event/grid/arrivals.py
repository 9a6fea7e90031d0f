"""Inputs outside the calendar: from devices, and through synapses whose weights have changed since."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrp_brain_event.records import Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import inlined, jit


class Arrivals(NamedTuple):
    """A list of inputs in the order of arrival.

    Args:
        inputs: steps, flat indices into the state, rows of plastic synapses that determine the weight, or -1;
            ascending, shape ``(3, n)``.
        weights: weights of inputs without a plastic synapse; shape ``(n,)``.
    """

    inputs: IntArray
    weights: FloatArray

    @classmethod
    def none(cls) -> Arrivals:
        """Return an empty list."""
        return cls(np.empty((3, 0), np.int64), np.empty(0))

    def joined(self, inputs: IntArray, weights: FloatArray) -> Arrivals:
        """Return these and others, in an order that does not depend on the insertion."""
        return Arrivals(*_joined(self.inputs, self.weights, inputs, weights))

    def after(self, n: int) -> Arrivals:
        """Return all but the first n."""
        return Arrivals(self.inputs[:, n:].copy(), self.weights[n:].copy()) if n else self


@jit
def _joined(inputs: Array, weights: Array, more: Array, their_weights: Array) -> tuple[Array, Array]:
    every, each = np.concatenate((inputs, more), axis=1), np.concatenate((weights, their_weights))
    order = _order(every, each)
    return every[:, order], each[order]


@jit
def _order(inputs: Array, weights: Array) -> Array:
    """Return the ascending order of inputs, by their columns and then by weight: a merge sort."""
    n = len(weights)
    order, merged = np.arange(n), np.empty(n, np.int64)
    width = 1
    while width < n:
        for first in range(0, n, 2 * width):
            middle, end = min(first + width, n), min(first + 2 * width, n)
            a, b = first, middle
            for k in range(first, end):
                if b == end or (a < middle and not _earlier(inputs, weights, order[b], order[a])):
                    merged[k] = order[a]
                    a += 1
                else:
                    merged[k] = order[b]
                    b += 1
        order, merged = merged, order
        width *= 2
    return order


@inlined
def _earlier(inputs: Array, weights: Array, a: int, b: int) -> bool:
    for what in range(len(inputs)):
        if inputs[what, a] != inputs[what, b]:
            return bool(inputs[what, a] < inputs[what, b])
    return bool(weights[a] < weights[b])
