"""Spike-timing-dependent plasticity: the machine's rules, with deferred updates.

The weights of a row change only when its source neuron spikes; until then the spikes of its targets are kept
in short histories. Traces are s4.11 and decay by look-up tables; weights are unpacked to s16.15 and packed
again, so each change below the resolution of a raw weight is lost.

Rewards and punishments that decide on pairs of spikes (Izhikevich 2007, Cereb Cortex 17:2443).

STDP changes the *eligibility* of a synapse, which decays with ``tau_c``. A reward raises the dopamine of its
target, which decays with ``tau_d``, a punishment lowers it. The weight grows by the integral of the product.
The history of the target holds both, so the weights of a row change only when its source neuron spikes.

The released binaries multiply by the constant of the integral first, and find the marks of rewards from the
end of a history even where later entries do not yet count.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nrp_brain_spinnaker.machine.fixed_point import mul, wrap
from nrp_brain_spinnaker.machine.stdp_rows import (
    BACK_PROPAGATES,
    C_LENGTH,
    C_SHIFT,
    CREDIT,
    D_LENGTH,
    D_SHIFT,
    HIGHEST,
    LOWEST,
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
    C,
    D,
    StdpRows,
    X,
    Y,
    add_event,
    after_source,
    after_target,
    decayed,
    last_until,
    slow_trace,
    stored,
)
from nrp_brain_spinnaker.machine.synaptic_inputs import Ring, add_entry
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit


class Rewards(NamedTuple):
    """Synapses that reward or punish, ordered by source neuron.

    Args:
        start: first synapse of each global id, shape ``(network.size + 1,)``.
        target: simulated neuron of each synapse.
        dopamine: s4.11, less than 0 for a punishment.
    """

    start: IntArray
    target: IntArray
    dopamine: IntArray


@jit
def deliver_rewards(rewards: Rewards | None, rows: StdpRows, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) in ``tick`` through the synapses that reward or punish."""
    if rewards is None:
        return
    for k in range(rewards.start[neuron], rewards.start[neuron + 1]):
        i = rewards.target[k]
        rule, last = rows.rules[rows.rule_of[i]], rows.history_count[i]
        elapsed, trace = tick - rows.history_tick[i, last], rows.history_trace[i, last]
        trace = decayed(rows.decays, trace, rule[MINUS], rule[MINUS_LENGTH], elapsed)
        dopamine = stored(
            dopamine_after(rows.decays, rule, rows.history_dopamine[i, last], elapsed) + rewards.dopamine[k]
        )
        add_event(rows, i, tick, trace, 0, dopamine, 1)


@jit
def dopamine_after(decays: IntArray, rule: IntArray, dopamine: int, elapsed: int) -> int:
    """Return the dopamine of a neuron some ticks after an entry of its history."""
    return decayed(decays, dopamine, rule[D], rule[D_LENGTH], elapsed >> D_SHIFT)


@jit
def update_modulated(rows: StdpRows, rule: IntArray, row: int, k: int, tick: int) -> int:
    """Update the eligibility of synapse ``k`` up to a spike in ``tick``; return its raw weight."""
    i = rows.line[k] % rows.rule_of.size
    ticks, count, before = rows.history_tick[i], rows.history_count[i], rows.last_tick[row]
    delay = np.int64(rows.delay[k]) * rule[BACK_PROPAGATES]
    weight = np.int64(rows.weight[k]) << rule[SHIFT]
    eligibility = np.int64(rows.eligibility[k]) << rule[SHIFT]
    end = last_until(ticks, count, max(tick - delay, 0))
    begin = last_until(ticks, end, max(before - delay, 0))
    dopamine = (
        dopamine_after(rows.decays, rule, rows.history_dopamine[i, begin], before - ticks[begin])
        if begin > 0
        else 0
    )
    marks = rows.history_marks[i] >> (count + 1 - (end - begin))
    at = before
    for entry in range(begin + 1, end + 1):
        passed = ticks[entry] + delay - at
        weight += _credit(rows.decays, rule, eligibility, dopamine, passed)
        eligibility = _faded(rows.decays, rule, eligibility, passed)
        if marks & 1 == 0:
            eligibility = after_target(rows, rule, row, i, entry, delay, eligibility)
        marks >>= 1
        at, dopamine = ticks[entry] + delay, rows.history_dopamine[i, entry]
    if end > 0:
        weight += _credit(rows.decays, rule, eligibility, dopamine, tick - at)
        eligibility = _faded(rows.decays, rule, eligibility, tick - at)
        eligibility = after_source(rows, rule, row, i, end, tick - ticks[end] - delay, eligibility)
    rows.eligibility[k] = (eligibility >> rule[SHIFT]) & 0xFFFF
    return int((min(max(wrap(weight), rule[LOWEST]), rule[HIGHEST]) >> rule[SHIFT]) & 0xFFFF)


@jit
def _credit(decays: IntArray, rule: IntArray, eligibility: int, dopamine: int, passed: int) -> int:
    """Return the change of a weight in some ticks."""
    if dopamine == 0:
        return 0
    both = decayed(decays, _factor(decays, rule, passed), rule[D], rule[D_LENGTH], passed >> D_SHIFT)
    return mul(mul(mul(eligibility, rule[CREDIT]), dopamine << 4), (both - TRACE_ONE) << 4)


@jit
def _faded(decays: IntArray, rule: IntArray, eligibility: int, passed: int) -> int:
    return mul(eligibility, _factor(decays, rule, passed) << 4)


@jit
def _factor(decays: IntArray, rule: IntArray, passed: int) -> int:
    return decayed(decays, TRACE_ONE, rule[C], rule[C_LENGTH], passed >> C_SHIFT)


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
