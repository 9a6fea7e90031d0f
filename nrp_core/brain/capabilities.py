"""The capabilities of a brain backend, for the core's checks, the tests and the tables of the docs."""

from __future__ import annotations

from dataclasses import dataclass, replace

from nrp_core.brain.network.data import Network
from nrp_core.findings.refusals import (
    no_cells,
    no_initial_synapses,
    no_neuromodulation,
    no_rewiring,
    no_synapses,
)
from nrp_core.simulation import Determinism


@dataclass(frozen=True, slots=True)
class BrainCapabilities:
    """The capabilities of a brain backend.

    Args:
        cells: the PyNN standard cells that it simulates.
        synapses: the synapse types that it simulates.
        extensions: the cells and synapses that the original simulator does not have.
        approximate: the cells whose error is larger than the resolution explains.
        resolution_ns: the time grid of its events; None if event times are exact.
        determinism: how closely two runs agree.
        state_variables: the state variables that can be read while it runs.
        changes: what can change while it runs: ``parameters`` of cells, ``weights`` of synapses.
            Parameters of source cells whose spikes the core draws can always change.
        initial_synapses: whether the state of synapses at time 0 can be given.
        rewiring: whether synapses can form and vanish while it runs.
        neuromodulation: whether rewards and punishments can decide on STDP.
        snapshot: whether its state can be saved and restored.
        releases_gil: whether it can step while Python code runs in another thread.
    """

    cells: frozenset[str]
    synapses: frozenset[str]
    extensions: frozenset[str] = frozenset()
    approximate: frozenset[str] = frozenset()
    resolution_ns: int | None = None
    determinism: Determinism = Determinism.MACHINE
    state_variables: frozenset[str] = frozenset()
    changes: frozenset[str] = frozenset()
    initial_synapses: bool = False
    rewiring: bool = False
    neuromodulation: bool = False
    snapshot: bool = False
    releases_gil: bool = False

    def extended(self, network: Network) -> BrainCapabilities:
        """Return these capabilities with the state variables that the network's own equations add."""
        models = [one.equations.model for one in network.populations.values() if one.equations is not None]
        own = frozenset(name for model in models for name in (*model.variables, *model.recorded))
        return replace(self, state_variables=self.state_variables | own) if own else self

    def require(self, network: Network, name: str) -> None:
        """Check that the backend has all cells and synapses of a network.

        Args:
            network: the network.
            name: the backend, for the message.

        Raises:
            CapabilityError: a type is missing; the message names its owner and the nearest supported type.
        """
        for population in network.populations.values():
            if not population.is_source and population.cell_type not in self.cells:
                raise no_cells(name, population.cell_type, population.label, self.cells)
        for projection in network.projections:
            if projection.synapse_type not in self.synapses:
                raise no_synapses(name, projection.synapse_type, projection.label, self.synapses)
            if projection.initial_values and not self.initial_synapses:
                raise no_initial_synapses(name, projection.label, projection.initial_values)
            if projection.rewiring is not None and not self.rewiring:
                raise no_rewiring(name, projection.label)
            if projection.neuromodulation is not None and not self.neuromodulation:
                raise no_neuromodulation(name, projection.label)
