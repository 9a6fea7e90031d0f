"""Dopamine over time, and how synapses learn from it (Izhikevich 2007, Cereb Cortex 17:2443).

A weight w follows the product of its eligibility c and the dopamine n above a baseline b::

    dw/dt = c (n + r - b)    dc/dt = -c / tau_c    dn/dt = -n / tau_d

STDP changes c, a reward n. A value r that is held, the reward of Florian's MSTDPET (2007, Neural Comput
19:1468), lowers the baseline. Between two of these events all three have a closed form. Dopamine is known
before the synapses reach a time, so it is a list of its jumps. For each interval between two jumps the
integral of ``exp(-t / tau_c) (n + r - b)`` is computed once for all synapses: passing an interval costs two
multiplications. Where n + r - b changes sign, the weight is clipped there.
"""

from __future__ import annotations

from math import exp, expm1, inf, log
from typing import Annotated, Any, Final, NamedTuple

import numpy as np

from nrp_brain_event.handles import address_of, opened
from nrp_brain_event.records import Array, Plastic, Record, Rule, Slow
from nrp_brain_event.synapse_kernels import (
    NEITHER,
    SOURCE,
    catch_up,
    settle,
    slow_of,
    spike_pair_on_source,
    spike_pair_on_target,
)
from nrp_brain_event.synapse_laws import NEUROMODULATED, RULES
from nrp_core._support.jit import COMPILED, inlined, jit

_LAW: Final = RULES.index(NEUROMODULATED)
MANY: Final = 64
"""Number of jumps after which those that all synapses have passed are dropped."""


class Modulator(Record):
    """The dopamine of a cell, or of all cells that share it."""

    tau_c: float
    tau_d: float
    tau_both: float
    """The inverse of ``1 / tau_c + 1 / tau_d``."""
    baseline: float
    w_min: float
    w_max: float
    shared: int
    first: int
    last: int
    n: int
    """Its list of jumps."""


class Jump(Record):
    """A change of dopamine, and the interval until the next one."""

    time: float
    dopamine: float
    """Just after the jump, without what is held."""
    held: float
    """Value that is added in the interval."""
    integral: float
    """Change of the weight in the interval for an eligibility of 1 at its beginning."""
    kept: float
    """Remaining share of the eligibility at its end."""
    turns: int
    """Whether dopamine passes the baseline in it."""
    before: int
    after: int


class Room(Record):
    """The list of free jumps."""

    free: int
    n_free: int


class Dopamine(NamedTuple):
    """The dopamine of a network.

    Args:
        modulators: ``Modulator``.
        jumps: ``Jump``, a pool.
        room: ``Room``, shape ``(1,)``.
        of_row: the modulator of the cell in each row, or -1.
    """

    modulators: Annotated[Array, Modulator]
    jumps: Annotated[Array, Jump]
    room: Annotated[Array, Room]
    of_row: Annotated[Array, np.int64]


@jit
def _change(modulator: Modulator, baseline: float, dopamine: float, span: float) -> float:
    """Return the change of a weight with an eligibility of 1, in a time after dopamine had a value."""
    rise = -dopamine * modulator.tau_both * expm1(-span / modulator.tau_both)
    return float(rise + baseline * modulator.tau_c * expm1(-span / modulator.tau_c))


@jit
def _passes(modulator: Modulator, baseline: float, dopamine: float, span: float) -> bool:
    """Return whether dopamine passes the baseline within a time."""
    later = dopamine * exp(-span / modulator.tau_d)
    return bool((dopamine - baseline) * (later - baseline) < 0.0)


@inlined
def _follow(modulator: Modulator, weight: float, change: float) -> float:
    return min(max(weight + change, modulator.w_min), modulator.w_max)


