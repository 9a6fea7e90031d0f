"""The synapses of a network as tables of the engine, checked.

The plastic synapses of a network as tables of the engine, checked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import Final

import numpy as np

from nrp_brain_event import equation_synapses
from nrp_brain_event.records import JUMP, Array, Plastic, Rule, ShortTerm, Slow
from nrp_brain_event.synapse_laws import RULES, SHARES
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Network, Projection
from nrp_core.network.drawing import extremes, sorted_by
from nrp_core.network.indices import stored_form
from nrp_core.network.limits import distinct
from nrp_core.network.synapses import LAWS, SynapseLaw
from nrp_core.seeds import Seeds

_LIMITS: Final = ("w_min", "w_max")
_COLUMNS: Final = Rule.dtype().names or ()
_LONG_AGO_MS: Final = -np.inf
_SLOW_RULE: Final = "PfisterSpikeTripletRule"
"""The only rule with slow traces."""


def load_plastic(network: Network, projections: Sequence[Projection], row_of: IntArray) -> dict[str, Array]:
    """Return the tables of plastic synapses: parts of the engine by name.

    Args:
        network: the network.
        projections: the plastic ones, with the delays that count.
        row_of: rows of the cells by global id.

    Raises:
        NetworkError: a parameter is missing or impossible.
        CapabilityError: the rule is not supported.
    """
    first, places = places_of_plastic(network, row_of)
    table = np.zeros(sum(map(len, places.values())), Plastic.dtype())
    slow = np.zeros(len(table) if any(map(_needs_slow, projections)) else 1, Slow.dtype())
    rules = np.empty((0, len(_COLUMNS)))
    for projection in projections:
        own = places[projection.label]
        more, index = _rules(projection, network)
        table["rule"][own] = len(rules) + index
        rules = np.concatenate([rules, more])
        table["target"][own] = targets_of(projection, network, row_of)
        fraction = projection.synapse_parameters.get("dendritic_delay_fraction", np.ones(1))
        table["dendritic_delay"][own] = distinct(projection.delay_ms) * distinct(fraction)
    begin_plastic(network, table, slow, places)
    return {
        "plastic": table,
        "slow": slow,
        "first_plastic": first if len(table) else first[:0],
        "rules": _records(rules),
    }


def begin_plastic(network: Network, table: Array, slow: Array, places: Mapping[str, Array]) -> None:
    """Give plastic synapses the state at time 0.

    Args:
        network: the network.
        table: their records.
        slow: their further state.
        places: their rows by projection.
    """
    table["last_seen"] = -1
    table["pre_t"] = _LONG_AGO_MS
    table["pre_trace"] = table["post_trace"] = 0.0
    slow[:] = np.zeros(1, slow.dtype)
    for projection in network.projections:
        if projection.is_plastic:
            own = places[projection.label]
            table["weight"][own] = np.abs(distinct(projection.weight))
            if projection.equations is not None:
                equation_synapses.begin_plastic(table, slow, own, projection)


def places_of_plastic(network: Network, row_of: IntArray) -> tuple[IntArray, dict[str, Array]]:
    """Return the order of plastic synapses, which is that of the cells they end on.

    Returns:
        The place of the first synapse onto each cell and the number of all, and the places of the synapses of
        each projection.
    """
    plastic = [projection for projection in network.projections if projection.is_plastic]
    n = np.zeros(int(row_of.max(initial=-1)) + 2, np.int64)
    for projection in plastic:
        for _, post in projection.pairs():
            count_rows(row_of, network.offsets[projection.post], post, n)
    first = np.cumsum(n)
    at = first.copy()
    places: dict[str, Array] = {}
    for projection in plastic:
        found, begin = np.empty(projection.size, np.int32), 0
        for _, post in projection.pairs():
            number(row_of, network.offsets[projection.post], post, at, found[begin : begin + len(post)])
            begin += len(post)
        places[projection.label] = found
    return first, places


@jit
def count_rows(row_of: IntArray, offset: int, post: Array, n: IntArray) -> None:
    """Count the synapses onto each cell, one place after its row."""
    for k in range(len(post)):
        n[row_of[offset + post[k]] + 1] += 1


@jit
def number(row_of: IntArray, offset: int, post: Array, at: IntArray, out: Array) -> None:
    """Give synapses the next places of the cells they end on."""
    for k in range(len(post)):
        row = row_of[offset + post[k]]
        out[k] = at[row]
        at[row] += 1


def _needs_slow(projection: Projection) -> bool:
    if projection.equations is not None:
        return equation_synapses.needs_slow(projection)
    return _SLOW_RULE in projection.plasticity.values()


def parameter(projection: Projection, name: str) -> FloatArray:
    """Return a parameter of the synapses of a projection.

    Raises:
        NetworkError: it is missing.
    """
    if name not in projection.synapse_parameters:
        raise NetworkError(
            f"projection '{projection.label}': {projection.synapse_type} synapses need '{name}'"
        )
    return projection.synapse_parameters[name]


def _rules(projection: Projection, network: Network) -> tuple[FloatArray, IntArray]:
    """Return the distinct rows of ``Rule`` of a projection, and the row of each synapse, or one for all."""
    if projection.equations is None:
        columns, kernel = _parameters(projection)
    else:
        unit = network.populations[projection.post].weight_unit(projection.receptor)
        columns, kernel = equation_synapses.rules_of(projection, unit), projection.synapse_type
    negative = bool((distinct(projection.weight) < 0).any())
    if negative and (projection.weight > 0).any():
        raise NetworkError(f"projection '{projection.label}': plastic weights have one sign, not both")
    columns["sign"], columns["law"] = 1.0 - 2.0 * negative, list(RULES).index(kernel)
    each = [_differing(columns.get(name, np.zeros(1))) for name in _COLUMNS]
    varying = [values for values in each if len(values) > 1]
    if not varying:
        return np.column_stack(each), np.zeros(1, np.int64)
    _, found, index = np.unique(np.column_stack(varying), axis=0, return_index=True, return_inverse=True)
    rows = [values[found] if len(values) > 1 else np.repeat(values, len(found)) for values in each]
    return np.column_stack(rows), index.reshape(-1)


def _differing(values: float | FloatArray) -> FloatArray:
    """Return values; one if all are equal."""
    few = distinct(np.atleast_1d(values))
    return few[:1] if (few == few[:1]).all() else few


def _parameters(projection: Projection) -> tuple[dict[str, float | FloatArray], str]:
    """Return the parameters of a law by their names, and the name of its kernel."""
    law = LAWS[projection.synapse_type]
    chosen = law.chosen_parts(list(projection.plasticity.values()))
    if chosen is None:
        raise CapabilityError(f"projection '{projection.label}': {_unknown_parts(projection, law)}")
    parts = dict(chosen)
    columns: dict[str, float | FloatArray] = {}
    for part in parts.values():
        columns |= {name: parameter(projection, name) for name in part.parameters} | dict(part.implied)
    if not parts:
        columns |= {name: parameter(projection, name) for name in law.parameters}
    columns |= {
        name: np.abs(columns[name]) for name in _LIMITS if name in columns
    }  # magnitudes, as the weight
    return columns, next(name for name in RULES if name in (law.name, *parts))


def _unknown_parts(projection: Projection, law: SynapseLaw) -> str:
    valid = "; ".join(f"{part}: {', '.join(classes)}" for part, classes in law.parts.items())
    given = ", ".join(sorted(projection.plasticity.values())) or "none"
    return f"its plasticity is composed of {given}; it needs one of each part ({valid})"


def _records(rules: FloatArray) -> Array:
    table = np.zeros(len(rules), Rule.dtype())
    for name, column in zip(table.dtype.names or (), rules.T, strict=True):
        table[name] = column
    return table


_LEAST_DELAY_MS: Final = 1.0 / NS_PER_MS


def load_connections(network: Network, cells: Array, row_of: IntArray) -> dict[str, Array]:
    """Return the parts of the :class:`~nrp_brain_event.records.EngineArrays` that hold synapses, by name.

    Raises:
        NetworkError: a plasticity parameter is missing or invalid.
        CapabilityError: a plasticity rule is not supported.
    """
    projections = network.projections
    order, counts = _order(network)
    first = np.concatenate([[0], np.cumsum(counts)])
    dynamics, short_term = _short_term(network, cells, row_of)
    dynamics = dynamics[order] if len(short_term) else dynamics
    places = places_of_plastic(network, row_of)[1]
    target = _joined([_encoded(p, network, row_of, places) for p in projections], np.int32)[order]
    del places
    delay = _in_order([projection.delay_ms for projection in projections], order)
    weight = _in_order([projection.weight for projection in projections], order)
    del order
    static = target >= 0
    if len(short_term):
        static &= dynamics < 0
    plastic = load_plastic(network, [p for p in projections if p.is_plastic], row_of)
    return {
        "first": first,
        "target": target,
        "weight": weight,
        "delay": delay,
        "dynamics": dynamics,
        "bundle": _bundles(first, delay, static),
        "short_term": short_term,
        **plastic,
    }


def delay_range(network: Network) -> tuple[float, float]:
    """Return the shortest delay between neurons that are not sources, and the longest of all (ms).

    The spikes of sources are known before a window begins, so their delays do not limit it.

    Raises:
        NetworkError: a delay between neurons is too short.
    """
    shortest, longest = inf, 0.0
    for projection in network.projections:
        if projection.size == 0:
            continue
        delays = extremes(stored_form(projection, "delay_ms"))
        delay = float(delays.min())
        longest = max(longest, float(delays.max()))
        if network.populations[projection.pre].is_source:
            continue
        if delay < _LEAST_DELAY_MS:
            raise NetworkError(
                f"projection '{projection.label}' has a delay of {delay:g} ms; from one neuron to another "
                f"a spike takes at least {_LEAST_DELAY_MS:g} ms"
            )
        shortest = min(shortest, delay)
    return shortest, longest


def places_of_static(network: Network) -> dict[str, Array]:
    """Return the rows of the synapses that are not plastic in the engine's tables, by projection."""
    projections = network.projections
    order, _ = _order(network)
    rows = np.empty(len(order), order.dtype)
    rows[order] = np.arange(len(order), dtype=order.dtype)
    cuts = np.cumsum([projection.size for projection in projections])[:-1]
    parts = zip(projections, np.split(rows, cuts), strict=False)
    return {projection.label: part for projection, part in parts if not projection.is_plastic}


