"""The entry point: what the backend has, its options. Importing it loads no compiler."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from nrp_core.brain.interface import Brain, BrainBackend, BrainCapabilities, BrainOptions
from nrp_core.brain.network import STATIC, TSODYKS_MARKRAM, Network
from nrp_core.simulation import Determinism


class EventOptions(BrainOptions):
    """Options of the ``event`` backend."""

    tolerance: float = Field(
        default=1e-9,
        gt=1e-13,
        le=1e-2,
        description="largest local error (mV) of an integration step, for cells without a closed form: "
        "conductance-based, adaptive exponential, Izhikevich, Hodgkin-Huxley",
    )


class EventBackend(BrainBackend):
    """Exact event-driven simulation: closed forms where there are any, adaptive integration elsewhere."""

    options: ClassVar[type[BrainOptions]] = EventOptions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        from nrp_brain_event.cell_types import CELL_TYPES

        variables = (kind.state_variables for kind in CELL_TYPES.values())
        return BrainCapabilities(
            cells=frozenset(CELL_TYPES),
            synapses=frozenset({STATIC, TSODYKS_MARKRAM}),
            resolution_ns=None,
            determinism=Determinism.MACHINE,
            state_variables=frozenset().union(*variables),
            snapshot=True,
            releases_gil=True,
        )

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        from nrp_brain_event.brain import EventBrain

        assert isinstance(options, EventOptions)
        return EventBrain(network, seed, self.capabilities(options), options)
