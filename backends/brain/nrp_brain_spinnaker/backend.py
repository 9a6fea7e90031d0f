"""The entry point. Its imports are light; the engine is loaded when a brain is opened."""

from __future__ import annotations

from typing import ClassVar

from nrp_brain_spinnaker.models import EXTENDED_SYNAPSES, STATE_VARIABLES, SYNAPSES, cell_models
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.capabilities import Report
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.findings import Findings
from nrp_core.network.changes import PARAMETERS, WEIGHTS
from nrp_core.network.data import Network
from nrp_core.simulation import Determinism

APPROXIMATE = frozenset({"Izhikevich", "IZK_curr_exp", "IZK_cond_exp"})
"""One midpoint step per tick, even during the upstroke of a spike."""


class SpinnakerBackend(BrainBackend):
    """A SpiNNaker machine in software: fixed-point arithmetic, a time step, 16-bit weights."""

    options: ClassVar[type[BrainOptions]] = SpinnakerOptions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        assert isinstance(options, SpinnakerOptions)
        models = cell_models(options.semantics)
        return BrainCapabilities(
            cells=frozenset(models),
            synapses=SYNAPSES,
            extensions=frozenset({*EXTENDED_SYNAPSES, *(name for name, m in models.items() if m.extension)}),
            approximate=APPROXIMATE,
            resolution_ns=options.timestep,
            determinism=Determinism.BITWISE,
            state_variables=STATE_VARIABLES,
            changes=frozenset({PARAMETERS, WEIGHTS}),
            rewiring=True,
            neuromodulation=True,
            snapshot=True,
            releases_gil=True,
            late_spikes=True,
            spike_lag_ns=options.timestep,
        )

    def reports(self, network: Network, options: BrainOptions) -> list[Report]:
        from nrp_brain_spinnaker.mapping.reports import reports_of

        assert isinstance(options, SpinnakerOptions)
        return reports_of(network, options)

    def warnings(self, network: Network, options: BrainOptions) -> Findings:
        from nrp_brain_spinnaker.loader import lay_out

        assert isinstance(options, SpinnakerOptions)
        return lay_out(network, options)[2]

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        from nrp_brain_spinnaker.brain import SpinnakerBrain

        assert isinstance(options, SpinnakerOptions)
        return SpinnakerBrain(network, seed=seed, capabilities=self.capabilities(options), options=options)
