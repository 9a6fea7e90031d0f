"""Spike-timing-dependent plasticity: the machine's rules for pairs of spikes, with deferred updates.

By the pair rule a spike of the source weakens a synapse. By that of Vogels et al. (2011, Science 334:1569)
it strengthens it by the trace of the target, less a constant ``ALPHA``. The weights of a row change only when
its source neuron spikes; until then the spikes of its targets are kept in short histories. Traces are s4.11
and decay by look-up tables; weights are unpacked to s16.15 and packed again, so each change below the
resolution of a raw weight is lost.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_brain_spinnaker.machine.fixed_point import mul
from nrp_brain_spinnaker.machine.ring import Ring, WeightArray, add_entry
from nrp_core._support.arrays import IndexArray, IntArray
from nrp_core._support.jit import jit

TRACE_ONE: Final = 1 << 11
"""1.0 in s4.11."""
HISTORY: Final = 16
"""Entries of a history; the first is a dummy, so 15 spikes are stored."""

A_PLUS, A_MINUS, W_MIN, W_MAX, MULTIPLICATIVE, SHIFT, BACK_PROPAGATES, VOGELS, ALPHA, LEAST = range(10)
PLUS_START, PLUS_LENGTH, MINUS_START, MINUS_LENGTH = range(10, 14)
RULE_COLUMNS: Final = 14


class StdpRows(NamedTuple):
    """Plastic synapses: rows of one projection and one source neuron.

    Args:
        start: first row of each global id, shape ``(network.size + 1,)``.
        first: first synapse of each row, shape ``(n_rows + 1,)``.
        rule, last_tick, trace: per row; rule -1 for constant weights.
        line, weight, delay: per synapse.
        rules: one per projection, shape ``(n_rules, RULE_COLUMNS)``.
        decays: the look-up tables of all rules, s4.11.
        rule_of: the rule with the table for each neuron's trace, -1 for none, shape ``(n,)``.
        history_count: index of the last entry, shape ``(n,)``.
        history_tick, history_trace: shape ``(n, HISTORY)``.
    """

    start: IntArray
    first: IntArray
    rule: IntArray
    last_tick: IntArray
    trace: IntArray
    line: IndexArray
    weight: WeightArray
    delay: WeightArray
    rules: IntArray
    decays: IntArray
    rule_of: IntArray
    history_count: IntArray
    history_tick: IntArray
    history_trace: IntArray


def changing_rows(rows: StdpRows) -> list[npt.NDArray[Any]]:
    """Return the arrays that running changes."""
    return [
        rows.weight, rows.last_tick, rows.trace, rows.history_count, rows.history_tick, rows.history_trace,
    ]  # fmt: skip


@jit
def remember(rows: StdpRows, i: int, tick: int) -> None:
    """Store a spike of neuron ``i`` in its history, if it has plastic input."""
    if rows.rule_of.size == 0 or rows.rule_of[i] < 0:
        return
    ticks, traces, count = rows.history_tick[i], rows.history_trace[i], rows.history_count[i]
    rule = rows.rules[rows.rule_of[i]]
    decay = _looked_up(rows.decays, rule[MINUS_START], rule[MINUS_LENGTH], tick - ticks[count])
    trace = _grown(traces[count], decay)
    if count == HISTORY - 1:
        for entry in range(1, count):
            ticks[entry], traces[entry] = ticks[entry + 1], traces[entry + 1]
    else:
        count += 1
    ticks[count], traces[count], rows.history_count[i] = tick, trace, count


@jit
def deliver_plastic(rows: StdpRows, ring: Ring, neuron: int, tick: int) -> None:
    """Send a spike of a neuron (global id) in ``tick`` through its plastic synapses, updating them first."""
    for row in range(rows.start[neuron], rows.start[neuron + 1]):
        deliver_row(rows, ring, row, rows.first[row + 1], tick)


@jit
def deliver_row(rows: StdpRows, ring: Ring, row: int, last: int, tick: int) -> None:
    """Send a spike in ``tick`` through the synapses of a row, which end before ``last``."""
    mask = ring.slots.shape[0] - 1
    if rows.rule[row] < 0:
        for k in range(rows.first[row], last):
            slot = (tick + np.int64(rows.delay[k])) & mask
            add_entry(ring, slot, rows.line[k], np.int64(rows.weight[k]))
        return
    rule = rows.rules[rows.rule[row]]
    for k in range(rows.first[row], last):
        weight = _updated(rows, rule, row, k, tick)
        rows.weight[k] = weight
        add_entry(ring, (tick + np.int64(rows.delay[k])) & mask, rows.line[k], weight)
    elapsed = tick - rows.last_tick[row]
    decay = _looked_up(rows.decays, rule[PLUS_START], rule[PLUS_LENGTH], elapsed)
    rows.last_tick[row], rows.trace[row] = tick, _grown(rows.trace[row], decay)


@jit
def _updated(rows: StdpRows, rule: IntArray, row: int, k: int, tick: int) -> int:
    """Return the raw weight of synapse ``k`` after all pairs up to a spike in ``tick``."""
    i = rows.line[k] % rows.rule_of.size
    ticks, traces = rows.history_tick[i], rows.history_trace[i]
    delay = np.int64(rows.delay[k]) * rule[BACK_PROPAGATES]
    before = rows.last_tick[row]
    weight = np.int64(rows.weight[k]) << rule[SHIFT]
    last = _last_until(ticks, rows.history_count[i], max(tick - delay, 0))
    for entry in range(_last_until(ticks, last, max(before - delay, 0)) + 1, last + 1):
        elapsed = ticks[entry] + delay - before
        if elapsed > 0:
            decay = _looked_up(rows.decays, rule[PLUS_START], rule[PLUS_LENGTH], elapsed)
            weight = _potentiated(rule, weight, ((rows.trace[row] * decay) >> 11) << 4)
    if last > 0:
        elapsed = tick - ticks[last] - delay
        decay = _looked_up(rows.decays, rule[MINUS_START], rule[MINUS_LENGTH], elapsed)
        near = (traces[last] * decay) >> 11
        if rule[VOGELS]:
            weight = max(_potentiated(rule, weight, (near - rule[ALPHA]) << 4), rule[LEAST])
        else:
            weight = _depressed(rule, weight, near << 4)
    return int((weight >> rule[SHIFT]) & 0xFFFF)


@jit
def _last_until(ticks: IntArray, entry: int, tick: int) -> int:
    """Return the last entry up to ``entry`` that is not after ``tick``; 0 is the dummy."""
    while entry > 0 and ticks[entry] > tick:
        entry -= 1
    return entry


@jit
def _potentiated(rule: IntArray, weight: int, trace: int) -> int:
    if rule[MULTIPLICATIVE]:
        return int(weight + mul(mul(rule[W_MAX] - weight, rule[A_PLUS]), trace))
    return int(min(weight + mul(rule[A_PLUS], trace), rule[W_MAX]))


@jit
def _depressed(rule: IntArray, weight: int, trace: int) -> int:
    if rule[MULTIPLICATIVE]:
        return int(weight - mul(mul(weight - rule[W_MIN], rule[A_MINUS]), trace))
    return int(max(weight - mul(rule[A_MINUS], trace), rule[W_MIN]))


@jit
def _looked_up(decays: IntArray, start: int, length: int, elapsed: int) -> int:
    return int(decays[start + elapsed]) if elapsed < length else 0


@jit
def _grown(trace: int, decay: int) -> int:
    """Decay a trace and add a spike; the trace is stored in 16 bits."""
    return ((((trace * decay) >> 11) + TRACE_ONE + 0x8000) & 0xFFFF) - 0x8000
