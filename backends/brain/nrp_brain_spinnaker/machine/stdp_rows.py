"""The arrays of plastic synapses, the settings of their rules, and the histories of their targets."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy.typing as npt

from nrp_brain_spinnaker.machine.ring import WeightArray
from nrp_core._support.arrays import IndexArray, IntArray
from nrp_core._support.jit import jit

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
    """Return a trace as it is stored, in 16 bits."""
    return ((trace + 0x8000) & 0xFFFF) - 0x8000
