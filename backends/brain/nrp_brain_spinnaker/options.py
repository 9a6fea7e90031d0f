"""The options of the emulated machine."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from nrp_brain_spinnaker.hardware import NEURONS_PER_CORE
from nrp_brain_spinnaker.models import Semantics
from nrp_core.brain.backend import BrainOptions
from nrp_core.quantities import DurationNs, RateHz

NS_PER_US = 1000


def _whole_microseconds(t_ns: int) -> int:
    if t_ns % NS_PER_US:
        raise ValueError(
            f"the machine's timer counts whole microseconds, so {t_ns} ns is not a valid time step"
        )
    return t_ns


class SpinnakerOptions(BrainOptions):
    """Options of the ``spinnaker`` backend."""

    timestep: Annotated[DurationNs, AfterValidator(_whole_microseconds)] = Field(
        default=1_000_000,
        description="the time step; the machine is designed for 1 ms, and 0.1 ms is possible",
    )
    substeps: int = Field(default=1, ge=1, description="number of updates of every neuron in a time step")
    semantics: Semantics = Field(
        default="pynn",
        description="meaning of cell types and weights: as defined by PyNN or as in sPyNNaker 7.4.1",
    )
    weights: Literal["machine", "host"] = Field(
        default="machine",
        description="machine: connectors that sPyNNaker expands on the cores round weights to s16.15 first; "
        "host: all weights are converted in full precision",
    )
    poisson: Literal["core", "machine"] = Field(
        default="core",
        description="which part draws SpikeSourcePoisson spikes: the core, so that all backends get the same "
        "spikes, or the machine's own generator",
    )
    neurons_per_core: int = Field(
        default=NEURONS_PER_CORE,
        ge=1,
        le=NEURONS_PER_CORE,
        description="neurons on a core; limits the delays",
    )
    spikes_per_second: RateHz = Field(
        default=30.0, description="assumed firing rate of every neuron (Hz), used to choose shifts"
    )
    ring_buffer_sigma: float = Field(
        default=5.0, ge=0, description="standard deviations of summed input that must fit, if delays differ"
    )

    @property
    def step_us(self) -> int:
        """Length of a tick, us."""
        return self.timestep // NS_PER_US
