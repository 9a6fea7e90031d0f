"""Plastic synapses process the spikes of their source and target in the order in which these reach them.

A synapse processes a spike of its source after the axonal part of its delay, and one of its target after the
dendritic part. What they do to the weight is the rule's: see :mod:`nrp_brain_event.synapse_kernels`.

A synapse is updated when a spike reaches its target: then all earlier spikes of the target are known for any
delay. A target stores a spike until all its synapses have processed it.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_event.records import Array, Cell, Clock, Plastic, Rule
from nrp_brain_event.synapse_kernels import SIMULTANEOUS, on_source, on_target
from nrp_core._support.jit import jit

_MANY: Final = 64
"""Number of stored spikes of a target at which it frees those that are not needed."""


@jit
def transmit(synapse: Plastic, rule: Rule, cell: Cell, events: Array, arrival: float) -> float:
    """Update the synapse for a spike that reaches the target at ``arrival``; return its weight there."""
    t = arrival - synapse.dendritic_delay
    catch_up(synapse, rule, cell, events, t + SIMULTANEOUS)
    on_source(rule, synapse, t)
    return float(synapse.weight * rule.sign)


@jit
def catch_up(synapse: Plastic, rule: Rule, cell: Cell, events: Array, until: float) -> None:
    """Update the synapse for the spikes of the target up to a time."""
    index = events[synapse.last_seen].after if synapse.last_seen >= 0 else cell.first_stored
    while index >= 0 and events[index].time + synapse.dendritic_delay <= until:
        on_target(rule, synapse, events[index].time + synapse.dendritic_delay)
        synapse.last_seen = index
        index = events[index].after


@jit
def store_spike(cell: Cell, synapses: Array, rules: Array, clock: Clock, events: Array) -> None:
    """Store the present spike of a cell for its plastic synapses; there must be a free event."""
    if cell.n_stored >= _MANY:
        _forget(cell, synapses, rules, clock, events)
    index = clock.free
    event = events[index]
    clock.free = event.after
    clock.n_free -= 1
    event.time, event.after, event.target = cell.wake, -1, cell.n_fired
    if cell.last_stored >= 0:
        events[cell.last_stored].after = index
    else:
        cell.first_stored = index
    cell.last_stored = index
    cell.n_fired += 1
    cell.n_stored += 1


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
        catch_up(synapse, rules[synapse.rule], cells[synapse.target >> 1], events, now)


@jit
def _forget(cell: Cell, synapses: Array, rules: Array, clock: Clock, events: Array) -> None:
    """Free the spikes that all synapses of a cell have processed, except the last one."""
    first_needed = cell.n_fired
    for k in range(len(synapses)):
        synapse = synapses[k]
        # spikes in transit have passed the synapse after this
        catch_up(synapse, rules[synapse.rule], cell, events, cell.wake - synapse.dendritic_delay)
        first_needed = min(first_needed, events[synapse.last_seen].target if synapse.last_seen >= 0 else 0)
    while events[cell.first_stored].target < first_needed:
        index = cell.first_stored
        cell.first_stored = events[index].after
        events[index].after = clock.free
        clock.free = index
        clock.n_free += 1
        cell.n_stored -= 1
