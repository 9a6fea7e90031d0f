"""Optimisers: their interface, CMA-ES and those of Optuna; ``nrp_core.optimisers`` adds others."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import nan
from pathlib import Path
from typing import Any, ClassVar
from warnings import catch_warnings, simplefilter

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.errors import ExperimentError
from nrp_core.registry import Registry
from nrp_core.seeds import Seeds
from nrp_core.utilities import require_extra


@dataclass(frozen=True, slots=True)
class Space:
    """The search.

    Args:
        keys: the settings, one dimension each, from 0 to 1 in the scale of its range.
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
        """Record values of candidates, shape ``(population, objectives)``; larger is better, NaN: failed."""

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


_STEP = 0.3
"""The first standard deviation, as a share of each range."""


class CmaOptimiser(Optimiser):
    """CMA-ES from a random point of the ranges."""

    least_population = 3

    def begin(self, space: Space) -> None:
        require_extra("cma", "nrp-lab[evolve]", "the optimiser cma")
        from cma import CMAEvolutionStrategy

        rng = space.seeds.stream("cma")
        options = {
            "bounds": [0, 1],
            "popsize": space.population,
            "randn": lambda *shape: rng.standard_normal(shape),
            "seed": nan,  # leaves the global generator alone
            "verbose": -9,
            "verb_log": 0,
        }
        self._search: Any = CMAEvolutionStrategy(rng.random(len(space.keys)), _STEP, options)

    def ask(self) -> FloatArray:
        self._asked = self._search.ask()
        return np.array(self._asked)

    def tell(self, values: FloatArray) -> None:
        costs = -values[:, 0]
        known = costs[np.isfinite(costs)]
        worst = known.max() + np.ptp(known) + 1.0 if len(known) else 0.0
        self._search.tell(self._asked, np.where(np.isfinite(costs), costs, worst).tolist())

    @property
    def finished(self) -> str:
        return ", ".join(f"{name} {value:g}" for name, value in self._search.stop().items())


JOURNAL = "optuna.journal"


class OptunaOptimiser(Optimiser):
    """A study of Optuna, rebuilt from the values when a search is repeated."""

    name: ClassVar[str]

    def begin(self, space: Space) -> None:
        require_extra("optuna", "nrp-lab[evolve]", f"the optimiser {self.name}")
        import optuna
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._space, self._states = space, optuna.trial.TrialState
        self._ranges = {key: optuna.distributions.FloatDistribution(0.0, 1.0) for key in space.keys}
        journal = space.folder / JOURNAL
        journal.unlink(missing_ok=True)
        with catch_warnings():
            simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            self._study: Any = optuna.create_study(
                storage=JournalStorage(JournalFileBackend(str(journal))),
                study_name="nrp",
                directions=["maximize"] * space.objectives,
                sampler=self._sampler(optuna.samplers),
            )

    @abstractmethod
    def _sampler(self, samplers: Any) -> Any:
        """Return the sampler."""

    @property
    def _seed(self) -> int:
        return self._space.seeds.integer(self.name)

    def ask(self) -> FloatArray:
        self._asked = [self._study.ask(self._ranges) for _ in range(self._space.population)]
        return np.array([[trial.params[key] for key in self._space.keys] for trial in self._asked])

    def tell(self, values: FloatArray) -> None:
        for trial, own in zip(self._asked, values, strict=True):
            if np.isfinite(own).all():
                self._study.tell(trial, own.tolist())
            else:
                self._study.tell(trial, state=self._states.FAIL)


class TpeOptimiser(OptunaOptimiser):
    """Tree-structured Parzen estimators; the first generation is random."""

    name = "tpe"

    def _sampler(self, samplers: Any) -> Any:
        first = self._space.population
        return samplers.TPESampler(
            seed=self._seed, n_startup_trials=first, multivariate=True, constant_liar=True
        )


class Nsga2Optimiser(OptunaOptimiser):
    """A genetic algorithm for several objectives."""

    name = "nsga2"
    most_objectives = None
    least_population = 2

    def _sampler(self, samplers: Any) -> Any:
        return samplers.NSGAIISampler(seed=self._seed, population_size=self._space.population)
