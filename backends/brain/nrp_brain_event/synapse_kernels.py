"""The kernels of synapse laws, compiled into one for each purpose; the record of a synapse selects its own.

The share of a law is ``share(synapse, t)``: the part of the weight with which a spike emitted at t (ms)
arrives. A rule of plasticity is ``on_source(rule, synapse, slow, post_t, t)`` and ``on_target`` with the same
arguments: they update weight and traces for a spike of the source or of the target that the synapse processes
at t (ms), after one of the target at ``post_t``. The tables are in :mod:`nrp_brain_event.synapse_laws`.

A change of a weight is a share of ``w_max (d / w_max)^mu``, where d is the distance of the weight from the
limit: ``w_max`` itself for mu = 0 (additive), d for mu = 1 (multiplicative; Morrison, Diesmann & Gerstner
2008, Biol Cybern 98:459), and powers between (Gütig et al. 2003, J Neurosci 23:3697).

Plastic synapses process the spikes of their source and target in the order in which these reach them.

A synapse processes a spike of its source after the axonal part of its delay, and one of its target after the
dendritic part. What they do to the weight is the rule's: see :mod:`nrp_brain_event.synapse_kernels`.

A synapse is updated when a spike reaches its target: then all earlier spikes of the target are known for any
delay. A target stores a spike until all its synapses have processed it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import exp, inf
from typing import Any, Final

from nrp_brain_event.handles import call
from nrp_brain_event.random_numbers import uniform
from nrp_brain_event.records import Array, Cell, Clock, Plastic, Rule, Slow, constant
from nrp_brain_event.synapse_laws import NEUROMODULATED, RULES, SHARES
from nrp_core._support.jit import inlined, jit
from nrp_core.brain.devices import short_term
from nrp_core.brain.devices.short_term import utilization
from nrp_core.clock import MS_PER_S
from nrp_core.network.equations.synapse import SYNAPSE_TYPE
from nrp_core.network.synapses import (
    MULTIQUANTAL,
    SIMPLE_STOCHASTIC,
    STOCHASTIC_TSODYKS_MARKRAM,
    TSODYKS_MARKRAM,
)

Kernel = Callable[..., Any]
Share = Callable[[Any, float], float]

# -- shares


@jit
def simple_stochastic_share(synapse: Any, t: float) -> float:
    """Return 1 with the probability ``p``, else 0."""
    synapse.t = t
    return 1.0 if uniform(synapse) < synapse.p else 0.0


@jit
def stochastic_tsodyks_markram_share(synapse: Any, t: float) -> float:
    """Return 1 if a spike emitted at t (ms) releases the vesicle, else 0."""
    dt = t - synapse.t
    synapse.u, synapse.t = utilization(synapse, dt), t
    if synapse.empty and uniform(synapse) < 1.0 - exp(-dt / synapse.tau_rec):
        synapse.empty = 0.0
    if not synapse.empty and uniform(synapse) < synapse.u:
        synapse.empty = 1.0
        return 1.0
    return 0.0


@jit
def multiquantal_share(synapse: Any, t: float) -> float:
    """Return the share of the sites that a spike emitted at t (ms) empties."""
    dt = t - synapse.t
    synapse.u, synapse.t = utilization(synapse, dt), t
    synapse.empty -= _count(synapse, synapse.empty, 1.0 - exp(-dt / synapse.tau_rec))
    released = _count(synapse, synapse.n - synapse.empty, synapse.u)
    synapse.empty += released
    return float(released / synapse.n)


@jit
def _count(synapse: Any, n: float, probability: float) -> float:
    """Return how many of n sites change."""
    count = 0.0
    for _ in range(int(n)):
        if uniform(synapse) < probability:
            count += 1.0
    return count


# -- traces of spikes, and how a weight limits its own change

SIMULTANEOUS: Final = 1e-9
"""Tolerance of equal times in floating point, ms."""


@jit
def trace(last: float, before: float, t: float, tau: float) -> float:
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


@jit
def span_up(rule: Any, synapse: Any) -> float:
    """Return the amount that an increase is a fraction of."""
    return _span(rule.w_max - synapse.weight, rule.mu_plus, rule.w_max)


@jit
def span_down(rule: Any, synapse: Any) -> float:
    """Return the amount that a decrease is a fraction of."""
    return _span(synapse.weight - rule.w_min, rule.mu_minus, rule.w_max)


@jit
def _span(distance: float, mu: float, largest: float) -> float:
    if mu == 0.0:
        return largest
    if mu == 1.0:
        return distance
    return float(largest * (max(distance, 0.0) / largest) ** mu)


@jit
def change(rule: Any, synapse: Any, share: float, span: float) -> None:
    """Change the weight by a share of ``span``, clipped at the limit in the direction of the share."""
    if share > 0.0:
        synapse.weight = min(synapse.weight + share * span, rule.w_max)
    elif share < 0.0:
        synapse.weight = max(synapse.weight + share * span, rule.w_min)


# PyNN's SpikePairRule over all pairs.
#
# For two spikes at a distance dt the later one changes the weight, by
#
# - ``A_plus f exp(-dt / tau_plus)`` upwards if the target's came later,
# - ``A_minus f exp(-dt / tau_minus)`` downwards if it came first (a negative A has the opposite effect),
#
# with f as in ``span_up`` and ``span_down``. Simultaneous spikes have no effect.


@jit
def spike_pair_on_source(rule: Any, synapse: Any, _slow: Any, post_t: float, t: float) -> None:
    """Depress the synapse by the earlier spikes of its target."""
    depression = rule.A_minus * trace(post_t, synapse.post_trace, t, rule.tau_minus)
    change(rule, synapse, -depression, span_down(rule, synapse))
    synapse.pre_trace = (synapse.pre_trace + 1.0) * exp((synapse.pre_t - t) / rule.tau_plus)
    synapse.pre_t = t


@jit
def spike_pair_on_target(rule: Any, synapse: Any, _slow: Any, post_t: float, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its source."""
    potentiation = rule.A_plus * trace(synapse.pre_t, synapse.pre_trace, t, rule.tau_plus)
    change(rule, synapse, potentiation, span_up(rule, synapse))
    synapse.post_trace = (synapse.post_trace + 1.0) * exp((post_t - t) / rule.tau_minus)


