"""Statistical: random values have the right distribution, not only the right mean.

16 000 events find a bias of the rate by 5 % with a probability of 0.998.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nrp_core.conformance.brain.kit import BrainKit, record
from nrp_core.conformance.brain.parts import poisson
from nrp_core.conformance.statistics import of_chi_square, of_normal, require_likely

RATE_HZ, N_CELLS, DURATION_S, BIN_MS = 100.0, 8, 20.0, 20.0
Counts = npt.NDArray[np.float64]


class StatisticalTests(BrainKit):
    """Poisson sources: mean, variance, independence of each other and of the past."""

    level = "statistical"

    def test_a_poisson_source_has_the_given_rate(self) -> None:
        expected = RATE_HZ * DURATION_S * N_CELLS

        def probability(seed: int) -> float:
            return of_normal((self._counts(seed).sum() - expected) / expected**0.5)

        self.note("p", require_likely(probability))

    def test_the_counts_of_a_poisson_source_vary_as_much_as_their_mean(self) -> None:
        def probability(seed: int) -> float:
            counts = self._counts(seed)
            freedom = counts.size - 1
            return of_chi_square(freedom * counts.var(ddof=1) / counts.mean(), freedom)

        self.note("p", require_likely(probability))

    def test_poisson_sources_are_independent_of_each_other(self) -> None:
        def probability(seed: int) -> float:
            counts = self._counts(seed)
            return _uncorrelated(counts[:-1].ravel(), counts[1:].ravel())

        self.note("p", require_likely(probability))

    def test_a_poisson_source_does_not_remember_its_past(self) -> None:
        def probability(seed: int) -> float:
            counts = self._counts(seed)
            return _uncorrelated(counts[:, :-1].ravel(), counts[:, 1:].ravel())

        self.note("p", require_likely(probability))

    def _counts(self, seed: int) -> Counts:
        """Return spikes by cell and bin."""
        brain = self.open(poisson("noise", N_CELLS, RATE_HZ), self.cells("n"), seed=seed)
        heard = record(brain, range(N_CELLS))
        self.run(brain, DURATION_S * 1000)
        found = heard.spikes()
        edges = [np.arange(N_CELLS + 1) - 0.5, np.arange(0, DURATION_S * 1000 + BIN_MS, BIN_MS)]
        counts: Counts = np.histogram2d(found.neurons, found.times_ms, edges)[0]
        return counts


def _uncorrelated(one: Counts, two: Counts) -> float:
    """Return the p-value of a correlation under independence."""
    return of_normal(float(np.corrcoef(one, two)[0, 1]) * len(one) ** 0.5)
