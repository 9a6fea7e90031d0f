"""The filtering of spikes, compiled.

See :class:`~nrp_core.brain.devices.membrane.LeakyMembrane`; importing this loads a compiler.
"""

from __future__ import annotations

from math import e, exp
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import array_at, inlined, jit
from nrp_core.brain.devices.records import MEMBRANE
from nrp_core.network import filters

_MEMBRANE: Final = np.zeros(1, MEMBRANE)
_NUMBERS: Final = np.empty(0)
_FLAGS: Final = np.empty(0, np.bool_)
_COUNTS: Final = np.empty(0, np.int64)
_driven = inlined(filters.driven)


@jit
def enqueue(membrane: int, neurons: IntArray, times_ms: FloatArray) -> bool:
    """Add the spikes that the membrane at an address receives; return false if there is too little room."""
    own = array_at(membrane, 1, _MEMBRANE)[0]
    if own.waiting + len(neurons) > own.room:
        return False
    queue = array_at(own.queue, 2 * own.room, _NUMBERS)
    received = array_at(own.received, own.n_neurons, _FLAGS)
    weights = array_at(own.weights, own.n_neurons, _NUMBERS)
    for k in range(len(neurons)):
        if received[neurons[k]]:
            queue[own.waiting] = times_ms[k] + own.delay_ms
            queue[own.room + own.waiting] = weights[neurons[k]]
            own.waiting += 1
    return True


@jit
def voltage_mv(membrane: int, t_ms: float) -> float:
    """Advance the membrane at an address through the spikes until a time; return its voltage at that time."""
    own = array_at(membrane, 1, _MEMBRANE)[0]
    queue = array_at(own.queue, 2 * own.room, _NUMBERS)
    arrivals_ms, weights = queue[: own.room], queue[own.room :]
    gap = 1.0 / own.tau_syn_ms - 1.0 / own.tau_m_ms
    _sort(arrivals_ms, weights, own.waiting)
    arrived = 0
    while arrived < own.waiting and arrivals_ms[arrived] <= t_ms:
        dt_ms = arrivals_ms[arrived] - own.at_ms
        fade, leak = exp(-dt_ms / own.tau_syn_ms), exp(-dt_ms / own.tau_m_ms)
        own.above = own.above * leak + _driven(dt_ms, leak, fade, gap, own.current, own.slope) / own.cm_nf
        own.current = (own.current + own.slope * dt_ms) * fade
        own.slope *= fade
        if own.alpha > 0.0:
            own.slope += weights[arrived] * e / own.tau_syn_ms
        else:
            own.current += weights[arrived]
        own.at_ms = arrivals_ms[arrived]
        arrived += 1
    if arrived > 0:
        for k in range(arrived, own.waiting):
            arrivals_ms[k - arrived], weights[k - arrived] = arrivals_ms[k], weights[k]
        own.waiting -= arrived
    dt_ms = t_ms - own.at_ms
    fade, leak = exp(-dt_ms / own.tau_syn_ms), exp(-dt_ms / own.tau_m_ms)
    charge = _driven(dt_ms, leak, fade, gap, own.current, own.slope)
    return float(own.settled_mv + (own.above * leak + charge / own.cm_nf))


@jit
def voltages_mv(membranes: IntArray, voltages: FloatArray) -> None:
    """Store the present voltage of each membrane; see :func:`voltage_mv`."""
    for i in range(len(membranes)):
        voltages[i] = voltage_mv(membranes[i], array_at(membranes[i], 1, _MEMBRANE)[0].now_ms)


@inlined
def _sort(arrivals_ms: FloatArray, weights: FloatArray, n: int) -> None:
    """Sort the first spikes by arrival and weight; they are nearly sorted."""
    for i in range(1, n):
        arrival_ms, weight = arrivals_ms[i], weights[i]
        k = i
        while k > 0 and (
            arrivals_ms[k - 1] > arrival_ms or (arrivals_ms[k - 1] == arrival_ms and weights[k - 1] > weight)
        ):
            arrivals_ms[k], weights[k] = arrivals_ms[k - 1], weights[k - 1]
            k -= 1
        arrivals_ms[k], weights[k] = arrival_ms, weight


@jit
def receive_each(
    membranes: IntArray,
    until_ms: FloatArray,
    ends: IntArray,
    neurons: IntArray,
    times_ms: FloatArray,
    done: int,
) -> int:
    """Add the spikes of each brain to its membranes, shape ``(brains, membranes)``, from ``done`` on.

    Returns:
        The number of the first membrane that needs more room, otherwise the number of membranes.
    """
    n = membranes.shape[1]
    for number in range(done, membranes.size):
        i = number // n
        membrane = membranes[i, number % n]
        own = array_at(membrane, 1, _MEMBRANE)[0]
        first, last = ends[i - 1] if i > 0 else 0, ends[i]
        own.now_ms = until_ms[i]
        if own.active and first < last and not enqueue(membrane, neurons[first:last], times_ms[first:last]):
            return number
    return membranes.size


@jit
def count_each(counters: IntArray, size: int, ends: IntArray, neurons: IntArray) -> None:
    """Add the spikes of each brain to its counters by neuron, shape ``(brains, counters)``."""
    for i in range(len(counters)):
        for k in range(counters.shape[1]):
            counts = array_at(counters[i, k], size, _COUNTS)
            for one in range(ends[i - 1] if i > 0 else 0, ends[i]):
                counts[neurons[one]] += 1
