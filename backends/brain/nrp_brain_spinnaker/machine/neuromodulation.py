"""Rewards and punishments that decide on pairs of spikes (Izhikevich 2007, Cereb Cortex 17:2443).

STDP changes the *eligibility* of a synapse, which decays with ``tau_c``. A reward raises the dopamine of its
target, which decays with ``tau_d``, a punishment lowers it. The weight grows by the integral of the product.
Both stand in the history of the target, so the weights of a row change only when its source neuron spikes.

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
    SHIFT,
    TRACE_ONE,
    C,
    D,
    StdpRows,
    add_event,
    decayed,
    last_until,
    stored,
)
from nrp_brain_spinnaker.machine.stdp_rules import after_source, after_target
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
