"""The projections of a network as NEST's synapses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import partial
from typing import Any, Final

import numpy as np
from nrp_core.brain import (
    STATIC,
    STDP,
    TSODYKS_MARKRAM,
    Code,
    Findings,
    FloatArray,
    Grid,
    IntArray,
    Network,
    Population,
    Projection,
)
from nrp_core.errors import CapabilityError, NetworkError

from nrp_brain_nest.cell_types import CELL_TYPES
from nrp_brain_nest.cells import Cells
from nrp_brain_nest.inputs import SourceCells
from nrp_brain_nest.links import Link, Synapses
from nrp_brain_nest.rewards import STATE, Rewards
from nrp_brain_nest.weights import Weights

_MODELS: Final = {STATIC: "static_synapse", TSODYKS_MARKRAM: "tsodyks_synapse", STDP: "stdp_synapse"}
_EXPONENT: Final = {"AdditiveWeightDependence": 0.0, "MultiplicativeWeightDependence": 1.0}
_NO_TIME_MS: Final = 1e-9
"""Time constant of the active resources of a delta synapse."""
_APART: Final = 1.0 + 1e-6
"""NEST's closed form of Tsodyks-Markram synapses divides by the difference of two time constants."""
_NO_POTENTIATION: Final = 1e-12
"""NEST has depression as a ratio to potentiation, which therefore cannot be 0."""