def _order(network: Network) -> tuple[Array, Array]:
    """Return the order of synapses: by neuron, then by delay; and the number of each neuron."""
    projections = network.projections
    pre = _joined([network.offsets[p.pre] + p.pre_index for p in projections], np.int32)
    kind = np.int32 if len(pre) < np.iinfo(np.int32).max else np.int64
    delays = [projection.delay_ms for projection in projections]
    if _common(delays) is not None:
        return sorted_by(pre, np.arange(len(pre), dtype=kind), network.size)
    order = np.lexsort((_joined(delays, np.float64), pre)).astype(kind)
    return order, np.bincount(pre, minlength=network.size)


def _common(parts: Sequence[FloatArray]) -> float | None:
    """Return the common value of all synapses, or None if they differ; 0 without synapses."""
    few = [_differing(part) for part in parts]
    values = {float(part[0]) for part in few if len(part)}
    return None if len(values) > 1 or any(len(part) > 1 for part in few) else next(iter(values), 0.0)


def _encoded(
    projection: Projection, network: Network, row_of: IntArray, places: Mapping[str, Array]
) -> Array:
    """Return the targets of synapses in the encoding of events."""
    if projection.is_plastic:
        return ~places[projection.label]
    return targets_of(projection, network, row_of)


def _in_order(parts: Sequence[FloatArray], order: Array) -> FloatArray:
    """Return the values of all synapses in their order in the engine."""
    value = _common(parts)
    return _joined(parts, np.float64)[order] if value is None else np.full(len(order), value)


