"""Interventions that cut or scale the synapses of named cells, before or during a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nrp_core.network.data import LISTED, Network, Projection
from nrp_core.network.synapses import LAWS

Synapses = npt.NDArray[np.bool_]
"""For each synapse of a projection, whether it is selected."""


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

    def synapses(self, network: Network) -> dict[str, Synapses]:
        """Return the selected synapses of each projection that has some, by its label.

        Raises:
            NeuronSelectionError: the cells do not exist.
        """
        sources, targets = (_cells(network, name) for name in (self.sources, self.targets))
        found = {}
        for projection in network.projections:
            before = sources[network.offsets[projection.pre] + projection.pre_index]
            behind = targets[network.offsets[projection.post] + projection.post_index]
            selected = before | behind if self.either else before & behind
            if selected.any():
                found[projection.label] = selected
        return found

    def of(self, network: Network, synapses: Mapping[str, Synapses] | None = None) -> Network:
        """Return the network with the intervention; other projections stay the same objects.

        Args:
            network: the network.
            synapses: as :meth:`synapses` returns them, if they are already known.

        Raises:
            NeuronSelectionError: the cells do not exist.
        """
        selected = self.synapses(network) if synapses is None else synapses
        projections = tuple(
            self._apply_to(projection, selected[projection.label])
            if projection.label in selected
            else projection
            for projection in network.projections
        )
        return replace(network, projections=projections)

    def _apply_to(self, projection: Projection, synapses: Synapses) -> Projection:
        if self.factor == 0.0:
            return projection.only(~synapses)
        share = np.where(synapses, self.factor, 1.0)
        law = LAWS.get(projection.synapse_type)  # parameters in equations have units of their own
        like_weights = law.in_units_of_weight if law else frozenset()
        parameters = {
            name: values * share if name in like_weights else values
            for name, values in projection.synapse_parameters.items()
        }
        return replace(
            projection,
            weight=projection.weight * share,
            synapse_parameters=parameters,
            origin=LISTED,
        )


def _cells(network: Network, name: str | None) -> npt.NDArray[np.bool_]:
    """Return for each cell of a network whether it has a name; without a name all do."""
    cells = np.full(network.size, name is None)
    if name is not None:
        cells[network.neurons(name)] = True
    return cells
