"""Options of the ``event`` backend."""

from __future__ import annotations

from typing import Final, Literal, Self

from pydantic import Field, model_validator

from nrp_core.brain.backend import BrainOptions
from nrp_core.clock import NS_PER_MS
from nrp_core.quantities import DurationNs

_TOLERANCE_MV: Final = 1e-9


class EventOptions(BrainOptions):
    """Options of the ``event`` backend."""

    tolerance: float = Field(
        default=_TOLERANCE_MV,
        gt=1e-13,
        le=1e-2,
        description="largest local error (mV) of an integration step, for cells without a closed form: "
        "conductance-based, adaptive exponential, Izhikevich, Hodgkin-Huxley",
    )
    resolution: DurationNs | None = Field(
        default=None,
        description="a time grid, e.g. `0.1 ms`, on which all spikes lie; many times faster for dense "
        "networks; by default spike times are exact",
    )
    poisson: Literal["core", "grid"] = Field(
        default="core",
        description="which part draws SpikeSourcePoisson spikes: the core, so that all backends get the same "
        "spikes, or the grid, many times faster, for populations of equal cells with one synapse each",
    )

    lazy: Literal["auto", "always", "never"] = Field(
        default="auto",
        description="whether the grid works only for the neurons that events reach, with the same spikes: "
        "where that is expected to be faster, wherever it is possible, or never",
    )
    threads: int = Field(
        default=1,
        ge=1,
        le=64,
        description="number of threads for the neurons on the grid, with the same result to the last bit: "
        "for many thousands of neurons, delays of 1 ms or more, and free cores",
    )

    @model_validator(mode="after")
    def _check_grid(self) -> Self:
        if self.resolution is None and self.poisson == "grid":
            raise ValueError("poisson: grid needs a resolution, e.g. 0.1 ms")
        if self.resolution is None and self.threads > 1:
            raise ValueError(
                f"threads: {self.threads} needs a resolution, e.g. 0.1 ms; the exact mode uses one thread"
            )
        if self.resolution is None and self.lazy == "always":
            raise ValueError("lazy: always needs a resolution, e.g. 0.1 ms; the exact mode is lazy by itself")
        if self.resolution is not None and self.tolerance != _TOLERANCE_MV:
            raise ValueError(
                f"tolerance: {self.tolerance:g} has no effect with a resolution, whose steps are fixed"
            )
        if self.resolution is not None and self.resolution > NS_PER_MS:
            raise ValueError(f"resolution must be 1 ms or finer, not {self.resolution / NS_PER_MS:g} ms")
        return self