@jit
def _pass(
    modulator: Modulator, jump: Jump, weight: float, eligible: float, time: float, span: float
) -> tuple[float, float]:
    """Return weight and eligibility after a part of an interval."""
    dopamine = jump.dopamine * exp((jump.time - time) / modulator.tau_d)
    baseline = modulator.baseline - jump.held
    if _passes(modulator, baseline, dopamine, span):
        first = modulator.tau_d * log(dopamine / baseline)
        weight = _follow(modulator, weight, eligible * _change(modulator, baseline, dopamine, first))
        eligible *= exp(-first / modulator.tau_c)
        dopamine, span = baseline, span - first
    weight = _follow(modulator, weight, eligible * _change(modulator, baseline, dopamine, span))
    return weight, eligible * exp(-span / modulator.tau_c)


@jit
def bring(synapse: Plastic, slow: Slow, t: float, dopamine: Dopamine) -> None:
    """Update weight and eligibility to t; the latter is ``slow.pre_slow``, as of ``slow.post_slow``."""
    since = slow.post_slow
    if t <= since:
        return
    slow.post_slow = t
    number = dopamine.of_row[synapse.target >> 1]
    delay = 0.0 if dopamine.modulators[number].shared else synapse.dendritic_delay
    synapse.weight, slow.pre_slow = followed(
        dopamine, number, synapse.weight, slow.pre_slow, since - delay, t - delay
    )


@jit
def followed(
    dopamine: Dopamine, number: int, weight: float, eligible: float, time: float, end: float
) -> tuple[float, float]:
    """Return weight and eligibility after a time in which the weight follows a modulator."""
    if eligible == 0.0:
        return weight, eligible
    modulator, jumps = dopamine.modulators[number], dopamine.jumps
    index = modulator.last
    while jumps[index].time > time:
        index = jumps[index].before
    while time < end:
        jump = jumps[index]
        index = jump.after
        stop = min(jumps[index].time, end) if index >= 0 else end
        if time == jump.time and index >= 0 and stop == jumps[index].time and not jump.turns:
            weight = _follow(modulator, weight, eligible * jump.integral)
            eligible *= jump.kept
        else:
            weight, eligible = _pass(modulator, jump, weight, eligible, time, stop - time)
        time = stop
    return weight, eligible


@jit
def learn(
    rule: Rule, synapse: Plastic, slow: Slow, post_t: float, t: float, side: int, dopamine: Dopamine
) -> None:
    """Bring a synapse to t, and let STDP change its eligibility for a spike of a side."""
    bring(synapse, slow, t, dopamine)
    if side == NEITHER:
        return
    weight = synapse.weight
    synapse.weight = slow.pre_slow  # the rule and its limits are those of the eligibility
    if side == SOURCE:
        spike_pair_on_source(rule, synapse, slow, post_t, t)
    else:
        spike_pair_on_target(rule, synapse, slow, post_t, t)
    slow.pre_slow, synapse.weight = synapse.weight, weight


if COMPILED:
    from numba import carray

    def _kernel(
        rule: Any, synapse: Any, slow: Any, post_t: float, t: float, side: int, places: Any
    ) -> int:  # pragma: no cover - compiled
        learn(
            carray(rule, 1)[0], carray(synapse, 1)[0], carray(slow, 1)[0], post_t, t, side,
            opened(Dopamine, places),
        )  # fmt: skip
        return 0

else:

    def _kernel(rule: Any, synapse: Any, slow: Any, post_t: float, t: float, side: int, places: Any) -> int:
        learn(rule, synapse, slow, post_t, t, side, opened(Dopamine, places))
        return 0


def kernel() -> int:
    """Return the address of the kernel of a synapse that waits for rewards; it is compiled once."""
    records = Rule.dtype(), Plastic.dtype(), Slow.dtype()
    return address_of(_kernel, (*records, "float64", "float64", "int64", "*int64"))


