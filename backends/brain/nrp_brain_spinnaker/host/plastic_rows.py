"""Convert STDP projections to plastic rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from nrp_brain_spinnaker.host.rows import collect
from nrp_brain_spinnaker.host.stdp_rules import Tables, rule_of
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.machine import stdp_rows as columns
from nrp_brain_spinnaker.machine.stdp_rows import HISTORY, RULE_COLUMNS, StdpRows
from nrp_brain_spinnaker.models import Semantics
from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.rewiring import Neuromodulation
from nrp_core.errors import CapabilityError

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
        modulations: what rewards and punishments of a population have in common, by its label.

    Raises:
        CapabilityError: the machine does not have a rule, or there are two rules on one population.
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
        CapabilityError: the machine does not have a rule, or there are two rules on one population.
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