# PyNN's Vogels2011Rule over all pairs (Vogels et al. 2011, Science 334:1569).
#
# Each pair of spikes at a distance dt, in any order, adds ``eta exp(-dt / tau)``; each spike of the source
# takes away ``2 eta rho tau``. A simultaneous pair counts once.


@jit
def vogels_on_source(rule: Any, synapse: Any, _slow: Any, post_t: float, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its target, and depress it by a constant."""
    near = (synapse.post_trace + 1.0) * exp((post_t - t) / rule.tau)
    change(rule, synapse, rule.eta * (near - 2.0 * rule.rho * rule.tau / MS_PER_S), 1.0)
    synapse.pre_trace = (synapse.pre_trace + 1.0) * exp((synapse.pre_t - t) / rule.tau)
    synapse.pre_t = t


@jit
def vogels_on_target(rule: Any, synapse: Any, _slow: Any, post_t: float, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its source."""
    near = (synapse.pre_trace + 1.0) * exp((synapse.pre_t - t) / rule.tau)
    change(rule, synapse, rule.eta * near, 1.0)
    synapse.post_trace = (synapse.post_trace + 1.0) * exp((post_t - t) / rule.tau)


# The triplet rule of Pfister & Gerstner (2006, J Neurosci 26:9673), all to all, with additive weights.
#
# With the traces r1 (``tau_plus``) and r2 (``tau_x``) of the source's spikes, and o1 (``tau_minus``) and o2
# (``tau_y``) of the target's, a spike of the target adds ``w_max r1 (A_plus + A3_plus o2)``, and one of the
# source takes away ``w_max o1 (A_minus + A3_minus r2)``. All traces are those before the spike; simultaneous
# spikes have no effect on each other.


@jit
def spike_triplet_on_source(rule: Any, synapse: Any, slow: Any, post_t: float, t: float) -> None:
    """Depress the synapse by the earlier spikes of its target; earlier spikes of its source increase this."""
    own = trace(synapse.pre_t, slow.pre_slow, t, rule.tau_x)
    of_target = trace(post_t, synapse.post_trace, t, rule.tau_minus)
    change(rule, synapse, -of_target * (rule.A_minus + rule.A3_minus * own), rule.w_max)
    passed = exp((synapse.pre_t - t) / rule.tau_plus)
    synapse.pre_trace, slow.pre_slow, synapse.pre_t = (synapse.pre_trace + 1.0) * passed, own, t


@jit
def spike_triplet_on_target(rule: Any, synapse: Any, slow: Any, post_t: float, t: float) -> None:
    """Potentiate the synapse by the earlier spikes of its source, more after earlier ones of its target."""
    own = trace(post_t, slow.post_slow, t, rule.tau_y)
    of_source = trace(synapse.pre_t, synapse.pre_trace, t, rule.tau_plus)
    change(rule, synapse, of_source * (rule.A_plus + rule.A3_plus * own), rule.w_max)
    passed = exp((post_t - t) / rule.tau_minus)
    synapse.post_trace, slow.post_slow = (synapse.post_trace + 1.0) * passed, own


# -- laws given as equations: each synapse has a kernel of its own


@jit
def equation_share(synapse: Any, t: float) -> float:
    """Return the share of the weight with which a spike emitted at t (ms) arrives, and update the synapse."""
    call(synapse.own, (synapse, t))
    return float(synapse.share)


@jit
def equation_on_source(rule: Any, synapse: Any, slow: Any, _post_t: float, t: float) -> None:
    """Update a synapse for a spike of its source."""
    call(rule.own, (rule, synapse, slow, t, 0))


@jit
def equation_on_target(rule: Any, synapse: Any, slow: Any, _post_t: float, t: float) -> None:
    """Update a synapse for a spike of its target."""
    call(rule.own, (rule, synapse, slow, t, 1))


# -- rewards decide on the changes: a kernel that only such networks compile

SOURCE: Final = constant(0)
TARGET: Final = constant(1)
NEITHER: Final = constant(2)
"""The side of a synapse whose spike it processes."""


@jit
def neuromodulated_on_source(rule: Any, synapse: Any, slow: Any, post_t: float, t: float) -> None:
    """Update weight, eligibility and traces for a spike of the source."""
    call(rule.own, (rule, synapse, slow, post_t, t, SOURCE, rule.dopamine))


@jit
def neuromodulated_on_target(rule: Any, synapse: Any, slow: Any, post_t: float, t: float) -> None:
    """Update weight, eligibility and traces for a spike of the target."""
    call(rule.own, (rule, synapse, slow, post_t, t, TARGET, rule.dopamine))


@jit
def settle(rule: Any, synapse: Plastic, slow: Slow, t: float) -> None:
    """Update to a time (ms), including the variables that change between spikes."""
    if rule.law == _NEUROMODULATED:
        weight = synapse.weight
        call(rule.own, (rule, synapse, slow, -inf, t, NEITHER, rule.dopamine))
        if rule.frozen:
            synapse.weight = weight
    elif rule.law == _EQUATIONS:
        call(rule.own, (rule, synapse, slow, t, NEITHER))


# -- one kernel for each purpose


def one_of(kernels: Sequence[Kernel]) -> Kernel:
    """Return a kernel that calls the one selected by ``law`` of its first argument; a single one itself."""
    *others, chosen = kernels
    for number, kernel in reversed(list(enumerate(others))):
        chosen = _either(number, kernel, chosen)
    return chosen


def _either(number: int, kernel: Kernel, other: Kernel) -> Kernel:
    def either(selecting: Any, *arguments: Any) -> Any:
        if selecting.law == number:
            return kernel(selecting, *arguments)
        return other(selecting, *arguments)

    return jit(either)


_SHARES: Final[Mapping[str, Share]] = {
    TSODYKS_MARKRAM: short_term.released_share,
    SIMPLE_STOCHASTIC: simple_stochastic_share,
    STOCHASTIC_TSODYKS_MARKRAM: stochastic_tsodyks_markram_share,
    MULTIQUANTAL: multiquantal_share,
    SYNAPSE_TYPE: equation_share,
}
_RULES: Final[Mapping[str, tuple[Kernel, Kernel]]] = {
    "SpikePairRule": (spike_pair_on_source, spike_pair_on_target),
    "Vogels2011Rule": (vogels_on_source, vogels_on_target),
    "PfisterSpikeTripletRule": (spike_triplet_on_source, spike_triplet_on_target),
    SYNAPSE_TYPE: (equation_on_source, equation_on_target),
    NEUROMODULATED: (neuromodulated_on_source, neuromodulated_on_target),
}
_NEUROMODULATED: Final = RULES.index(NEUROMODULATED)
_EQUATIONS: Final = RULES.index(SYNAPSE_TYPE)

released_share: Share = one_of([_SHARES[law] for law in SHARES])
on_source = one_of([_RULES[rule][0] for rule in RULES])
on_target = one_of([_RULES[rule][1] for rule in RULES])


_MANY: Final = 64
"""Number of stored spikes of a target at which it frees those that are not needed."""


@inlined
def slow_of(slow: Array, synapse: int) -> Slow:
    """Return the further state of a synapse."""
    found: Slow = slow[min(synapse, len(slow) - 1)]
    return found


@jit
def transmit(synapse: Plastic, slow: Slow, rule: Rule, cell: Cell, events: Array, arrival: float) -> float:
    """Update the synapse for a spike that reaches the target at ``arrival``; return its weight there."""
    t = arrival - synapse.dendritic_delay
    catch_up(synapse, slow, rule, cell, events, t + SIMULTANEOUS)
    weight = synapse.weight
    on_source(rule, synapse, slow, _last_of_target(synapse, events), t)
    if rule.frozen:
        synapse.weight = weight
    return float(synapse.weight * rule.sign)


@jit
def catch_up(synapse: Plastic, slow: Slow, rule: Rule, cell: Cell, events: Array, until: float) -> None:
    """Update the synapse for the spikes of the target up to a time."""
    weight = synapse.weight
    index = events[synapse.last_seen].after if synapse.last_seen >= 0 else cell.first_stored
    while index >= 0 and events[index].time + synapse.dendritic_delay <= until:
        post_t = _last_of_target(synapse, events)
        on_target(rule, synapse, slow, post_t, events[index].time + synapse.dendritic_delay)
        synapse.last_seen = index
        index = events[index].after
    if rule.frozen:
        synapse.weight = weight


@inlined
def _last_of_target(synapse: Plastic, events: Array) -> float:
    """Return when the synapse processed the last spike of its target, ms."""
    if synapse.last_seen < 0:
        return -inf
    return float(events[synapse.last_seen].time + synapse.dendritic_delay)


@jit
def store_spike(
    cell: Cell, first: int, last: int, synapses: Array, slow: Array, rules: Array, clock: Clock, events: Array
) -> None:
    """Store the present spike of a cell for its plastic synapses from ``first`` to ``last``.

    There must be a free event.
    """
    if cell.n_stored >= _MANY:
        _forget(cell, first, synapses[first:last], slow, rules, clock, events)
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
    now: float, cells: Array, synapses: Array, slow: Array, rules: Array, events: Array, passed: Array
) -> None:
    """Update synapses for all spikes that have reached them by now.

    Args:
        now: the time of the engine, ms.
        cells: the cells of the engine.
        synapses: the synapses of the engine, which change.
        slow: their further state.
        rules: the rules of the engine.
        events: the events of the engine; those that have passed their synapses get their weights.
        passed: indices of these events, not yet at their targets, in order of the time at which they passed.
    """
    for index in passed:
        event = events[index]
        synapse, more = synapses[~event.target], slow_of(slow, ~event.target)
        rule, cell = rules[synapse.rule], cells[synapse.target >> 1]
        event.weight = transmit(synapse, more, rule, cell, events, event.time)
        event.target = synapse.target
    for k in range(len(synapses)):
        synapse = synapses[k]
        catch_up(synapse, slow_of(slow, k), rules[synapse.rule], cells[synapse.target >> 1], events, now)
        settle(rules[synapse.rule], synapse, slow_of(slow, k), now)