@jit
def add(places: Array, numbers: Array, times: Array, amounts: Array) -> None:
    """Add to the dopamine of modulators at times (ms) that ascend for each; there must be room."""
    dopamine = opened(Dopamine, places)
    jumps, room = dopamine.jumps, dopamine.room[0]
    for k in range(len(numbers)):
        modulator = dopamine.modulators[numbers[k]]
        index, time = modulator.last, times[k]
        last = jumps[index]
        if time == last.time:
            last.dopamine += amounts[k]
            continue
        span = time - last.time
        if span < inf:
            baseline = modulator.baseline - last.held
            last.integral = _change(modulator, baseline, last.dopamine, span)
            last.kept = exp(-span / modulator.tau_c)
            last.turns = _passes(modulator, baseline, last.dopamine, span)
        new = room.free
        jump = jumps[new]
        room.free = jump.after
        room.n_free -= 1
        jump.time, jump.before, jump.after, jump.held = time, index, -1, last.held
        jump.dopamine = last.dopamine * exp(-span / modulator.tau_d) + amounts[k]
        last.after = modulator.last = new
        modulator.n += 1


@jit
def forget(
    now: float, cells: Array, synapses: Array, slow: Array, rules: Array, events: Array,
    places: Array, needed: Array,
) -> None:  # fmt: skip
    """Advance synapses that lag many jumps behind now (ms), and drop the earlier jumps.

    Args:
        now: the time of the engine.
        cells: as for :func:`nrp_brain_event.synapse_kernels.bring_up_to`.
        synapses: the same.
        slow: the same.
        rules: the same.
        events: the same.
        places: the dopamine that they follow.
        needed: work space, one number for each modulator.
    """
    dopamine = opened(Dopamine, places)
    needed[:] = inf
    for k in range(len(synapses)):
        synapse, own, rule = synapses[k], slow_of(slow, k), rules[synapses[k].rule]
        row = synapse.target >> 1
        if rule.law != _LAW or dopamine.modulators[dopamine.of_row[row]].n <= MANY:
            continue
        until = now - synapse.dendritic_delay  # spikes in transit have passed the synapse after this
        catch_up(synapse, own, rule, cells[row], events, until)
        settle(rule, synapse, own, until)
        number = dopamine.of_row[row]
        late = 0.0 if dopamine.modulators[number].shared else synapse.dendritic_delay
        needed[number] = min(needed[number], until - late)
    jumps, room = dopamine.jumps, dopamine.room[0]
    for number in range(len(dopamine.modulators)):
        modulator = dopamine.modulators[number]
        while modulator.n > MANY and jumps[jumps[modulator.first].after].time <= needed[number]:
            index = modulator.first
            modulator.first = jumps[index].after
            jumps[index].after = room.free
            room.free = index
            room.n_free += 1
            modulator.n -= 1


@jit
def _level(dopamine: Dopamine, number: int, t: float) -> float:
    index = dopamine.modulators[number].last
    while dopamine.jumps[index].time > t:
        index = dopamine.jumps[index].before
    jump = dopamine.jumps[index]
    return float(jump.dopamine * exp((jump.time - t) / dopamine.modulators[number].tau_d) + jump.held)


@jit
def levels(places: Array, rows: Array, t: float, out: Array) -> None:
    """Store the dopamine of the cells in rows at a time (ms), which is not before the last time of all."""
    dopamine = opened(Dopamine, places)
    for k in range(len(rows)):
        out[k] = _level(dopamine, dopamine.of_row[rows[k]], t)


def begin(dopamine: Dopamine) -> None:
    """Return to no dopamine at time 0."""
    modulators, jumps, n = dopamine.modulators, dopamine.jumps, len(dopamine.modulators)
    jumps[:] = np.zeros(1, jumps.dtype)
    jumps["time"], jumps["before"] = -inf, -1
    jumps["after"] = np.arange(1, len(jumps) + 1)
    jumps["after"][-1] = -1
    jumps["after"][:n] = -1
    modulators["first"] = modulators["last"] = np.arange(n)
    modulators["n"] = 1
    dopamine.room["free"], dopamine.room["n_free"] = n, len(jumps) - n
