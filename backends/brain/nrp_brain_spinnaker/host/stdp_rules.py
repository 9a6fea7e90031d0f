"""Convert the rules of STDP projections to the numbers and look-up tables of the machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Final

import numpy as np

from nrp_brain_spinnaker.host.conversion import exact_exp, to_accum
from nrp_brain_spinnaker.host.weights import common_parameter
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine import stdp_rows as columns
from nrp_brain_spinnaker.machine.stdp_rows import RULE_COLUMNS, TRACE_ONE
from nrp_brain_spinnaker.models import Semantics
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Projection
from nrp_core.brain.network.rewiring import Neuromodulation
from nrp_core.clock import MS_PER_S
from nrp_core.errors import CapabilityError, NetworkError

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
        """Return start and length of a table, an entry for ``2**shift`` ticks, without those that are 0."""
        if (tau_ms, shift) not in self._known:
            start, tau, step_ms = len(self._values), Decimal(repr(tau_ms)), self._step_ms * 2**shift
            while (entry := int(TRACE_ONE * exact_exp((start - len(self._values)) * step_ms / tau))) > 0:
                self._values.append(entry)
            self._known[tau_ms, shift] = start, len(self._values) - start
        return self._known[tau_ms, shift]

    def joined(self) -> IntArray:
        """Return all tables, one after another."""
        return np.array(self._values, np.int64)


def rule_of(
    part: Wires, modulation: Neuromodulation | None, tables: Tables, semantics: Semantics
) -> list[int]:
    """Return the numbers of one projection's rule, by column.

    Args:
        part: the projection.
        modulation: what rewards and punishments of its target have in common, or None without any.
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


def _pairs(part: Wires, tables: Tables, semantics: Semantics) -> Row:
    gain = 1.0 if _parts(part.projection)[1] else part.model.weight_scale
    highest = _limits(part)[1] if semantics == "pynn" and not _parts(part.projection)[1] else 1.0
    return _changes(part, tables, {columns.A_PLUS: "A_plus", columns.A_MINUS: "A_minus"}, gain * highest)


def _triplets(part: Wires, tables: Tables, _semantics: Semantics) -> Row:
    """Return the rule of triplets, in which the released software has PyNN's meaning of the amplitudes."""
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
