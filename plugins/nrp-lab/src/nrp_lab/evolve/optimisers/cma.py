"""Covariance matrix adaptation, by N. Hansen's package."""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.extras import require_extra
from nrp_lab.evolve.optimisers.interface import Optimiser, Space

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
