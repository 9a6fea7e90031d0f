"""Options of the ``pynn`` backend."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from nrp_core.brain import RemoteOptions
from nrp_core.clock import NS_PER_MS
from nrp_core.quantities import DurationNs
from pydantic import AfterValidator, Field, model_validator

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

    processes: int = Field(
        default=1, ge=1, description="for NEURON: the number of MPI processes that share the cells"
    )
    compiled: bool = Field(
        default=False,
        description="for Brian2: compile its loops, which takes half a minute the first time",
    )

    @model_validator(mode="after")
    def _require_neuron(self) -> Self:
        if self.processes > 1 and self.simulator != "neuron":
            raise ValueError(f"only NEURON runs in several processes, not {self.chosen.name}")
        return self

    def here(self) -> Self:
        return super().here().model_copy(update={"processes": 1})

    @property
    def chosen(self) -> Simulator:
        """The description of the simulator."""
        return SIMULATORS[self.simulator]