@jit
def synapses_at(
    now: float, cells: Array, synapses: Array, slow: Array, rules: Array, events: Array,
    passed: Array, arrivals: Array, rows: Array, own: Array, more: Array,
) -> None:  # fmt: skip
    """Store the present state of synapses, after all spikes that have reached them; no synapse changes.

    Args:
        now: as for :func:`bring_up_to`.
        cells: the same.
        synapses: the same.
        slow: the same.
        rules: the same.
        events: the same.
        passed: the synapses, ascending, of the spikes that have passed them and are not yet at their targets.
        arrivals: when these will be there, ms; those of one synapse in order.
        rows: the synapses to read.
        own: their records then.
        more: their further state then.
    """
    for k in range(len(rows)):
        own[k], more[k] = synapses[rows[k]], slow_of(slow, rows[k])
        synapse, rule = own[k], rules[synapses[rows[k]].rule]
        cell = cells[synapse.target >> 1]
        n = first_of(passed, rows[k])
        while n < len(passed) and passed[n] == rows[k]:
            transmit(synapse, more[k], rule, cell, events, arrivals[n])
            n += 1
        catch_up(synapse, more[k], rule, cell, events, now)
        settle(rule, synapse, more[k], now)


@jit
def first_of(ascending: Array, value: int) -> int:
    """Return the first place of numbers at or above a value."""
    low, high = 0, len(ascending)
    while low < high:
        middle = (low + high) // 2
        if ascending[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@jit
def _forget(
    cell: Cell, first: int, synapses: Array, slow: Array, rules: Array, clock: Clock, events: Array
) -> None:
    """Free the spikes that all synapses of a cell have processed, except the last one."""
    first_needed = cell.n_fired
    for k in range(len(synapses)):
        synapse = synapses[k]
        # spikes in transit have passed the synapse after this
        until = cell.wake - synapse.dendritic_delay
        catch_up(synapse, slow_of(slow, first + k), rules[synapse.rule], cell, events, until)
        first_needed = min(first_needed, events[synapse.last_seen].target if synapse.last_seen >= 0 else 0)
    while events[cell.first_stored].target < first_needed:
        index = cell.first_stored
        cell.first_stored = events[index].after
        events[index].after = clock.free
        clock.free = index
        clock.n_free += 1
        cell.n_stored -= 1
