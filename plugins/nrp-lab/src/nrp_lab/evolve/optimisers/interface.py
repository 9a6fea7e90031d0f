"""The interface of an optimiser. Other packages add theirs by an entry point in ``nrp_core.optimisers``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import ExperimentError
from nrp_core.registry import Registry
from nrp_core.seeds import Seeds


@dataclass(frozen=True, slots=True)
class Space:
    """The search.

    Args:
        keys: the settings, one dimension each; every one goes from 0 to 1 in the scale of its range.
        objectives: number of values of a candidate.
        population: number of candidates in a generation.
        seeds: the random streams of the optimiser; it uses no others.
        folder: the folder of the search.
    """

    keys: tuple[str, ...]
    objectives: int
    population: int
    seeds: Seeds
    folder: Path


class Optimiser(ABC):
    """Searches the unit cube for large values. Equal values give equal candidates, on every repetition.

    Attributes:
        most_objectives: the largest number of objectives; None: any.
        least_population: the smallest number of candidates.
    """

    most_objectives: ClassVar[int | None] = 1
    least_population: ClassVar[int] = 1

    @abstractmethod
    def begin(self, space: Space) -> None:
        """Begin a search.

        Raises:
            BackendLoadError: a package is not installed.
        """

    @abstractmethod
    def ask(self) -> FloatArray:
        """Return the candidates of the next generation, shape ``(population, dimensions)``."""

    @abstractmethod
    def tell(self, values: FloatArray) -> None:
        """Take their values, larger is better, shape ``(population, objectives)``; NaN: it failed."""

    @property
    def finished(self) -> str:
        """The reason why more generations are useless; empty if they are not."""
        return ""


OPTIMISERS: Registry[Optimiser] = Registry("nrp_core.optimisers", "optimiser", [Optimiser])


def optimiser(name: str, space: Space) -> Optimiser:
    """Return an optimiser that has begun a search.

    Raises:
        ExperimentError: it cannot do this search.
        BackendError: it does not exist or load.
    """
    made = OPTIMISERS.load(name)
    if made.most_objectives is not None and space.objectives > made.most_objectives:
        raise ExperimentError(
            f"the optimiser '{name}' has one objective, not {space.objectives}; 'nsga2' takes several"
        )
    if space.population < made.least_population:
        raise ExperimentError(
            f"population: '{name}' needs at least {made.least_population}, not {space.population}"
        )
    made.begin(space)
    return made