def _bundles(first: Array, delay: Array, static: Array) -> Array:
    """Return the length of each run of static synapses of one neuron and delay at its first, else 0.

    It is negative if another run of the neuron follows.
    """
    begins = np.ones(len(delay) + 1, bool)
    begins[1:-1] = (delay[1:] != delay[:-1]) | ~static[1:] | ~static[:-1]
    begins[first] = True
    starts = np.flatnonzero(begins)
    bundle = np.zeros(len(delay), np.int32)
    bundle[starts[:-1]] = np.where(static[starts[:-1]], np.diff(starts), 0)
    of_row = np.ones(len(delay) + 1, bool)
    of_row[first] = False
    later = starts[1:-1]
    follows = of_row[later] & static[later]
    bundle[starts[:-2]] *= np.where(follows, -1, 1).astype(np.int32)
    return bundle


def _joined(parts: Sequence[Array], dtype: type[np.generic]) -> Array:
    return np.concatenate([np.empty(0, dtype), *parts], dtype=dtype, casting="same_kind")


def targets_of(projection: Projection, network: Network, row_of: IntArray) -> Array:
    """Return the targets of synapses: twice the row of the cell, plus one for the inhibitory receptor."""
    receptor = network.populations[projection.post].receptor_number(projection.receptor) % 2
    twice = (2 * row_of + receptor).astype(np.int32)
    targets: Array = twice[network.offsets[projection.post] :][projection.post_index]
    return targets


