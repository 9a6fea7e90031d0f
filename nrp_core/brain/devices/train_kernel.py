"""The spikes of sources, compiled.

See :mod:`nrp_core.brain.devices.trains`; importing this loads a compiler.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import array_at, inlined, jit
from nrp_core.brain.devices.records import TRAIN

_TRAIN: Final = np.zeros(1, TRAIN)
_FLOATS: Final = np.empty(0)
_IDS: Final = np.empty(0, np.int64)


@jit
def due(train: int, since_ms: float, until_ms: float, on: bool) -> int:
    """Return the number of spikes with ``since_ms < t <= until_ms``; -1 if more arrivals must be drawn.

    ``own`` is the address of the state of the source, which emits spikes in this window only if it is ``on``.
    """
    own = array_at(train, 1, _TRAIN)[0]
    rate = own.rate if on and own.active else 0.0
    if rate != own.anchored_rate:
        own.anchor_u += own.anchored_rate * (since_ms - own.anchor_ms) * 1e-3
        own.anchor_ms, own.anchored_rate = since_ms, rate
    own.n_due = 0
    if rate == 0.0:
        return 0
    guess = own.anchor_u + (until_ms - own.anchor_ms) * own.anchored_rate * 1e-3  # except for rounding
    k = own.next
    if own.copies > 0:
        while _real_ms(own, float(k)) <= until_ms:
            k += 1
        own.n_due = k - own.next
        return int(own.n_due * own.copies * own.n_neurons)
    own.needed_u = guess + 1.0  # after this, the last arrival is not due yet
    if own.last_u <= own.needed_u:
        return -1
    u = array_at(own.u, own.n_drawn, _FLOATS)
    while _real_ms(own, u[k]) <= until_ms:
        k += 1
    own.n_due = k - own.next
    return int(own.n_due)


@jit
def take(train: int, times_ms: FloatArray, neurons: IntArray) -> None:
    """Store the times and neurons of the spikes that :func:`due` has counted, and remove them."""
    own = array_at(train, 1, _TRAIN)[0]
    targets = array_at(own.neurons, own.n_neurons, _IDS)
    k = 0
    if own.copies > 0:
        for _ in range(own.n_due):
            t_ms = _real_ms(own, float(own.next))
            own.next += 1
            for target in targets:
                for _ in range(own.copies):
                    times_ms[k], neurons[k] = t_ms, target
                    k += 1
        return
    u, v = array_at(own.u, own.n_drawn, _FLOATS), array_at(own.v, own.n_drawn, _FLOATS)
    for k in range(own.n_due):
        times_ms[k] = _real_ms(own, u[own.next])
        neurons[k] = targets[_place(own, v[own.next])]
        own.next += 1


@inlined
def _real_ms(own: Any, u: float) -> float:
    """Return the real time of an operational time at the current rate."""
    return float(own.anchor_ms + (u - own.anchor_u) * (1e3 / own.anchored_rate))


@inlined
def _place(own: Any, v: float) -> int:
    """Return the index of a random share among the cumulative shares of the neurons."""
    last = own.n_neurons - 1
    if own.shares == 0:
        place = min(int(v * own.n_neurons), last)
        if (place + 1) / own.n_neurons <= v:  # the product has rounding errors; the shares decide
            place += 1
        if place > 0 and place / own.n_neurons > v:
            place -= 1
        return int(min(place, last))
    shares = array_at(own.shares, own.n_neurons, _FLOATS)
    place, beyond = 0, last
    while place < beyond:  # the first share beyond the number
        middle = (place + beyond) // 2
        if shares[middle] <= v:
            place = middle + 1
        else:
            beyond = middle
    return int(place)


@jit
def due_each(trains: IntArray, since_ms: FloatArray, until_ms: FloatArray, counts: IntArray) -> None:
    """Store the result of :func:`due` for each source of each brain, shape ``(brains, sources)``."""
    for i in range(len(trains)):
        for k in range(trains.shape[1]):
            counts[i, k] = due(trains[i, k], since_ms[i], until_ms[i], True)


@jit
def take_each(
    trains: IntArray,
    counts: IntArray,
    neurons: IntArray,
    arrivals_ms: FloatArray,
    weights: FloatArray,
    kinds: IntArray,
) -> None:
    """Store the events of the spikes that are due, brain by brain; the kind of inhibitory events is 1."""
    first = 0
    for i in range(len(trains)):
        for k in range(trains.shape[1]):
            last = first + counts[i, k]
            if last == first:
                continue
            own = array_at(trains[i, k], 1, _TRAIN)[0]
            take(trains[i, k], arrivals_ms[first:last], neurons[first:last])
            arrivals_ms[first:last] += own.delay_ms
            weights[first:last], kinds[first:last] = own.weight, own.inhibitory
            first = last
