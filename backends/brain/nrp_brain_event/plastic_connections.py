"""The plastic synapses of a network as tables of the engine, checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from nrp_brain_event.equations.synapses import fill_plastic, rules_of
from nrp_brain_event.records import Array, Plastic, Rule
from nrp_brain_event.synapse_laws import RULES
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.network.data import Network, Projection
from nrp_core.brain.network.synapses import LAWS, SynapseLaw
from nrp_core.errors import CapabilityError, NetworkError

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
