"""The machine's rules for pairs and triplets of spikes: how a weight changes, in s16.15.

By the pair rules a spike of the source weakens a synapse, with all spikes of the target or only the nearest
one. By that of Vogels et al. (2011, Science 334:1569) it strengthens it by the trace of the target, less a
constant ``ALPHA``. By that of Pfister & Gerstner (2006, J Neurosci 26:9673) slow traces of earlier spikes add
to both changes.
"""

from __future__ import annotations

from nrp_brain_spinnaker.machine.fixed_point import mul
from nrp_brain_spinnaker.machine.stdp_rows import (
    A3_MINUS,
    A3_PLUS,
    A_MINUS,
    A_PLUS,
    ALPHA,
    LEAST,
    MINUS,
    MINUS_LENGTH,
    MULTIPLICATIVE,
    NEAREST_PAIRS,
    PLUS,
    PLUS_LENGTH,
    SLOW_SHIFT,
    TIMING,
    TRACE_ONE,
    TRIPLETS,
    VOGELS,
    W_MAX,
    W_MIN,
    StdpRows,
    decayed,
    stored,
)
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import inlined, jit


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
