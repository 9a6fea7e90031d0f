"""Spike-timing-dependent plasticity: PyNN's SpikePairRule over all pairs, additive or multiplicative.

A synapse processes a spike of its source after the axonal part of its delay, and one of its target after the
dendritic part. For two spikes at a distance dt the later one changes the weight, by

- ``A_plus f exp(-dt / tau_plus)`` upwards if the target's came later,
- ``A_minus f exp(-dt / tau_minus)`` downwards if it came first (a negative A has the opposite effect),

with f = ``w_max`` (additive), or the distance from ``w_max`` and ``w_min`` (multiplicative; Morrison,
Diesmann & Gerstner 2008, Biol Cybern 98:459); simultaneous spikes have no effect. Weights stay within the
limits.

A synapse is updated when a spike reaches its target: then all earlier spikes of the target are known for any
delay. A target stores a spike until all its synapses have processed it.
"""

from __future__ import annotations

from math import exp
from typing import Final

from nrp_brain_event.records import Array, Cell, Clock, Plastic, Rule
from nrp_core._support.jit import jit

SIMULTANEOUS: Final = 1e-9
"""Tolerance of equal times in floating point, ms."""
_MANY: Final = 64
"""Number of stored spikes of a target at which it frees those that are not needed."""


@jit
def transmit(synapse: Plastic, rule: Rule, cell: Cell, events: Array, arrival: float) -> float:
    """Update the synapse for a spike that reaches the target at ``arrival``; return its weight there."""
    t = arrival - synapse.dendritic_delay
    hear(synapse, rule, cell, events, t + SIMULTANEOUS)
    depression = rule.A_minus * _trace(synapse.post_t, synapse.post_trace, t, rule.tau_minus)
    span = synapse.weight - rule.w_min if rule.multiplicative else rule.w_max
    synapse.weight = _changed(synapse.weight, -depression, span, rule)
    synapse.pre_trace = (synapse.pre_trace + 1.0) * exp((synapse.pre_t - t) / rule.tau_plus)
    synapse.pre_t = t
    return synapse.weight * rule.sign


@jit
def hear(synapse: Plastic, rule: Rule, cell: Cell, events: Array, until: float) -> None:
    """Update the synapse for the spikes of the target up to a time."""
    index = events[synapse.heard].after if synapse.heard >= 0 else cell.first_fired
    while index >= 0 and events[index].time + synapse.dendritic_delay <= until:
        t = events[index].time + synapse.dendritic_delay
        potentiation = rule.A_plus * _trace(synapse.pre_t, synapse.pre_trace, t, rule.tau_plus)
        span = rule.w_max - synapse.weight if rule.multiplicative else rule.w_max
        synapse.weight = _changed(synapse.weight, potentiation, span, rule)
        synapse.post_trace = (synapse.post_trace + 1.0) * exp((synapse.post_t - t) / rule.tau_minus)
        synapse.post_t = t
        synapse.heard = index
        index = events[index].after


@jit
def _changed(weight: float, share: float, span: float, rule: Rule) -> float:
    """Return a weight after a change by a share of ``span``, clipped at the limit in this direction."""
    if share > 0.0:
        return min(weight + share * span, rule.w_max)
    return max(weight + share * span, rule.w_min) if share < 0.0 else weight


@jit
def remember(cell: Cell, synapses: Array, rules: Array, clock: Clock, events: Array) -> None:
    """Store the present spike of a cell for its plastic synapses; there must be a free event."""
    if cell.n_remembered >= _MANY:
        _forget(cell, synapses, rules, clock, events)
    index = clock.free
    event = events[index]
    clock.free = event.after
    clock.n_free -= 1
    event.time, event.after, event.target = cell.wake, -1, cell.n_fired
    if cell.last_fired >= 0:
        events[cell.last_fired].after = index
    else:
        cell.first_fired = index
    cell.last_fired = index
    cell.n_fired += 1
    cell.n_remembered += 1


@jit
def bring_up_to(
    now: float, cells: Array, synapses: Array, rules: Array, events: Array, passed: Array
) -> None:
    """Update synapses for all spikes that have reached them by now.

    Args:
        now: the time of the engine, ms.
        cells: the cells of the engine.
        synapses: the synapses of the engine, which change.
        rules: the rules of the engine.
        events: the events of the engine; those that have passed their synapses get their weights.
        passed: indices of these events, not yet at their targets, in order of the time at which they passed.
    """
    for index in passed:
        event = events[index]
        synapse = synapses[~event.target]
        event.weight = transmit(synapse, rules[synapse.rule], cells[synapse.target >> 1], events, event.time)
        event.target = synapse.target
    for k in range(len(synapses)):
        synapse = synapses[k]
        hear(synapse, rules[synapse.rule], cells[synapse.target >> 1], events, now)


@jit
def _forget(cell: Cell, synapses: Array, rules: Array, clock: Clock, events: Array) -> None:
    """Free the spikes that all synapses of a cell have processed, except the last one."""
    first_needed = cell.n_fired
    for k in range(len(synapses)):
        synapse = synapses[k]
        # spikes in transit have passed the synapse after this
        hear(synapse, rules[synapse.rule], cell, events, cell.wake - synapse.dendritic_delay)
        first_needed = min(first_needed, events[synapse.heard].target if synapse.heard >= 0 else 0)
    while events[cell.first_fired].target < first_needed:
        index = cell.first_fired
        cell.first_fired = events[index].after
        events[index].after = clock.free
        clock.free = index
        clock.n_free += 1
        cell.n_remembered -= 1


@jit
def _trace(last: float, before: float, t: float, tau: float) -> float:
    """Return the trace at t of a train of spikes, each with amplitude 1; a spike at t does not count.

    Args:
        last: time of the last spike.
        before: the trace of the earlier spikes then.
        t: not before the last spike.
        tau: time constant.
    """
    if t - last <= SIMULTANEOUS:
        return before
    return (before + 1.0) * exp((last - t) / tau)
