"""The entry point and capabilities of the backend. Importing it does not load NEST."""

from __future__ import annotations

from importlib.util import find_spec
from typing import ClassVar

from nrp_core.brain import (
    DOPAMINE,
    ELIGIBILITY,
    PARAMETERS,
    STATIC,
    STDP,
    TSODYKS_MARKRAM,
    WEIGHTS,
    Brain,
    BrainBackend,
    BrainCapabilities,
    BrainOptions,
    Diagnosis,
    Network,
    RemoteBrain,
)
from nrp_core.errors import BackendLoadError
from nrp_core.simulation import Determinism

from nrp_brain_nest.cell_types import APPROXIMATE, CELL_TYPES, CONDUCTANCE_CELL, CURRENT_CELL
from nrp_brain_nest.kernel import NAME
from nrp_brain_nest.options import NestOptions

INSTALL = "pip install 'nest-simulator>=3.9'"


class NestBackend(BrainBackend):
    """NEST's native models, driven directly."""

    options: ClassVar[type[BrainOptions]] = NestOptions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        assert isinstance(options, NestOptions)
        return BrainCapabilities(
            cells=frozenset({*CELL_TYPES, CURRENT_CELL, CONDUCTANCE_CELL}),
            synapses=frozenset({STATIC, TSODYKS_MARKRAM, STDP}),
            approximate=APPROXIMATE,
            resolution_ns=options.resolution,
            determinism=Determinism.MACHINE,
            state_variables=frozenset().union(*(kind.readable for kind in CELL_TYPES.values())),
            changes=frozenset({PARAMETERS, WEIGHTS}),
            neuromodulation=True,
            rewards=True,
            synapse_state=frozenset({ELIGIBILITY, DOPAMINE}),
            releases_gil=options.python is not None,
        )

    def diagnose(self) -> list[Diagnosis]:
        present = find_spec("nest") is not None
        meaning = "the simulator is installed" if present else "the simulator is not installed in this Python"
        return [Diagnosis("NEST", present, meaning, INSTALL, needed=True)]

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        assert isinstance(options, NestOptions)
        python = options.elsewhere(NAME)
        if python is not None:
            return RemoteBrain(self, network, seed=seed, options=options.here(), python=python)
        if find_spec("nest") is None:
            raise BackendLoadError("NEST is not installed in this Python", remedy=INSTALL)
        from nrp_core.network.native import NativeNetwork

        from nrp_brain_nest.brain import NestBrain
        from nrp_brain_nest.native_brain import NativeNestBrain

        if isinstance(network, NativeNetwork):
            return NativeNestBrain(network, seed, self.capabilities(options), options)
        return NestBrain(network, seed, self.capabilities(options), options)
