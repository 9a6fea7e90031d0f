"""Convert STDP projections to plastic rows and the look-up tables of their rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import Decimal

import numpy as np

from nrp_brain_spinnaker.host.conversion import exact_exp, to_accum
from nrp_brain_spinnaker.host.rows import collect
from nrp_brain_spinnaker.host.weights import common_parameter
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine.stdp import HISTORY, RULE_COLUMNS, TRACE_ONE, StdpRows
from nrp_brain_spinnaker.models import Semantics
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Projection
from nrp_core.clock import MS_PER_S
from nrp_core.errors import CapabilityError, NetworkError

_TIMING, _VOGELS = "SpikePairRule", "Vogels2011Rule"
_UNLIMITED = -(2**40)
"""Below any weight."""
_WEIGHT = ("AdditiveWeightDependence", "MultiplicativeWeightDependence")


def load_plastic(
    wires: Sequence[Wires], n_sources: int, n: int, step_us: int, semantics: Semantics
) -> StdpRows:
    """Return the plastic synapses of a network with ``n_sources`` global ids and ``n`` simulated neurons.

    Raises:
        CapabilityError: the machine does not have a rule, or there are two rules on one population.
    """
    rules = rules_of(wires, n, step_us, semantics)
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
        last_tick=np.zeros(row_rule.size, np.int64), trace=np.zeros(row_rule.size, np.int64),
        line=synapses.line[order], weight=synapses.weight[order], delay=synapses.delay[order],
        **rules,
    )  # fmt: skip


def rules_of(wires: Sequence[Wires], n: int, step_us: int, semantics: Semantics) -> dict[str, IntArray]:
    """Return the rules of projections and empty histories of ``n`` neurons, by their names in the rows.

    Raises:
        CapabilityError: the machine does not have a rule, or there are two rules on one population.
    """
    tables = _Tables(step_us)
    rules = [_rule(part, tables, semantics) for part in wires]
    remembering = n if wires else 0
    return {
        "rules": np.array(rules, np.int64).reshape(-1, RULE_COLUMNS),
        "decays": tables.joined(),
        "rule_of": _rule_of_neurons(wires, rules, remembering),
        "history_count": np.zeros(remembering, np.int64),
        "history_tick": np.zeros((remembering, HISTORY), np.int64),
        "history_trace": np.zeros((remembering, HISTORY), np.int64),
    }


class _Tables:
    """Look-up tables of exponential decays, one for each time constant."""

    def __init__(self, step_us: int) -> None:
        self._step_ms = Decimal(step_us) / 1000
        self._values: list[int] = []
        self._known: dict[float, tuple[int, int]] = {}

    def add(self, tau_ms: float) -> tuple[int, int]:
        """Return start and length of the table for a time constant; it ends before the entries that are 0."""
        if tau_ms not in self._known:
            start, tau = len(self._values), Decimal(repr(tau_ms))
            while (
                entry := int(TRACE_ONE * exact_exp((start - len(self._values)) * self._step_ms / tau))
            ) > 0:
                self._values.append(entry)
            self._known[tau_ms] = start, len(self._values) - start
        return self._known[tau_ms]

    def joined(self) -> IntArray:
        """Return all tables, one after another."""
        return np.array(self._values, np.int64)


def _rule(part: Wires, tables: _Tables, semantics: Semantics) -> list[int]:
    """Return the row of one projection's rule."""
    projection = part.projection
    if _VOGELS in projection.plasticity.values():
        return _vogels(part, tables, semantics)
    multiplicative = _is_multiplicative(projection)
    given = {name: _common(projection, name) for name in ("tau_plus", "tau_minus", "A_plus", "A_minus")}
    _require_positive(projection, {name: given[name] for name in ("A_plus", "A_minus")})
    limits = _limits(part)
    scale = part.model.weight_scale
    gain = 1.0 if multiplicative else scale * (limits[1] if semantics == "pynn" else 1.0)
    values = [given["A_plus"] * gain, given["A_minus"] * gain, limits[0] * scale, limits[1] * scale]
    raw = _raw(projection, values, "A_plus, A_minus, w_min or w_max")
    plus, minus = tables.add(given["tau_plus"]), tables.add(given["tau_minus"])
    own = [int(multiplicative), part.shift, int(_is_dendritic(projection)), 0, 0, 0]
    return [*raw, *own, *plus, *minus]


def _vogels(part: Wires, tables: _Tables, semantics: Semantics) -> list[int]:
    """Return the row of a rule of Vogels et al., which the released software does not limit from below."""
    projection, scale = part.projection, part.model.weight_scale
    tau, eta, rho = (_common(projection, name) for name in ("tau", "eta", "rho"))
    _require_positive(projection, {"eta": eta})
    limits = _limits(part)
    gain = eta * _common_factor(part) * scale
    raw = _raw(projection, [gain, 0.0, limits[0] * scale, limits[1] * scale], "eta, w_min or w_max")
    least = raw[2] if semantics == "pynn" else _UNLIMITED
    alpha, table = round(2 * rho * tau / MS_PER_S * TRACE_ONE), tables.add(tau)
    return [*raw, 0, part.shift, int(_is_dendritic(projection)), 1, alpha, least, *table, *table]


def _limits(part: Wires) -> list[float]:
    return [abs(_common(part.projection, name)) * _common_factor(part) for name in ("w_min", "w_max")]


def _require_positive(projection: Projection, given: Mapping[str, float]) -> None:
    for name, value in given.items():
        if value < 0:
            raise CapabilityError(
                f"projection '{projection.label}': {name} is {value:g}; it must be 0 or more on the "
                "machine, which limits weights only in the direction of a positive one"
            )


def _raw(projection: Projection, values: Sequence[float], what: str) -> list[int]:
    try:
        raw: list[int] = to_accum(values, what).tolist()
    except ValueError as error:
        raise NetworkError(f"projection '{projection.label}': {error}") from None
    return raw


def _is_multiplicative(projection: Projection) -> bool:
    names = set(projection.plasticity.values())
    if _TIMING not in names or not names & set(_WEIGHT):
        raise CapabilityError(
            f"projection '{projection.label}': the machine has {_TIMING} with {' or '.join(_WEIGHT)}, and "
            f"{_VOGELS} with {_WEIGHT[0]}, not {', '.join(sorted(names)) or 'an unnamed rule'}"
        )
    return _WEIGHT[1] in names


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


def _rule_of_neurons(wires: Sequence[Wires], rules: Sequence[Sequence[int]], n: int) -> IntArray:
    """Return the rule for the decay of each neuron's trace."""
    rule_of = np.full(n, -1, np.int64)
    for index, part in enumerate(wires):
        first = part.post_first
        own = slice(first, part.post_last)
        other = rule_of[first]
        if other >= 0 and rules[other][-4:] != rules[index][-4:]:
            raise CapabilityError(
                f"projection '{part.projection.label}': on the machine all STDP projections onto one "
                "population share tau_plus and tau_minus"
            )
        rule_of[own] = index
    return rule_of