class Wiring:
    """Connects the projections of a network.

    Args:
        nest: the module.
        network: the network.
        cells, sources: the ends.
        weights: conversion to NEST's weights.
        grid: NEST's time grid.

    Attributes:
        warnings: warnings about NEST's deviations from the network.
    """

    def __init__(
        self, nest: Any, network: Network, cells: Cells, sources: SourceCells, weights: Weights, grid: Grid
    ) -> None:
        self._nest, self._network, self._grid = nest, network, grid
        self._cells, self._sources, self._weights = cells, sources, weights
        self._tau_minus = np.full(network.size, np.nan)
        self._links: dict[str, Link] = {}
        self._between: Counter[tuple[str, str, str]] = Counter()
        self._rewards = Rewards(nest, network, grid)
        self.warnings = Findings()

    def connect(self, projection: Projection) -> None:
        """Create the synapses of a projection.

        Raises:
            CapabilityError, NetworkError: NEST does not have such synapses.
        """
        if not projection.size:
            return
        pre = self._network.populations[projection.pre]
        if projection.neuromodulation is not None:
            self._connect_reward(projection)
            return
        copy, model = self._copy_of(projection), _MODELS[projection.synapse_type]
        relayed = _is_relayed(pre, projection)
        if pre.is_source:
            nodes = self._sources.nodes(projection.pre, copy=None if relayed else copy)
        else:
            nodes = self._cells.nodes[self._network.ids_of(projection.pre)]
        if copy and (relayed or not pre.is_source):
            model = self._copied(model, copy)
        if projection.synapse_type == STDP:
            self._share_trace(projection)
        if self._is_rewarded(projection):
            model = self._rewards.model(
                projection, len(self._links), self._rule_of_rewarded(projection), self._unit(projection)
            )
        *ends, values = self._made(projection, nodes)
        synapses = {"synapse_model": model, **values}
        if projection.synapse_type == TSODYKS_MARKRAM:
            synapses["u"] = np.zeros(projection.size)  # they start recovered and without facilitation
        self._nest.Connect(*ends, "one_to_one", synapses)
        self._links[projection.label] = Link(self._nest, model, partial(self._made, projection, nodes))

    def _made(self, projection: Projection, nodes: IntArray) -> Synapses:
        """Return the NEST synapses of a projection, given the ids of its presynaptic nodes."""
        post = self._targets(projection)
        weights = self._weights.onto(post, projection.weight, projection.receptor)
        relayed = _is_relayed(self._network.populations[projection.pre], projection)
        values = {
            "weight": weights,
            "delay": self._delays_ms(projection, sooner=relayed and projection.synapse_type != STDP),
        }
        if projection.synapse_type == TSODYKS_MARKRAM:
            values |= self._short_term(projection)
        elif projection.synapse_type == STDP and not self._is_rewarded(projection):
            values |= self._stdp(projection, weights)
        return nodes[projection.pre_index], self._cells.nodes[post], values

    def _connect_reward(self, projection: Projection) -> None:
        """Connect synapses that reward; generators reach them through a relay, which takes a step."""
        pre = self._network.populations[projection.pre]
        if pre.is_source:
            nodes = self._sources.nodes(projection.pre, copy=None)
            if self._grid.delays(projection.delay_ms).min() < 2:
                self._warn(projection, "rewards of source cells take two steps or more in NEST")
        else:
            nodes = self._cells.nodes[self._network.ids_of(projection.pre)]
        self._rewards.connect(projection, nodes, int(pre.is_source))

    def _is_rewarded(self, projection: Projection) -> bool:
        return projection.synapse_type == STDP and self._rewards.has(projection)

    def _rule_of_rewarded(self, projection: Projection) -> dict[str, FloatArray]:
        if projection.receptor != "excitatory":
            raise CapabilityError(
                f"projection '{projection.label}': on NEST only excitatory synapses learn from rewards; "
                "'event' has the others"
            )
        _exponent(projection)
        return {name: _parameter(projection, name) for name in ("A_plus", "A_minus", "tau_plus", "w_max")}

    def _unit(self, projection: Projection) -> float:
        """Return the weight in NEST of a weight of 1."""
        one = self._weights.onto(self._targets(projection)[:1], np.ones(1), projection.receptor)
        return float(one[0])

    def read_state(self, projection: Projection, variable: str) -> FloatArray:
        """Return a state variable of synapses that learn from rewards."""
        if not projection.size:
            return np.empty(0)
        found = self._links[projection.label].read(STATE[variable])
        return found * self._rewards.scale(projection, variable, self._unit(projection))

    def reward(self, label: str, amount: float, now_ns: int) -> None:
        """Add to the dopamine of a population."""
        for projection in self._learning(label):
            amount_there = self._rewards.amount(projection, amount, now_ns)
            self._links[projection.label].raise_shared("n", amount_there)

    def hold_reward(self, label: str, value: float, now_ns: int) -> None:
        """Let a value add to the dopamine of a population from now on."""
        for projection in self._learning(label):
            baseline = self._rewards.baseline(projection) - value
            held = {"b": self._rewards.amount(projection, baseline, now_ns)}
            self._nest.SetDefaults(self._links[projection.label].model, held)

    def _learning(self, label: str) -> list[Projection]:
        """Return the projections onto a population that learn from rewards."""
        onto = [one for one in self._network.projections if one.post == label and one.size]
        return [one for one in onto if self._is_rewarded(one)]

    def read_weights(self, projection: Projection) -> FloatArray:
        """Return the present weights of a projection, in PyNN's units."""
        if not projection.size:
            return np.empty(0)
        if projection.neuromodulation is not None:
            return projection.weight.copy()
        return self._weights.of(
            self._targets(projection), self._links[projection.label].read("weight"), projection.receptor
        )

    def set_weights(self, projection: Projection, weights: FloatArray) -> None:
        """Change the weights of a projection.

        Raises:
            CapabilityError: NEST does not have such synapses.
        """
        if projection.neuromodulation is not None:
            raise CapabilityError(
                f"projection '{projection.label}': the dopamine that a spike brings cannot change while the "
                "network runs"
            )
        if projection.size:
            new = self._weights.onto(self._targets(projection), weights, projection.receptor)
            self._links[projection.label].set("weight", new)

    def renew_decay(self, label: str, parameters: Mapping[str, FloatArray]) -> None:
        """Update the time constants of targets in Tsodyks-Markram synapses."""
        for projection in self._network.projections:
            if projection.post == label and projection.synapse_type == TSODYKS_MARKRAM and projection.size:
                self._links[projection.label].set("tau_psc", self._decay(projection, parameters))

    def _targets(self, projection: Projection) -> IntArray:
        return self._network.offsets[projection.post] + projection.post_index.astype(np.int64)

    def _copy_of(self, projection: Projection) -> int:
        """Return the number of earlier projections of this kind between two populations, for their names."""
        kind = projection.pre, projection.post, projection.synapse_type
        self._between[kind] += 1
        return self._between[kind] - 1

    def _copied(self, model: str, copy: int) -> str:
        name = f"{model}_{copy}"
        if name not in self._nest.synapse_models:
            self._nest.CopyModel(model, name)
        return name

    def _delays_ms(self, projection: Projection, *, sooner: bool) -> FloatArray:
        """Return the delays in NEST; ``sooner`` by the step that a relay takes.

        Not for STDP, for which NEST would count that step twice; there the spike is one step late.
        """
        steps, step_ms = self._grid.delays(projection.delay_ms), self._grid.step_ms
        if np.abs(steps * step_ms - projection.delay_ms).max() > 1e-6:
            self._warn(projection, f"delays are whole numbers of {step_ms:g} ms in NEST")
        if sooner:
            if steps.min() < 2:
                self._warn(
                    projection, "tsodyks_markram synapses of source cells take two steps or more in NEST"
                )
            steps = np.maximum(steps - 1, 1)
        return self._grid.time_ms(steps)

    def _short_term(self, projection: Projection) -> dict[str, FloatArray]:
        """Return PyNN's parameters by NEST's names."""
        post = self._network.populations[projection.post]
        return {
            "U": _parameter(projection, "U"),
            "tau_rec": _parameter(projection, "tau_rec"),
            "tau_fac": _parameter(projection, "tau_facil"),
            "tau_psc": self._decay(projection, post.parameters),
        }

    def _decay(self, projection: Projection, parameters: Mapping[str, FloatArray]) -> FloatArray:
        """Return ``tau_psc``, by the parameters of the target population."""
        tau_psc = np.full(projection.size, _NO_TIME_MS)
        if CELL_TYPES[self._network.populations[projection.post].cell_type].drive != "jump":
            taus = "tau_syn_E" if projection.receptor == "excitatory" else "tau_syn_I"
            tau_psc = parameters[taus][projection.post_index]
        equal = np.isclose(tau_psc, _parameter(projection, "tau_rec"), rtol=1e-7)
        return np.where(equal, tau_psc * _APART, tau_psc)

    def _stdp(self, projection: Projection, weights: FloatArray) -> dict[str, FloatArray]:
        exponent = _exponent(projection)
        a_plus = np.maximum(_parameter(projection, "A_plus"), _NO_POTENTIATION)
        w_max = _parameter(projection, "w_max")
        post = self._network.ids_of(projection.post)[projection.post_index]
        limit = np.abs(self._weights.onto(post, np.where(weights < 0, -w_max, w_max), projection.receptor))
        return {
            "Wmax": np.copysign(limit, np.where(weights == 0, limit, weights)),
            "lambda": a_plus,
            "alpha": _parameter(projection, "A_minus") / a_plus,
            "mu_plus": np.full(projection.size, exponent),
            "mu_minus": np.full(projection.size, exponent),
            "tau_plus": _parameter(projection, "tau_plus"),
        }

    def _share_trace(self, projection: Projection) -> None:
        """Set ``tau_minus``, which in NEST is a parameter of the cell and not of its synapses."""
        post = self._targets(projection)
        tau_minus, known = _parameter(projection, "tau_minus"), self._tau_minus
        fresh = np.isnan(known[post])
        known[post[fresh]] = tau_minus[fresh]
        if (known[post] != tau_minus).any():
            raise CapabilityError(
                f"projection '{projection.label}': NEST keeps tau_minus with the cell, and a cell of "
                f"population '{projection.post}' has synapses with different ones"
            )
        cells = np.unique(projection.post_index).astype(np.int64)
        offset = self._network.offsets[projection.post]
        self._cells.set_trace_time(projection.post, cells, known[offset + cells])

    def _warn(self, projection: Projection, text: str) -> None:
        message = f"projection '{projection.label}': {text}"
        self.warnings.add(Code.NRP217, message, subject=projection.label)


