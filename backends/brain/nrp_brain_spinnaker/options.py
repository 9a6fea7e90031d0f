"""The options of the emulated machine.

How the machine holds one population: by the hints of its script, or else by the options.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationError

from nrp_brain_spinnaker.hardware import NEURONS_PER_CORE, POISSON_SOURCES_PER_CORE
from nrp_brain_spinnaker.models import Semantics
from nrp_core.brain.backend import BrainOptions
from nrp_core.errors import NetworkError
from nrp_core.network.data import Population
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


_OPTIONS = frozenset({"neurons_per_core", "spikes_per_second", "ring_buffer_sigma"})
"""The hints that stand for an option, for one population."""


@dataclass(frozen=True, slots=True)
class Hints:
    """What is assumed of one population.

    Args:
        options: the options with the hints of the population.
        summed_weights: the largest sum of weights in a step that the script expects, for each receptor in
            PyNN's units; None where the script sets nothing.
        synapse_cores: the number of synapse-only cores that the script asks for, or None.
    """

    options: SpinnakerOptions
    summed_weights: tuple[float | None, float | None]
    synapse_cores: int | None


def hints_of(population: Population, options: SpinnakerOptions) -> Hints:
    """Return the hints of a population.

    Raises:
        NetworkError: a hint is not a valid option.
    """
    hints = population.hints
    own = {name: hints[name] for name in hints.keys() & _OPTIONS}
    if population.is_source:  # the limit of a core is another one for sources
        own.pop("neurons_per_core", None)
    if own:
        try:
            valid = SpinnakerOptions.model_validate(own)
        except ValidationError as error:
            wrong = [f"{found['loc'][0]} is {found['input']:g}: {found['msg']}" for found in error.errors()]
            raise NetworkError(f"population '{population.label}': {'; '.join(wrong)}") from None
        options = options.model_copy(update={name: getattr(valid, name) for name in own})
    cores = hints.get("synapse_cores")
    return Hints(
        options,
        (hints.get("max_summed_weight_exc"), hints.get("max_summed_weight_inh")),
        None if cores is None else int(cores),
    )


def hinted_substeps(population: Population) -> int:
    """Return the number of updates in a time step that a script asks for."""
    return int(population.hints.get("n_steps_per_timestep", 1))


def cells_per_core(population: Population, options: SpinnakerOptions) -> int:
    """Return the largest number of cells of a population on a core."""
    if not population.is_source:
        return hints_of(population, options).options.neurons_per_core
    usual = population.size if population.cell_type == "SpikeSourceArray" else POISSON_SOURCES_PER_CORE
    return int(population.hints.get("neurons_per_core", usual))


def slices_of(size: int, per_core: int) -> list[tuple[int, int]]:
    """Return the first cell and the one after the last on each core; the first cores are full."""
    return [(first, min(first + per_core, size)) for first in range(0, size, per_core)]
