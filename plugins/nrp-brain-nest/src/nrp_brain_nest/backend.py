"""The entry point: what the backend has, its options. Importing it does not load NEST."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Annotated, ClassVar

from nrp_core._support.diagnosis import Diagnosis
from nrp_core.brain.changes import PARAMETERS, WEIGHTS
from nrp_core.brain.interface import Brain, BrainBackend, BrainCapabilities, BrainOptions
from nrp_core.brain.network.data import STATIC, STDP, TSODYKS_MARKRAM, Network
from nrp_core.brain.remote import RemoteBrain, RemoteOptions
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import BackendLoadError
from nrp_core.quantities import DurationNs
from nrp_core.simulation import Determinism
from pydantic import AfterValidator, Field

from nrp_brain_nest.cell_types import APPROXIMATE, CELL_TYPES
from nrp_brain_nest.kernel import NAME

INSTALL = "pip install 'nest-simulator>=3.9'"
_NS_PER_TIC = 1000


def _whole_tics(t_ns: int) -> int:
    if t_ns % _NS_PER_TIC or t_ns > NS_PER_MS:
        raise ValueError(f"NEST's grid is a whole number of microseconds up to 1 ms, not {t_ns} ns")
    return t_ns


class NestOptions(RemoteOptions):
    """Options of the ``nest`` backend."""

    resolution: Annotated[DurationNs, AfterValidator(_whole_tics)] = Field(
        default=100_000, description="the grid on which spikes lie and membranes are updated"
    )
    threads: int = Field(default=1, ge=1, description="threads that share the neurons")


class NestBackend(BrainBackend):
    """NEST's native models, driven directly."""

    options: ClassVar[type[BrainOptions]] = NestOptions

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        assert isinstance(options, NestOptions)
        return BrainCapabilities(
            cells=frozenset(CELL_TYPES),
            synapses=frozenset({STATIC, TSODYKS_MARKRAM, STDP}),
            approximate=APPROXIMATE,
            resolution_ns=options.resolution,
            determinism=Determinism.MACHINE,
            state_variables=frozenset().union(*(kind.readable for kind in CELL_TYPES.values())),
            changes=frozenset({PARAMETERS, WEIGHTS}),
            releases_gil=options.python is not None,
        )

    def diagnose(self) -> list[Diagnosis]:
        present = find_spec("nest") is not None
        meaning = "the simulator is here" if present else "the simulator is not in this Python"
        return [Diagnosis("NEST", present, meaning, INSTALL, needed=True)]

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        assert isinstance(options, NestOptions)
        python = options.elsewhere(NAME)
        if python is not None:
            return RemoteBrain(self, network, seed=seed, options=options.here(), python=python)
        if find_spec("nest") is None:
            raise BackendLoadError(f"NEST is not installed in this Python; try: {INSTALL}")
        from nrp_brain_nest.brain import NestBrain

        return NestBrain(network, seed, self.capabilities(options), options)
