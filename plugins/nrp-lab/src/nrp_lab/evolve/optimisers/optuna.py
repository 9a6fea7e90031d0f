"""The samplers of Optuna. Its journal file in the folder is for Optuna's own tools, such as its dashboard."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar
from warnings import catch_warnings, simplefilter

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.extras import require_extra
from nrp_lab.evolve.optimisers.interface import Optimiser, Space

JOURNAL = "optuna.journal"


class OptunaOptimiser(Optimiser):
    """A study of Optuna, made anew from the values whenever a search is repeated."""

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
