"""The entry point and capabilities of the backend. Importing it does not load Brian2."""

from __future__ import annotations

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
from nrp_core.errors import BackendLoadError, CapabilityError
from nrp_core.simulation import Determinism

from nrp_brain_brian2.options import CELL, INSTALL, NAME, Brian2Options


class Brian2Backend(BrainBackend):
    """Scripts of Brian2, executed and stepped in Brian2 itself."""

    options: ClassVar[type[BrainOptions]] = Brian2Options

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        assert isinstance(options, Brian2Options)
        return BrainCapabilities(
            cells=frozenset({CELL}),
            synapses=frozenset(),
            resolution_ns=100_000,
            determinism=Determinism.MACHINE,
            state_variables=frozenset({"v"}),
            releases_gil=options.python is not None,
        )

    def diagnose(self) -> list[Diagnosis]:
        present = find_spec("brian2") is not None
        meaning = "the simulator is installed" if present else "the simulator is not installed in this Python"
        return [Diagnosis(NAME, present, meaning, INSTALL, needed=True)]

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        assert isinstance(options, Brian2Options)
        if (python := options.elsewhere(NAME)) is not None:
            return RemoteBrain(self, network, seed=seed, options=options.here(), python=python)
        if find_spec("brian2") is None:
            raise BackendLoadError("Brian2 is not installed in this Python", remedy=INSTALL)
        from nrp_core.network.native import NativeNetwork

        from nrp_brain_brian2.brain import Brian2Brain

        self.capabilities(options).require(network, NAME)
        if not isinstance(network, NativeNetwork):
            raise CapabilityError("Brian2 runs only a single script of its own: 'native: true' in 'brain'")
        return Brian2Brain(network, seed, self.capabilities(options), options)
