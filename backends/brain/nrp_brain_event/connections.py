"""The synapses of a network as tables of the engine, checked.

The plastic synapses of a network as tables of the engine, checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_event.equation_synapses import fill_plastic, fill_share, rules_of
from nrp_brain_event.records import JUMP, Array, Plastic, Rule, ShortTerm
from nrp_brain_event.synapse_laws import RULES, SHARES
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.network.data import Network, Projection
from nrp_core.brain.network.drawing import extremes
from nrp_core.brain.network.indices import stored_form
from nrp_core.brain.network.synapses import LAWS, SynapseLaw
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.seeds import Seeds

_LIMITS: Final = ("w_min", "w_max")
_COLUMNS: Final = Rule.dtype().names or ()
_LONG_AGO_MS: Final = -np.inf


class PlasticTables(NamedTuple):
    """The plastic synapses of a network.

    Args:
        targets: targets of the synapses of each projection; plastic ones point to their own table.
        tables: parts of the :class:`~nrp_brain_event.records.EngineArrays` by name.
    """

    targets: list[Array]
    tables: dict[str, Array]


def load_plastic(
    network: Network, projections: Sequence[Projection], targets: Sequence[Array], n_cells: int
) -> PlasticTables:
    """Return the tables of plastic synapses.

    Args:
        network: the network.
        projections: all of its projections, or only the plastic ones.
        targets: the target receptors of each projection's synapses.
        n_cells: number of cells.

    Raises:
        NetworkError: a parameter is missing or impossible.
        CapabilityError: the rule is not supported.
    """
    plastic = [k for k, projection in enumerate(projections) if projection.is_plastic]
    rows = rows_of_plastic([targets[k] for k in plastic])
    table = np.zeros(sum(map(len, rows)), Plastic.dtype())
    rules = np.empty((len(table), len(_COLUMNS)))
    redirected = list(targets)
    for k, own in zip(plastic, rows, strict=True):
        redirected[k] = ~own
        table["target"][own] = targets[k]
        rules[own] = _rules(projections[k], network)
        table["weight"][own] = rules[own, _COLUMNS.index("sign")] * projections[k].weight
        table["dendritic_delay"][own] = projections[k].delay_ms * _dendritic_fraction(projections[k])
    distinct, table["rule"] = _distinct(rules)
    table["last_seen"] = -1
    table["pre_t"] = table["post_t"] = _LONG_AGO_MS
    for k, own in zip(plastic, rows, strict=True):
        if projections[k].equations is not None:
            fill_plastic(table, own, projections[k])
    fan_in = np.bincount(table["target"] >> 1, minlength=n_cells)
    first = np.concatenate([[0], np.cumsum(fan_in)]) if len(table) else np.empty(0, np.int64)
    return PlasticTables(redirected, {"plastic": table, "first_plastic": first, "rules": _records(distinct)})


def rows_of_plastic(targets: Sequence[Array]) -> list[IntArray]:
    """Return the rows in the table of the plastic synapses of each projection."""
    cells = np.concatenate([np.empty(0, np.int64), *targets]) >> 1
    rows = np.empty(len(cells), np.int64)
    rows[np.argsort(cells, kind="stable")] = np.arange(len(cells))
    return np.split(rows, np.cumsum([len(part) for part in targets]))[: len(targets)]


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


def _rules(projection: Projection, network: Network) -> FloatArray:
    """Return the columns of ``Rule`` for each synapse."""
    if projection.equations is None:
        columns, kernel = _parameters(projection)
    else:
        unit = network.populations[projection.post].weight_unit(projection.receptor)
        columns, kernel = rules_of(projection, unit), projection.synapse_type
    negative = bool((projection.weight < 0).any())
    if negative and (projection.weight > 0).any():
        raise NetworkError(f"projection '{projection.label}': plastic weights have one sign, not both")
    columns["sign"], columns["law"] = 1.0 - 2.0 * negative, list(RULES).index(kernel)
    rules = np.zeros((projection.size, len(_COLUMNS)))
    for k, name in enumerate(_COLUMNS):
        rules[:, k] = columns.get(name, 0.0)
    return rules


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


def _distinct(rules: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the distinct rows, and the index of each row among them; equal columns are not sorted."""
    varying = (rules != rules[:1]).any(axis=0)
    if not varying.any():
        return rules[:1], np.zeros(len(rules), np.int64)
    _, first, index = np.unique(rules[:, varying], axis=0, return_index=True, return_inverse=True)
    return rules[first], index