def _short_term(network: Network, cells: Array, row_of: IntArray) -> tuple[Array, Array]:
    """Return each synapse's row in a table of states, or -1, and the table; no rows if the table is empty."""
    projections = network.projections
    table = np.zeros(sum(p.size for p in projections if is_share(p)), ShortTerm.dtype())
    if not len(table):
        return np.empty(0, np.int32), table
    rows, n = [], 0
    for projection in projections:
        if is_share(projection):
            rows.append(np.arange(n, n + projection.size))
            own, target = table[n : n + projection.size], targets_of(projection, network, row_of)
            fill_short_term(own, projection, cells[target >> 1], numbers_of(projection))
            n += projection.size
        else:
            rows.append(np.full(projection.size, -1))
    return _joined(rows, np.int32), table


def is_share(projection: Projection) -> bool:
    """Return whether spikes arrive with a share of the weight."""
    return projection.synapse_type in SHARES and not projection.is_plastic


def numbers_of(projection: Projection) -> IntArray:
    """Return numbers that identify the synapses of a projection among all projections."""
    return Seeds(0).integer(projection.label, 62) + np.arange(projection.size)


def fill_short_term(table: Array, projection: Projection, targets: Array, numbers: IntArray) -> None:
    """Store the parameters and initial state of synapses onto the cells ``targets``.

    Raises:
        NetworkError: a parameter is missing.
    """
    if projection.equations is not None:
        equation_synapses.fill_share(table, projection)
    else:
        law = LAWS[projection.synapse_type]
        for name in law.parameters:
            table[name] = parameter(projection, name)
        for name, variable in law.state.items():
            table[name] = projection.initial_values.get(name, variable.default)
    if "law" in (table.dtype.names or ()):
        table["law"] = list(SHARES).index(projection.synapse_type)
    synapse = int(projection.receptor == "inhibitory")
    table["stream"] = numbers
    table["tau_psc"] = np.where(targets["synapse"] == JUMP, 0.0, targets["tau_syn"][:, synapse])
