"""Interventions that cut or scale the synapses of named cells, before or during a run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nrp_core.brain.network.controls import LISTED, chosen
from nrp_core.brain.network.data import Network, Projection
from nrp_core.brain.network.synapses.stdp import STDP


@dataclass(frozen=True, slots=True)
class Intervention:
    """A factor for the weights of some synapses.

    Args:
        sources: the population or view with the presynaptic cells; None for any cell.
        targets: the population or view with the postsynaptic cells; None for any cell.
        factor: 0 or more; 0 cuts the synapses.
        either: whether a synapse is selected if only one of its ends matches.
    """

    sources: str | None
    targets: str | None
    factor: float = 0.0
    either: bool = False

    @classmethod
    def silence(cls, cells: str) -> Intervention:
        """Cut all synapses from cells: their spikes have no effect."""
        return cls(cells, None)

    @classmethod
    def lesion(cls, cells: str) -> Intervention:
        """Cut all synapses from and to cells."""
        return cls(cells, cells, either=True)

    def synapses(self, network: Network, projection: Projection) -> npt.NDArray[np.bool_]:
        """Return for each synapse of a projection whether it is selected.

        Raises:
            NeuronSelectionError: there are no such cells.
        """
        ends = []
        for name, label, index in (
            (self.sources, projection.pre, projection.pre_index),
            (self.targets, projection.post, projection.post_index),
        ):
            is_meant = np.full(network.size, name is None)
            if name is not None:
                is_meant[network.neurons(name)] = True
            ends.append(is_meant[network.offsets[label] + index])
        before, behind = ends
        meant: npt.NDArray[np.bool_] = before | behind if self.either else before & behind
        return meant

    def require_cells(self, network: Network) -> None:
        """Raise NeuronSelectionError unless the network has the named cells."""
        for name in (self.sources, self.targets):
            if name is not None:
                network.neurons(name)

    def of(self, network: Network) -> Network:
        """Return the network with the intervention; other projections stay the same objects.

        Raises:
            NeuronSelectionError: there are no such cells.
        """
        self.require_cells(network)
        projections = []
        for projection in network.projections:
            meant = self.synapses(network, projection)
            projections.append(self._changed(projection, meant) if meant.any() else projection)
        return replace(network, projections=tuple(projections))

    def affected(self, network: Network) -> list[Projection]:
        """Return the projections with selected synapses.

        Raises:
            NeuronSelectionError: there are no such cells.
        """
        self.require_cells(network)
        return [one for one in network.projections if self.synapses(network, one).any()]

    def _changed(self, projection: Projection, meant: npt.NDArray[np.bool_]) -> Projection:
        if self.factor == 0.0:
            return chosen(projection, ~meant)
        share = np.where(meant, self.factor, 1.0)
        limits = ("w_min", "w_max") if projection.synapse_type == STDP else ()
        parameters = {
            name: values * share if name in limits else values
            for name, values in projection.synapse_parameters.items()
        }
        return replace(
            projection,
            weight=projection.weight * share,
            synapse_parameters=parameters,
            origin=LISTED,
        )
