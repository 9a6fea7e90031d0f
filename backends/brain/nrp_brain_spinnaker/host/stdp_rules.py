"""Convert the rules of STDP projections to the numbers and look-up tables of the machine.

Convert STDP projections to plastic rows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import Any, Final

import numpy as np

from nrp_brain_spinnaker.host.weights import common_parameter
from nrp_brain_spinnaker.host.wiring import Wires, collect
from nrp_brain_spinnaker.machine import stdp_rows as columns
from nrp_brain_spinnaker.machine.fixed_point import exact_exp, to_accum
from nrp_brain_spinnaker.machine.stdp_rows import HISTORY, RULE_COLUMNS, TRACE_ONE, StdpRows
from nrp_brain_spinnaker.models import Semantics
from nrp_core._support.arrays import IntArray
from nrp_core.clock import MS_PER_S
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Projection
from nrp_core.network.rewiring import Neuromodulation

_TIMING: Final = {
    "SpikePairRule": columns.PAIRS,
    "SpikeNearestPairRule": columns.NEAREST_PAIRS,
    "Vogels2011Rule": columns.VOGELS,
    "PfisterSpikeTripletRule": columns.TRIPLETS,
}
_ADDITIVE, _MULTIPLICATIVE = "AdditiveWeightDependence", "MultiplicativeWeightDependence"
_UNLIMITED = -(2**40)
"""Below any weight."""
Row = dict[int, int]
"""Values by column."""


class Tables:
    """Look-up tables of exponential decays, one for each time constant."""

    def __init__(self, step_us: int) -> None:
        self._step_ms = Decimal(step_us) / 1000
        self._values: list[int] = []
        self._known: dict[tuple[float, int], tuple[int, int]] = {}

    def add(self, tau_ms: float, shift: int = 0) -> tuple[int, int]:
        """Return start and length of a table, one entry per ``2**shift`` ticks, without entries of 0."""
        if (tau_ms, shift) not in self._known:
            start, tau, step_ms = len(self._values), Decimal(repr(tau_ms)), self._step_ms * 2**shift
            while (entry := int(TRACE_ONE * exact_exp((start - len(self._values)) * step_ms / tau))) > 0:
                self._values.append(entry)
            self._known[tau_ms, shift] = start, len(self._values) - start
        return self._known[tau_ms, shift]

    def joined(self) -> IntArray:
        """Return all tables, concatenated."""
        return np.array(self._values, np.int64)


def rule_of(
    part: Wires, modulation: Neuromodulation | None, tables: Tables, semantics: Semantics
) -> list[int]:
    """Return the numbers of one projection's rule, by column.

    Args:
        part: the projection.
        modulation: the parameters that rewards and punishments of its target share; None without any.
        tables: the look-up tables, to which those of the rule are added.
        semantics: whether the rules have PyNN's meaning.

    Raises:
        CapabilityError: the machine does not have the rule.
        NetworkError: a parameter does not fit the machine.
    """
    timing, multiplicative = _parts(part.projection)
    row: Row = {
        columns.TIMING: timing, columns.MULTIPLICATIVE: int(multiplicative), columns.SHIFT: part.shift,
        columns.BACK_PROPAGATES: int(_is_dendritic(part.projection)),
    }  # fmt: skip
    rule = _RULES.get(timing, _pairs)
    row |= rule(part, tables, semantics)
    if modulation is not None:
        row |= _modulated(part, modulation, tables)
    return [row.get(column, 0) for column in range(RULE_COLUMNS)]


def _pairs(part: Wires, tables: Tables, _semantics: Semantics) -> Row:
    gain = 1.0 if _parts(part.projection)[1] else part.model.weight_scale * _limits(part)[1]
    return _changes(part, tables, {columns.A_PLUS: "A_plus", columns.A_MINUS: "A_minus"}, gain)


def _triplets(part: Wires, tables: Tables, _semantics: Semantics) -> Row:
    """Return the rule of triplets."""
    names = {
        columns.A_PLUS: "A_plus", columns.A_MINUS: "A_minus",
        columns.A3_PLUS: "A3_plus", columns.A3_MINUS: "A3_minus",
    }  # fmt: skip
    row = _changes(part, tables, names, part.model.weight_scale * _limits(part)[1])
    row[columns.X], row[columns.X_LENGTH] = tables.add(_common(part.projection, "tau_x"), columns.SLOW_SHIFT)
    row[columns.Y], row[columns.Y_LENGTH] = tables.add(_common(part.projection, "tau_y"), columns.SLOW_SHIFT)
    return row


def _changes(part: Wires, tables: Tables, names: Mapping[int, str], gain: float) -> Row:
    """Return amplitudes, limits and the tables of a rule with ``tau_plus`` and ``tau_minus``."""
    projection = part.projection
    given = {name: _common(projection, name) for name in names.values()}
    _require_positive(projection, given)
    raw = _raw(projection, {name: gain * value for name, value in given.items()})
    row = dict(zip(names, raw, strict=True))
    row[columns.PLUS], row[columns.PLUS_LENGTH] = tables.add(_common(projection, "tau_plus"))
    row[columns.MINUS], row[columns.MINUS_LENGTH] = tables.add(_common(projection, "tau_minus"))
    return row | _raw_limits(part)


def _vogels(part: Wires, tables: Tables, semantics: Semantics) -> Row:
    """Return the rule of Vogels et al., which the released software does not limit from below."""
    projection = part.projection
    tau, eta, rho = (_common(projection, name) for name in ("tau", "eta", "rho"))
    _require_positive(projection, {"eta": eta})
    row = _raw_limits(part)
    (row[columns.A_PLUS],) = _raw(projection, {"eta": eta * _common_factor(part) * part.model.weight_scale})
    row[columns.LEAST] = row[columns.W_MIN] if semantics == "pynn" else _UNLIMITED
    row[columns.ALPHA] = round(2 * rho * tau / MS_PER_S * TRACE_ONE)
    row[columns.PLUS], row[columns.PLUS_LENGTH] = table = tables.add(tau)
    row[columns.MINUS], row[columns.MINUS_LENGTH] = table
    return row


_RULES: Final[Mapping[int, Callable[[Wires, Tables, Semantics], Row]]] = {
    columns.VOGELS: _vogels,
    columns.TRIPLETS: _triplets,
}


def _modulated(part: Wires, modulation: Neuromodulation, tables: Tables) -> Row:
    """Return the columns for rewards; the constant is that of the integral of two decays, in ms."""
    scale = _common_factor(part) * part.model.weight_scale
    names = {
        "tau_c and tau_d": -1 / (1 / modulation.tau_c + 1 / modulation.tau_d),
        "w_min": modulation.w_min * scale,
        "w_max": modulation.w_max * scale,
    }
    columns_of = (columns.CREDIT, columns.LOWEST, columns.HIGHEST)
    row = dict(zip(columns_of, _raw(part.projection, names), strict=True))
    row[columns.MODULATED] = 1
    row[columns.C], row[columns.C_LENGTH] = tables.add(modulation.tau_c, columns.C_SHIFT)
    row[columns.D], row[columns.D_LENGTH] = tables.add(modulation.tau_d, columns.D_SHIFT)
    return row


def _parts(projection: Projection) -> tuple[int, bool]:
    """Return the number of the rule for times, and whether weights change multiplicatively."""
    names = set(projection.plasticity.values())
    timing = next((number for name, number in _TIMING.items() if name in names), None)
    additive_only = timing in (columns.VOGELS, columns.TRIPLETS)
    known = {_ADDITIVE} if additive_only else {_ADDITIVE, _MULTIPLICATIVE}
    if timing is None or not names & known:
        raise CapabilityError(
            f"projection '{projection.label}': the machine has SpikeNearestPairRule and SpikePairRule with "
            f"{_ADDITIVE} or {_MULTIPLICATIVE}, and Vogels2011Rule and PfisterSpikeTripletRule with "
            f"{_ADDITIVE}, not {', '.join(sorted(names)) or 'an unnamed rule'}"
        )
    return timing, _MULTIPLICATIVE in names


def _limits(part: Wires) -> list[float]:
    return [abs(_common(part.projection, name)) * _common_factor(part) for name in ("w_min", "w_max")]


def _raw_limits(part: Wires) -> Row:
    scaled = {
        name: limit * part.model.weight_scale
        for name, limit in zip(("w_min", "w_max"), _limits(part), strict=True)
    }
    return dict(zip((columns.W_MIN, columns.W_MAX), _raw(part.projection, scaled), strict=True))


def _require_positive(projection: Projection, given: Mapping[str, float]) -> None:
    for name, value in given.items():
        if value < 0:
            raise CapabilityError(
                f"projection '{projection.label}': {name} is {value:g}; it must be 0 or more on the "
                "machine, which limits weights only in the direction of a positive one"
            )


def _raw(projection: Projection, given: Mapping[str, float]) -> list[int]:
    try:
        raw: list[int] = to_accum(list(given.values()), ", ".join(given)).tolist()
    except ValueError as error:
        raise NetworkError(f"projection '{projection.label}': {error}") from None
    return raw


def _is_dendritic(projection: Projection) -> bool:
    fraction = _common(projection, "dendritic_delay_fraction", 1.0)
    if fraction not in (0.0, 1.0):
        raise CapabilityError(
            f"projection '{projection.label}': on the machine a delay is dendritic as a whole or not at all; "
            f"dendritic_delay_fraction is 0 or 1, not {fraction:g}"
        )
    return fraction == 1.0


def _common(projection: Projection, name: str, default: float | None = None) -> float:
    """Return a parameter of the rule, which is common to all synapses of a projection."""
    values = common_parameter(projection, name)
    if values is None:
        if default is None:
            raise NetworkError(f"projection '{projection.label}': its STDP rule has no '{name}'")
        return default
    if np.ptp(values) > 0:
        raise CapabilityError(f"projection '{projection.label}': {name} must be one value on the machine")
    return float(values[0])


def _common_factor(part: Wires) -> float:
    if part.factor is None:
        return 1.0
    if np.ptp(part.factor) > 0:
        raise CapabilityError(
            f"projection '{part.projection.label}': limits of STDP in mV need cells with equal cm and tau_m"
        )
    return float(part.factor[0])


_OF_HISTORIES: Final = (
    columns.TIMING, columns.PLUS, columns.PLUS_LENGTH, columns.MINUS, columns.MINUS_LENGTH, columns.X,
    columns.X_LENGTH, columns.Y, columns.Y_LENGTH,
)  # fmt: skip
"""What all rules onto one population share, because its cells have one history."""


def load_plastic(
    wires: Sequence[Wires], n_sources: int, n: int, step_us: int, semantics: Semantics,
    modulations: Mapping[str, Neuromodulation],
) -> StdpRows:  # fmt: skip
    """Return the plastic synapses of a network with ``n_sources`` global ids and ``n`` simulated neurons.

    Args:
        wires: their projections.
        n_sources: the number of global ids.
        n: the number of simulated neurons.
        step_us: the length of a tick, us.
        semantics: whether the rules have PyNN's meaning.
        modulations: the parameters that rewards and punishments of a population share, by its label.

    Raises:
        CapabilityError: the machine does not have a rule, or one population has two rules.
    """
    rules = rules_of(wires, n, step_us, semantics, modulations)
    synapses = collect(wires, n)
    rule_of_synapse = np.repeat(np.arange(len(wires)), [part.projection.size for part in wires])[
        synapses.order
    ]
    order = np.lexsort((rule_of_synapse, synapses.pre))
    keys = np.stack([synapses.pre[order], rule_of_synapse[order]])
    new_row = np.ones(order.size, bool)
    new_row[1:] = (np.diff(keys, axis=1) != 0).any(axis=0)
    first = np.append(np.flatnonzero(new_row), order.size)
    row_pre, row_rule = keys[:, new_row]
    start = np.searchsorted(row_pre, np.arange(n_sources + 1))
    return StdpRows(
        start=start.astype(np.int64), first=first.astype(np.int64), rule=row_rule.astype(np.int64),
        line=synapses.line[order], weight=synapses.weight[order], delay=synapses.delay[order],
        eligibility=np.zeros(order.size if rules["history_marks"].size else 0, np.uint16),
        **at_rest(row_rule.size), **rules,
    )  # fmt: skip


def at_rest(n_rows: int) -> dict[str, IntArray]:
    """Return the state of rows before their first spikes, by its names in the rows."""
    return {name: np.zeros(n_rows, np.int64) for name in ("last_tick", "trace", "slow")}


def rules_of(
    wires: Sequence[Wires], n: int, step_us: int, semantics: Semantics,
    modulations: Mapping[str, Neuromodulation],
) -> dict[str, Any]:  # fmt: skip
    """Return the rules of projections and empty histories of ``n`` neurons, by their names in the rows.

    Raises:
        CapabilityError: the machine does not have a rule, or one population has two rules.
    """
    tables = Tables(step_us)
    rules = np.array(
        [rule_of(part, modulations.get(part.projection.post), tables, semantics) for part in wires], np.int64
    ).reshape(-1, RULE_COLUMNS)
    remembering = n if wires else 0
    with_triplets = remembering if (rules[:, columns.TIMING] == columns.TRIPLETS).any() else 0
    with_rewards = remembering if rules[:, columns.MODULATED].any() else 0
    return {
        "rules": rules,
        "decays": tables.joined(),
        "rule_of": _rule_of_neurons(wires, rules, remembering),
        "history_count": np.zeros(remembering, np.int64),
        "history_tick": np.zeros((remembering, HISTORY), np.int64),
        "history_trace": np.zeros((remembering, HISTORY), np.int64),
        "history_slow": np.zeros((with_triplets, HISTORY), np.int64),
        "history_dopamine": np.zeros((with_rewards, HISTORY), np.int64),
        "history_marks": np.zeros(with_rewards, np.int64),
    }


def _rule_of_neurons(wires: Sequence[Wires], rules: IntArray, n: int) -> IntArray:
    """Return the rule for the decay of each neuron's trace."""
    of_neurons = np.full(n, -1, np.int64)
    for index, part in enumerate(wires):
        other = of_neurons[part.post_first]
        if other >= 0 and (rules[other, _OF_HISTORIES] != rules[index, _OF_HISTORIES]).any():
            raise CapabilityError(
                f"projection '{part.projection.label}': on the machine all STDP projections onto one "
                "population share the rule for times and its time constants, such as tau_plus and tau_minus"
            )
        of_neurons[part.post_first : part.post_last] = index
    return of_neurons
