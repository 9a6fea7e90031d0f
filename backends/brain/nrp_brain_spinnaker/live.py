"""Changes of a network on the machine between two runs: parameters and weights in the machine's numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from nrp_brain_spinnaker.host.cells import Grid, load_cells, tau_syn_of_lines
from nrp_brain_spinnaker.host.wiring import Wires
from nrp_brain_spinnaker.loader import Loaded
from nrp_brain_spinnaker.machine.rewiring import FIRST_ROW
from nrp_brain_spinnaker.machine.synaptic_inputs import LARGEST_ENTRY, WeightArray
from nrp_brain_spinnaker.models import SYNAPSES
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_brain_spinnaker.synapses.laws import follow_targets
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import CapabilityError
from nrp_core.network.changes import ParameterChange, Rewirings, Synapses
from nrp_core.network.data import Network, Population

_WEIGHTS_DEPEND_ON = frozenset({"cm", "tau_m"})


class LiveNetwork:
    """A network on the machine whose parameters and weights can be changed.

    Args:
        network: the network as loaded.
        loaded: its arrays, which are changed in place.
        options: the user's options.
    """

    def __init__(self, network: Network, loaded: Loaded, options: SpinnakerOptions) -> None:
        self._network, self._machine, self._options = network, loaded.machine, options
        self._grid: Grid = loaded.grid
        self._wires = {part.projection.label: part for part in loaded.wires}
        self._sites, self._rewired = loaded.sites, loaded.rewired
        self._simulated = [p.label for p in network.populations.values() if not p.is_source]
        self._parameters: dict[str, Mapping[str, FloatArray]] = {}
        self._weights: dict[str, FloatArray] = {}

    def population(self, label: str) -> Population:
        """Return a population with its current parameters."""
        population = self._network.populations[label]
        return replace(population, parameters=self._parameters.get(label, population.parameters))

    def set_parameters(self, change: ParameterChange) -> Population:
        """Change parameters of cells; return their population.

        Raises:
            NetworkError: a parameter does not fit the machine's numbers.
            CapabilityError: the change would invalidate the weights onto these cells.
        """
        population = self.population(change.label)
        parameters = {name: array.copy() for name, array in population.parameters.items()}
        for name, values in change.values.items():
            parameters[name][change.index] = values
        changed = replace(population, parameters=parameters)
        if not population.is_source:
            self._require_meaning(change)
            self._load(changed)
        self._parameters[change.label] = parameters
        return changed

    def weights(self, label: str, size: int) -> FloatArray:
        """Return the current weights of a projection with ``size`` synapses on the machine."""
        if not size:
            return np.empty(0)
        if label not in self._wires:  # a reward is constant
            return next(one.weight for one in self._network.projections if one.label == label)
        part = self._wires[label]
        sizes = self._raw(part)[self._places[label]] / part.scale
        if part.factor is not None:
            sizes = sizes / part.factor[part.projection.post_index]
        return np.copysign(sizes, part.projection.weight) if (part.projection.weight < 0).any() else sizes

    def synapses(self, label: str) -> Synapses:
        """Return the synapses of a projection that form and vanish, by source cell and then by target."""
        part, rewired = self._wires[label], self._rewired
        assert rewired is not None
        numbers = [g.number for site in self._sites for g in site.groups if g.part is part]
        starts = rewired.sites.groups[numbers, FIRST_ROW]
        rows = np.concatenate([rewired.sites.row_of[start : start + part.n_pre] for start in starts])
        n = rewired.sites.length[rows]
        pre = np.repeat(np.tile(np.arange(part.n_pre, dtype=np.int32), len(starts)), n)
        ranks = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
        place = np.repeat(rewired.rows.first[rows], n) + ranks
        post = rewired.rows.line[place] % rewired.sites.n_neurons - part.post_first
        order = np.lexsort((post, pre))
        sign = -1.0 if part.receptor and not part.model.is_conductance_based else 1.0
        weight = sign * rewired.rows.weight[place] / part.scale
        delay_ms = rewired.rows.delay[place] * (part.step_us / 1000)
        return Synapses(pre[order], post[order].astype(np.int32), weight[order], delay_ms[order])

    def rewirings(self, label: str, changes: Sequence[IntArray]) -> Rewirings:
        """Return which synapses of a projection formed and vanished, of the changes of all."""
        part = self._wires[label]
        numbers = [g.number for site in self._sites for g in site.groups if g.part is part]
        every = np.concatenate([np.empty((5, 0), np.int64), *changes], axis=1)
        tick, _, pre, post, formed = every[:, np.isin(every[1], numbers)]
        pre, post = pre.astype(np.int32), post.astype(np.int32)
        return Rewirings(tick * (part.step_us / 1000), pre, post, formed.astype(bool))

    def set_weights(self, label: str, weights: FloatArray) -> None:
        """Change the weights of a projection; the shift chosen at the start stays.

        Raises:
            CapabilityError: a weight does not fit 16 bits with that shift.
        """
        if not weights.size:
            return
        if label not in self._wires:
            raise CapabilityError(
                f"projection '{label}': the weights of rewards and punishments are fixed on the machine"
            )
        part = self._wires[label]
        part = replace(part, projection=replace(part.projection, weight=weights))
        largest = float(part.sizes.max())
        if np.rint(largest * part.scale) > LARGEST_ENTRY:
            raise CapabilityError(
                f"projection '{label}': a weight of {np.abs(weights).max():g} does not fit the machine's 16 "
                "bits under the shift that was chosen for the weights at the start, which reaches "
                f"{LARGEST_ENTRY / part.scale * np.abs(weights).max() / largest:g}"
            )
        self._raw(part)[self._places[label]] = part.raw
        self._weights[label] = weights

    def save(self) -> object:
        """Return all changes."""
        return dict(self._parameters), dict(self._weights)

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        parameters, weights = saved
        for label in self._parameters.keys() | parameters.keys():
            population = self._network.populations[label]
            if not population.is_source:
                self._load(replace(population, parameters=parameters.get(label, population.parameters)))
        for label in self._weights.keys() | weights.keys():
            self.set_weights(label, weights.get(label, self._wires[label].projection.weight))
        self._parameters, self._weights = dict(parameters), dict(weights)

    def _load(self, population: Population) -> None:
        """Write the constants of a population to the machine."""
        cells, semantics = self._machine.cells, self._options.semantics
        own = cells.neurons(self._simulated.index(population.label))
        fresh = load_cells([population], cells.ids[own], self._grid, semantics)
        cells.constants[:, own] = fresh.constants
        cells.synapse_constants[:, :, own] = fresh.synapse_constants
        n = cells.ids.size
        tau_syn = np.zeros(2 * n, np.int64)
        tau_syn.reshape(2, n)[:, own] = tau_syn_of_lines([population], semantics).reshape(2, -1)
        follow_targets(self._machine.stores, tau_syn, own.start, own.stop)

    def _require_meaning(self, change: ParameterChange) -> None:
        index = self._simulated.index(change.label)
        in_mv = any(part.population == index and part.factor is not None for part in self._wires.values())
        depending = ", ".join(sorted(change.values.keys() & _WEIGHTS_DEPEND_ON))
        if in_mv and depending:
            raise CapabilityError(
                f"population '{change.label}': weights in mV were converted with {depending}, which cannot "
                "change on the machine while it runs"
            )

    def _raw(self, part: Wires) -> WeightArray:
        weights: WeightArray = getattr(self._machine.stores, part.projection.synapse_type).weight
        return weights

    @cached_property
    def _places(self) -> Mapping[str, IntArray]:
        """The positions of each projection's synapses among those of their type."""
        places: dict[str, IntArray] = {}
        for kind in sorted(SYNAPSES):
            lasting = [part for part in self._wires.values() if part.projection.rewiring is None]
            own = [part for part in lasting if part.projection.synapse_type == kind]
            places.update(_places_of(own))
        return places


def _places_of(wires: Sequence[Wires]) -> dict[str, IntArray]:
    pre = [part.projection.pre_index.astype(np.int64) + part.pre_first for part in wires]
    order = np.argsort(np.concatenate([np.empty(0, np.int64), *pre]), kind="stable")
    places = np.empty(len(order), np.int64)
    places[order] = np.arange(len(order))
    parts = np.split(places, np.cumsum([len(part) for part in pre]))
    return {part.projection.label: own for part, own in zip(wires, parts, strict=False)}
