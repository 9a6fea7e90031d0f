"""The synapses of a network as tables of the engine, checked."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Final

import numpy as np

from nrp_brain_event.equations.synapses import fill_share
from nrp_brain_event.plastic_connections import load_plastic, parameter, rows_of_plastic
from nrp_brain_event.records import JUMP, Array, ShortTerm
from nrp_brain_event.synapse_laws import SHARES
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Network, Projection
from nrp_core.brain.network.drawing import extremes
from nrp_core.brain.network.indices import stored_form
from nrp_core.brain.network.synapses import LAWS
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import NetworkError
from nrp_core.seeds import Seeds

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
