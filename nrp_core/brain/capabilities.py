"""What a brain backend has: one typed object that the core refuses by, tests skip by and tables show."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_core.brain.network.data import Network
from nrp_core.errors import CapabilityError, nearest
from nrp_core.simulation import Determinism


@dataclass(frozen=True, slots=True)
class BrainCapabilities:
    """What a brain backend has, asked as questions.

    Args:
        cells: which PyNN standard cells can it simulate?
        synapses: which synapse types?
        extensions: which of these are additions to what the simulator is known for?
        approximate: which cells does it solve so roughly that they leave their equations by more than the
            resolution explains?
        resolution_ns: on which grid do its events lie? None: they are exact.
        determinism: how far do two runs agree?
        state_variables: which state can be read while running?
        changes: what of the network can be changed while running: ``parameters`` of its cells, ``weights``
            of its synapses? Those of source cells that the core draws always can.
        snapshot: can its state be saved and restored?
        releases_gil: can it step while Python code runs in another thread?
    """

    cells: frozenset[str]
    synapses: frozenset[str]
    extensions: frozenset[str] = frozenset()
    approximate: frozenset[str] = frozenset()
    resolution_ns: int | None = None
    determinism: Determinism = Determinism.MACHINE
    state_variables: frozenset[str] = frozenset()
    changes: frozenset[str] = frozenset()
    snapshot: bool = False
    releases_gil: bool = False

    def require(self, network: Network, name: str) -> None:
        """Check that all cells and synapses of a network are there.

        Args:
            network: the network.
            name: whose capabilities these are, for the message.

        Raises:
            CapabilityError: some are not; it names the population or projection, and the nearest that are.
        """
        for population in network.populations.values():
            if not population.is_source and population.cell_type not in self.cells:
                raise CapabilityError(
                    f"{name} has no cells of type {population.cell_type} (population '{population.label}'); "
                    f"{nearest(population.cell_type, self.cells)}"
                )
        for projection in network.projections:
            if projection.synapse_type not in self.synapses:
                raise CapabilityError(
                    f"{name} has no {projection.synapse_type} synapses (projection '{projection.label}'); "
                    f"{nearest(projection.synapse_type, self.synapses)}"
                )
