"""The arrays of plastic synapses, the settings of their rules, and the histories of their targets.

The machine's rules for pairs and triplets of spikes: how a weight changes, in s16.15.

By the pair rules a spike of the source weakens a synapse, with all spikes of the target or only the nearest
one. By that of Vogels et al. (2011, Science 334:1569) it strengthens it by the trace of the target, less a
constant ``ALPHA``. By that of Pfister & Gerstner (2006, J Neurosci 26:9673) slow traces of earlier spikes add
to both changes.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy.typing as npt

from nrp_brain_spinnaker.machine.fixed_point import mul
from nrp_brain_spinnaker.machine.synaptic_inputs import WeightArray
from nrp_core._support.arrays import IndexArray, IntArray
from nrp_core._support.jit import inlined, jit

TRACE_ONE: Final = 1 << 11
"""1.0 in s4.11."""
HISTORY: Final = 16
"""Entries of a history; the first is a dummy, so 15 spikes are stored."""

PAIRS, NEAREST_PAIRS, VOGELS, TRIPLETS = range(4)
"""The rules for times."""
A_PLUS, A_MINUS, A3_PLUS, A3_MINUS, W_MIN, W_MAX, MULTIPLICATIVE, SHIFT, BACK_PROPAGATES, LEAST = range(10)
TIMING, ALPHA, PLUS, PLUS_LENGTH, MINUS, MINUS_LENGTH, X, X_LENGTH, Y, Y_LENGTH = range(10, 20)
MODULATED, CREDIT, LOWEST, HIGHEST, C, C_LENGTH, D, D_LENGTH = range(20, 28)
RULE_COLUMNS: Final = 28
SLOW_SHIFT, C_SHIFT, D_SHIFT = 2, 4, 2
"""The tables for ``tau_x`` and ``tau_y``, ``tau_c``, and ``tau_d`` have an entry for 4, 16 and 4 ticks."""


class StdpRows(NamedTuple):
    """Plastic synapses: rows of one projection and one source neuron.

    Args:
        start: first row of each global id, shape ``(network.size + 1,)``.
        first: first synapse of each row, shape ``(n_rows + 1,)``.
        rule, last_tick, trace, slow: per row; rule -1 for constant weights; ``slow`` for triplets.
        line, weight, delay: per synapse.
        eligibility: the weight that pairs of spikes change if a reward decides, per synapse; else empty.
        rules: one per projection, shape ``(n_rules, RULE_COLUMNS)``.
        decays: the look-up tables of all rules, s4.11.
        rule_of: the rule with the table for each neuron's trace, -1 for none, shape ``(n,)``.
        history_count: index of the last entry, shape ``(n,)``.
        history_tick, history_trace: shape ``(n, HISTORY)``.
        history_slow, history_dopamine: the same for triplets and for rewards; else empty.
        history_marks: a bit for each entry that is a reward, shape ``(n,)``; else empty.
    """

    start: IntArray
    first: IntArray
    rule: IntArray
    last_tick: IntArray
    trace: IntArray
    slow: IntArray
    line: IndexArray
    weight: WeightArray
    delay: WeightArray
    eligibility: WeightArray
    rules: IntArray
    decays: IntArray
    rule_of: IntArray
    history_count: IntArray
    history_tick: IntArray
    history_trace: IntArray
    history_slow: IntArray
    history_dopamine: IntArray
    history_marks: IntArray


def changing_rows(rows: StdpRows) -> list[npt.NDArray[Any]]:
    """Return the arrays that running changes."""
    return [
        rows.weight, rows.eligibility, rows.last_tick, rows.trace, rows.slow, rows.history_count,
        rows.history_tick, rows.history_trace, rows.history_slow, rows.history_dopamine, rows.history_marks,
    ]  # fmt: skip


@jit
def add_event(
    rows: StdpRows, i: int, tick: int, trace: int, slow: int, dopamine: int, is_reward: int
) -> None:
    """Store a spike of neuron ``i``, or a reward (1) to it, in its history; the oldest may be dropped."""
    count = rows.history_count[i]
    is_full = count == HISTORY - 1
    if is_full:
        _move_down(rows.history_tick[i])
        _move_down(rows.history_trace[i])
    else:
        count += 1
    rows.history_tick[i, count], rows.history_trace[i, count], rows.history_count[i] = tick, trace, count
    if rows.history_slow.size:
        if is_full:
            _move_down(rows.history_slow[i])
        rows.history_slow[i, count] = slow
    if rows.history_marks.size:
        if is_full:
            _move_down(rows.history_dopamine[i])
            rows.history_marks[i] >>= 1
        rows.history_dopamine[i, count] = dopamine
        rows.history_marks[i] = (rows.history_marks[i] & ~(1 << count)) | (is_reward << count)


@jit
def _move_down(entries: IntArray) -> None:
    for entry in range(1, HISTORY - 1):
        entries[entry] = entries[entry + 1]


@jit
def last_until(ticks: IntArray, entry: int, tick: int) -> int:
    """Return the last entry up to ``entry`` that is not after ``tick``; 0 is the dummy."""
    while entry > 0 and ticks[entry] > tick:
        entry -= 1
    return entry


@jit
def decayed(decays: IntArray, trace: int, table: int, length: int, ticks: int) -> int:
    """Return a trace after some entries of a table (``ticks``, less than 0 for a time that wrapped)."""
    return (trace * decays[table + ticks]) >> 11 if 0 <= ticks < length else 0


@jit
def stored(trace: int) -> int:
    """Return a trace in its stored form of 16 bits."""
    return ((trace + 0x8000) & 0xFFFF) - 0x8000


@inlined
def after_target(
    rows: StdpRows, rule: IntArray, row: int, i: int, entry: int, delay: int, weight: int
) -> int:
    """Return a weight after a spike of its target, an entry in the history of neuron ``i``."""
    ticks = rows.history_tick[i]
    elapsed = ticks[entry] + delay - rows.last_tick[row]
    if elapsed <= 0:
        return weight
    if rule[TIMING] == NEAREST_PAIRS:  # the machine adds the delay to one of two spikes only
        first = ticks[entry] + delay - ticks[entry - 1] >= elapsed
        near = decayed(rows.decays, TRACE_ONE, rule[PLUS], rule[PLUS_LENGTH], elapsed) if first else 0
    else:
        near = decayed(rows.decays, rows.trace[row], rule[PLUS], rule[PLUS_LENGTH], elapsed)
    if rule[TIMING] == TRIPLETS:
        slow = (near * rows.history_slow[i, entry]) >> 11
        weight += mul(rule[A3_PLUS], slow << 4)
    return _potentiated(rule, weight, near << 4)


@inlined
def after_source(
    rows: StdpRows, rule: IntArray, row: int, i: int, last: int, elapsed: int, weight: int
) -> int:
    """Return a weight after a spike of its source, some ticks after the ``last`` entry for neuron ``i``."""
    trace = TRACE_ONE if rule[TIMING] == NEAREST_PAIRS else rows.history_trace[i, last]
    near = decayed(rows.decays, trace, rule[MINUS], rule[MINUS_LENGTH], elapsed)
    if rule[TIMING] == VOGELS:
        return int(max(_potentiated(rule, weight, (near - rule[ALPHA]) << 4), rule[LEAST]))
    if rule[TIMING] == TRIPLETS:
        weight -= mul(rule[A3_MINUS], ((near * rows.slow[row]) >> 11) << 4)
    return _depressed(rule, weight, near << 4)


@jit
def slow_trace(decays: IntArray, trace: int, table: int, length: int, before: int, tick: int) -> int:
    """Return the slow trace of a neuron just before a spike; ``before`` is the tick of the last one, or 0."""
    if before == 0:
        return 0
    return decayed(decays, stored(trace + TRACE_ONE), table, length, (tick - before) >> SLOW_SHIFT)


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