def _dendritic_fraction(projection: Projection) -> FloatArray:
    return projection.synapse_parameters.get("dendritic_delay_fraction", np.ones(projection.size))


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
    pre = _presynaptic(network)
    targets = [_targets(projection, network, row_of) for projection in projections]
    dynamics, short_term = _short_term(projections, cells, targets)
    plastic = load_plastic(network, projections, targets, len(cells))
    order = _order(network, pre)
    first = np.concatenate([[0], np.cumsum(np.bincount(pre, minlength=network.size))])
    target = _joined(plastic.targets, np.int32)[order]
    delay, dynamics = _delays(network)[order], dynamics[order]
    return {
        "first": first,
        "target": target,
        "weight": _joined([projection.weight for projection in projections], np.float64)[order],
        "delay": delay,
        "dynamics": dynamics if len(short_term) else dynamics[:0],
        "bundle": _bundles(first, delay, (target >= 0) & (dynamics < 0)),
        "short_term": short_term,
        **plastic.tables,
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


def places_of(network: Network, row_of: IntArray) -> dict[str, IntArray]:
    """Return the rows of each projection's synapses in the engine's tables, by label.

    The table is ``plastic`` for plastic synapses, else ``weight``.
    """
    projections = network.projections
    order = _order(network, _presynaptic(network))
    rows = np.empty(len(order), np.int64)
    rows[order] = np.arange(len(order))
    cuts = np.cumsum([projection.size for projection in projections])[:-1]
    places = {p.label: part for p, part in zip(projections, np.split(rows, cuts), strict=False)}
    plastic = [projection for projection in projections if projection.is_plastic]
    targets = [_targets(projection, network, row_of) for projection in plastic]
    for projection, own in zip(plastic, rows_of_plastic(targets), strict=True):
        places[projection.label] = own
    return places


def _presynaptic(network: Network) -> IntArray:
    parts = [network.offsets[p.pre] + p.pre_index.astype(np.int64) for p in network.projections]
    return _joined(parts, np.int64)


def _delays(network: Network) -> Array:
    return _joined([projection.delay_ms for projection in network.projections], np.float64)


def _order(network: Network, pre: IntArray) -> IntArray:
    """Return the order of synapses: by neuron, then by delay."""
    return np.lexsort((_delays(network), pre))


def _bundles(first: Array, delay: Array, static: Array) -> Array:
    """Return the length of each run of static synapses of one neuron and delay at its first, else 0."""
    begins = np.ones(len(delay) + 1, bool)
    begins[1:-1] = (delay[1:] != delay[:-1]) | ~static[1:] | ~static[:-1]
    begins[first] = True
    starts = np.flatnonzero(begins)
    bundle = np.zeros(len(delay), np.int32)
    bundle[starts[:-1]] = np.diff(starts)
    return np.where(static, bundle, 0)


def _joined(parts: Sequence[Array], dtype: type[np.generic]) -> Array:
    return np.concatenate([np.empty(0, dtype), *parts], dtype=dtype, casting="same_kind")


def _targets(projection: Projection, network: Network, row_of: IntArray) -> Array:
    post = network.offsets[projection.post] + projection.post_index.astype(np.int64)
    return 2 * row_of[post] + (projection.receptor == "inhibitory")


def _short_term(projections: Sequence[Projection], cells: Array, targets: list[Array]) -> tuple[Array, Array]:
    """Return each synapse's row in a table of states, or -1, and that table."""
    dynamic = [is_share(projection) for projection in projections]
    size = sum(projection.size for projection, is_so in zip(projections, dynamic, strict=True) if is_so)
    table, rows, n = np.zeros(size, ShortTerm.dtype()), [], 0
    for projection, target, is_so in zip(projections, targets, dynamic, strict=True):
        rows.append(np.arange(n, n + projection.size) if is_so else np.full(projection.size, -1))
        if is_so:
            own = table[n : n + projection.size]
            fill_short_term(own, projection, cells[target >> 1], numbers_of(projection))
            n += projection.size
    return _joined(rows, np.int32), table


def is_share(projection: Projection) -> bool:
    """Return whether spikes arrive with a share of the weight."""
    return projection.synapse_type in SHARES and not projection.is_plastic


def numbers_of(projection: Projection) -> IntArray:
    """Return numbers that set the synapses of a projection apart from those of any other."""
    return Seeds(0).integer(projection.label, 62) + np.arange(projection.size)


def fill_short_term(table: Array, projection: Projection, targets: Array, numbers: IntArray) -> None:
    """Store the parameters and initial state of synapses onto the cells ``targets``.

    Raises:
        NetworkError: a parameter is missing.
    """
    if projection.equations is not None:
        fill_share(table, projection)
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
