"""How the machine is to hold one population: the hints of its script, or else the options."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ValidationError

from nrp_brain_spinnaker.hardware import POISSON_SOURCES_PER_CORE
from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core.brain.network.data import Population
from nrp_core.errors import NetworkError

_OPTIONS = frozenset({"neurons_per_core", "spikes_per_second", "ring_buffer_sigma"})
"""The hints that stand for an option, for one population."""


@dataclass(frozen=True, slots=True)
class Hints:
    """What is assumed of one population.

    Args:
        options: the options with the hints of the population.
        summed_weights: the largest sum of weights in a step that the script expects, for each receptor in
            PyNN's units; None where it says nothing.
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


def cells_per_core(population: Population, options: SpinnakerOptions) -> int:
    """Return the largest number of cells of a population on a core."""
    if not population.is_source:
        return hints_of(population, options).options.neurons_per_core
    usual = population.size if population.cell_type == "SpikeSourceArray" else POISSON_SOURCES_PER_CORE
    return int(population.hints.get("neurons_per_core", usual))


def slices_of(size: int, per_core: int) -> list[tuple[int, int]]:
    """Return the first cell and the one after the last on each core; the first cores are full."""
    return [(first, min(first + per_core, size)) for first in range(0, size, per_core)]
