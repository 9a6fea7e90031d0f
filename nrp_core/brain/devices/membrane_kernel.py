"""The passage of many spikes through a filter; importing it loads a compiler."""

from __future__ import annotations

from math import e, exp

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined, jit
from nrp_core.network import filters

_driven = inlined(filters.driven)


@jit
def pass_spikes(
    state: FloatArray,
    arrivals_ms: FloatArray,
    weights: FloatArray,
    until_ms: float,
    alpha: bool,
    tau_m_ms: float,
    tau_syn_ms: float,
    cm_nf: float,
) -> int:
    """Sort spikes, and move a membrane to each that has arrived.

    The operations are those of :class:`~nrp_core.brain.devices.membrane.LeakyMembrane`, in the same order.

    Args:
        state: time of the last spike, current, slope, voltage above the settled one; changed in place.
        arrivals_ms: shape ``(n,)``, nearly in order; sorted in place.
        weights: of the same shape; sorted with them.
        until_ms: the time.
        alpha: whether currents are alpha-shaped; as the following ones, of the membrane's kernel.
        tau_m_ms: its time constant.
        tau_syn_ms: that of its synapses.
        cm_nf: its capacitance.

    Returns:
        The number of spikes that have arrived.
    """
    gap = 1.0 / tau_syn_ms - 1.0 / tau_m_ms
    for i in range(1, len(arrivals_ms)):
        arrival_ms, weight = arrivals_ms[i], weights[i]
        k = i
        while k > 0 and (
            arrivals_ms[k - 1] > arrival_ms or (arrivals_ms[k - 1] == arrival_ms and weights[k - 1] > weight)
        ):
            arrivals_ms[k], weights[k] = arrivals_ms[k - 1], weights[k - 1]
            k -= 1
        arrivals_ms[k], weights[k] = arrival_ms, weight
    at_ms, current, slope, above = state[0], state[1], state[2], state[3]
    arrived = 0
    while arrived < len(arrivals_ms) and arrivals_ms[arrived] <= until_ms:
        dt_ms = arrivals_ms[arrived] - at_ms
        fade, leak = exp(-dt_ms / tau_syn_ms), exp(-dt_ms / tau_m_ms)
        above = above * leak + _driven(dt_ms, leak, fade, gap, current, slope) / cm_nf
        current = (current + slope * dt_ms) * fade
        slope *= fade
        if alpha:
            slope += weights[arrived] * e / tau_syn_ms
        else:
            current += weights[arrived]
        at_ms = arrivals_ms[arrived]
        arrived += 1
    state[0], state[1], state[2], state[3] = at_ms, current, slope, above
    return arrived
