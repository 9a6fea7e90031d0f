"""The entry point: the simulators and their options. Importing it does not load them."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import ClassVar

from nrp_core.brain import (
    Brain,
    BrainBackend,
    BrainCapabilities,
    BrainOptions,
    Diagnosis,
    Network,
    RemoteBrain,
)
from nrp_core.errors import BackendLoadError

from nrp_brain_pynn.job import program_for
from nrp_brain_pynn.options import PyNNOptions
from nrp_brain_pynn.simulators import SIMULATORS


class PyNNBackend(BrainBackend):
    """Any simulator of PyNN."""

    options: ClassVar[type[BrainOptions]] = PyNNOptions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        assert isinstance(options, PyNNOptions)
        chosen = options.chosen
        return BrainCapabilities(
            cells=chosen.cells,
            synapses=chosen.synapses,
            approximate=chosen.approximate,
            resolution_ns=options.timestep,
            determinism=chosen.determinism,
            state_variables=chosen.state_variables,
            changes=chosen.changes,
            releases_gil=options.python is not None,
        )

    def diagnose(self) -> list[Diagnosis]:
        return [
            Diagnosis(one.name, find_spec(one.package) is not None, f"simulator: {name}", one.install)
            for name, one in SIMULATORS.items()
        ]

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        assert isinstance(options, PyNNOptions)
        chosen = options.chosen
        python = options.elsewhere(chosen.name)
        if options.processes > 1:
            python = program_for(python or sys.executable, options.processes)
        if python is not None:
            return RemoteBrain(self, network, seed=seed, options=options.here(), python=python)
        if find_spec(chosen.package) is None:
            raise BackendLoadError(f"{chosen.name} is not installed in this Python", remedy=chosen.install)
        from nrp_brain_pynn.brain import PyNNBrain

        return PyNNBrain(network, seed, self.capabilities(options), options)
