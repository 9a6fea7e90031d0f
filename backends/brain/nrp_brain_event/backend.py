"""The entry point and capabilities of the backend. Importing it does not load a compiler."""

from __future__ import annotations

from typing import ClassVar

from nrp_brain_event.options import EventOptions, lazy_grid_obstacle
from nrp_brain_event.synapse_laws import SYNAPSES
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.network.changes import EQUATIONS, PARAMETERS, PLASTICITY, SYNAPSE_STATE, WEIGHTS
from nrp_core.network.data import Network
from nrp_core.network.equations.model import CELL_TYPE
from nrp_core.network.synapses import CONTINUOUS
from nrp_core.simulation import Determinism


class EventBackend(BrainBackend):
    """Exact event-driven simulation: closed-form solutions or adaptive integration."""

    options: ClassVar[type[BrainOptions]] = EventOptions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        from nrp_brain_event.cell_types import CELL_TYPES

        assert isinstance(options, EventOptions)
        variables = (kind.state_variables for kind in CELL_TYPES.values())
        on_grid = options.resolution is not None
        return BrainCapabilities(
            cells=frozenset(CELL_TYPES) | (frozenset({CELL_TYPE}) if on_grid else frozenset()),
            synapses=SYNAPSES | (CONTINUOUS if on_grid else frozenset()),
            resolution_ns=options.resolution,
            determinism=Determinism.MACHINE,
            state_variables=frozenset().union(*variables),
            changes=frozenset({EQUATIONS, PARAMETERS, PLASTICITY, WEIGHTS}),
            initial_synapses=True,
            neuromodulation=True,
            rewards=True,
            synapse_state=SYNAPSE_STATE,
            snapshot=True,
            releases_gil=True,
            late_spikes=True,
        )

    def warnings(self, network: Network, options: BrainOptions) -> list[str]:
        from nrp_brain_event.connections import delay_range

        assert isinstance(options, EventOptions)
        if options.resolution is None:
            delay_range(network)
        obstacle = lazy_grid_obstacle(network, options) if options.lazy == "always" else ""
        return [f"`lazy: always` has no effect: {obstacle}"] if obstacle else []

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        assert isinstance(options, EventOptions)
        if options.resolution is not None:
            from nrp_brain_event.grid.brain import GridBrain
            from nrp_brain_event.grid.lazy_brain import LazyBrain

            kind = GridBrain if lazy_grid_obstacle(network, options) else LazyBrain
            return kind(network, seed, self.capabilities(options), options, options.resolution)
        from nrp_brain_event.brain import EventBrain

        return EventBrain(network, seed, self.capabilities(options), options)
