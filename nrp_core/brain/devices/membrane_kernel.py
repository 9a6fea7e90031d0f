"""The passage of spikes through a filter, compiled; each state is an array of one record.

See :class:`~nrp_core.brain.devices.membrane.LeakyMembrane`; importing this loads a compiler.
"""

from __future__ import annotations

from math import e, exp
from typing import Any

import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import inlined, jit
from nrp_core.network import filters

_driven = inlined(filters.driven)


@jit
def enqueue(
    state: npt.NDArray[Any],
    queue: FloatArray,
    neurons: IntArray,
    times_ms: FloatArray,
    chosen: npt.NDArray[Any],
    weights: FloatArray,
    delay_ms: float,
) -> bool:
    """Add the spikes of chosen neurons to a queue, shape ``(2, room)``; false if they need more room."""
    n = state[0].waiting
    if n + len(neurons) > queue.shape[1]:
        return False
    for k in range(len(neurons)):
        if chosen[neurons[k]]:
            queue[0, n], queue[1, n] = times_ms[k] + delay_ms, weights[neurons[k]]
            n += 1
    state[0].waiting = n
    return True


@jit
def voltage_mv(state: npt.NDArray[Any], queue: FloatArray, t_ms: float) -> float:
    """Move a membrane to each spike that has arrived by a time, and return its voltage then."""
    own, arrivals_ms, weights = state[0], queue[0], queue[1]
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
