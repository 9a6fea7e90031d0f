"""Options of the ``pynn`` backend."""

from __future__ import annotations

from typing import Annotated, Literal

from nrp_core.brain import RemoteOptions
from nrp_core.clock import NS_PER_MS
from nrp_core.quantities import DurationNs
from pydantic import AfterValidator, Field

from nrp_brain_pynn.simulators import SIMULATORS, Simulator

_NS_PER_US = 1000


def _whole_microseconds(t_ns: int) -> int:
    if t_ns % _NS_PER_US or not 0 < t_ns <= NS_PER_MS:
        raise ValueError(f"the time step is a whole number of microseconds up to 1 ms, not {t_ns} ns")
    return t_ns


class PyNNOptions(RemoteOptions):
    """Options of the ``pynn`` backend."""

    simulator: Literal["neuron", "brian2", "spinnaker"] = Field(
        default="neuron", description="the simulator of PyNN"
    )
    timestep: Annotated[DurationNs, AfterValidator(_whole_microseconds)] = Field(
        default=100_000, description="the integration step of the simulator"
    )

    compiled: bool = Field(
        default=False,
        description="for Brian2: compile its loops, which takes half a minute the first time",
    )

    @property
    def chosen(self) -> Simulator:
        """The description of the simulator."""
        return SIMULATORS[self.simulator]