def _is_relayed(pre: Population, projection: Projection) -> bool:
    return pre.is_source and projection.synapse_type != STATIC


def _parameter(projection: Projection, name: str) -> FloatArray:
    values: Mapping[str, FloatArray] = projection.synapse_parameters
    if name not in values:
        raise NetworkError(
            f"projection '{projection.label}': {projection.synapse_type} synapses need '{name}'"
        )
    return np.array(values[name])


def _exponent(projection: Projection) -> float:
    """Return the exponent of the rule's weight dependence; refuse rules that NEST does not have."""
    where, names = f"projection '{projection.label}'", projection.plasticity
    timing, weight = names.get("timing_dependence"), names.get("weight_dependence")
    if timing != "SpikePairRule" or weight not in _EXPONENT:
        known = ", ".join(_EXPONENT)
        raise CapabilityError(f"{where}: NEST has the SpikePairRule with {known}, not {timing} with {weight}")
    if "w_min" in projection.synapse_parameters and _parameter(projection, "w_min").any():
        raise CapabilityError(f"{where}: in NEST w_min is 0")
    for name in ("A_plus", "A_minus"):
        if (_parameter(projection, name) < 0).any():
            raise CapabilityError(f"{where}: {name} is negative; in NEST it is 0 or more")
    fraction = projection.synapse_parameters.get("dendritic_delay_fraction")
    if fraction is not None and (fraction != 1.0).any():
        raise CapabilityError(f"{where}: in NEST dendritic_delay_fraction is 1: the whole delay is dendritic")
    return _EXPONENT[weight]
