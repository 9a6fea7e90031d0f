"""Spike-timing-dependent plasticity: the machine's rules, with deferred updates.

The weights of a row change only when its source neuron spikes; until then the spikes of its targets are kept
in short histories. Traces are s4.11 and decay by look-up tables; weights are unpacked to s16.15 and packed
again, so each change below the resolution of a raw weight is lost.
"""

from __future__ import annotations

import numpy as np

from nrp_brain_spinnaker.machine.neuromodulation import Rewards, dopamine_after, update_modulated
from nrp_brain_spinnaker.machine.ring import Ring, add_entry
from nrp_brain_spinnaker.machine.stdp_rows import (
    BACK_PROPAGATES,
    MINUS,
    MINUS_LENGTH,
    MODULATED,
    PLUS,
    PLUS_LENGTH,
    SHIFT,
    TIMING,
    TRACE_ONE,
    TRIPLETS,
    X_LENGTH,
    Y_LENGTH,
    StdpRows,
    X,
    Y,
    add_event,
    decayed,
    last_until,
    stored,
)
from nrp_brain_spinnaker.machine.stdp_rules import after_source, after_target, slow_trace
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit


@jit
def remember(rows: StdpRows, i: int, tick: int) -> None:
    """Store a spike of neuron ``i`` in its history, if it has plastic input."""
    if rows.rule_of.size == 0 or rows.rule_of[i] < 0:
        return
    rule, last = rows.rules[rows.rule_of[i]], rows.history_count[i]
    before, trace = rows.history_tick[i, last], rows.history_trace[i, last]
    slow, dopamine = 0, 0
    if rule[TIMING] == TRIPLETS:
        slow = slow_trace(rows.decays, rows.history_slow[i, last], rule[Y], rule[Y_LENGTH], before, tick)
    if rule[MODULATED]:
        dopamine = dopamine_after(rows.decays, rule, rows.history_dopamine[i, last], tick - before)
    trace = stored(decayed(rows.decays, trace, rule[MINUS], rule[MINUS_LENGTH], tick - before) + TRACE_ONE)
    add_event(rows, i, tick, trace, slow, dopamine, 0)


@jit
def deliver_plastic(rows: StdpRows, rewards: Rewards | None, ring: Ring, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) in ``tick`` through its plastic synapses, updating them first."""
    for row in range(rows.start[neuron], rows.start[neuron + 1]):
        deliver_row(rows, rewards, ring, row, rows.first[row + 1], tick)


@jit
def deliver_row(rows: StdpRows, rewards: Rewards | None, ring: Ring, row: int, last: int, tick: int) -> None:
    """Send a spike in ``tick`` through the synapses of a row, which end before ``last``."""
    mask = ring.slots.shape[0] - 1
    if rows.rule[row] < 0:
        for k in range(rows.first[row], last):
            slot = (tick + np.int64(rows.delay[k])) & mask
            add_entry(ring, slot, rows.line[k], np.int64(rows.weight[k]))
        return
    rule, before = rows.rules[rows.rule[row]], rows.last_tick[row]
    if rule[TIMING] == TRIPLETS:  # the trace before this spike
        rows.slow[row] = slow_trace(rows.decays, rows.slow[row], rule[X], rule[X_LENGTH], before, tick)
    for k in range(rows.first[row], last):
        if rewards is None:  # then the other is not compiled
            weight = _updated(rows, rule, row, k, tick)
        elif rule[MODULATED]:
            weight = update_modulated(rows, rule, row, k, tick)
        else:
            weight = _updated(rows, rule, row, k, tick)
        rows.weight[k] = weight
        add_entry(ring, (tick + np.int64(rows.delay[k])) & mask, rows.line[k], weight)
    trace = decayed(rows.decays, rows.trace[row], rule[PLUS], rule[PLUS_LENGTH], tick - before)
    rows.last_tick[row], rows.trace[row] = tick, stored(trace + TRACE_ONE)


@jit
def _updated(rows: StdpRows, rule: IntArray, row: int, k: int, tick: int) -> int:
    """Return the raw weight of synapse ``k`` after all pairs up to a spike in ``tick``."""
    i = rows.line[k] % rows.rule_of.size
    ticks, before = rows.history_tick[i], rows.last_tick[row]
    delay = np.int64(rows.delay[k]) * rule[BACK_PROPAGATES]
    weight = np.int64(rows.weight[k]) << rule[SHIFT]
    last = last_until(ticks, rows.history_count[i], max(tick - delay, 0))
    for entry in range(last_until(ticks, last, max(before - delay, 0)) + 1, last + 1):
        weight = after_target(rows, rule, row, i, entry, delay, weight)
    if last > 0:
        weight = after_source(rows, rule, row, i, last, tick - ticks[last] - delay, weight)
    return int((weight >> rule[SHIFT]) & 0xFFFF)
