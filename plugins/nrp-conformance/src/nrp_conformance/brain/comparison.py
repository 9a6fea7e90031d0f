"""Statistical, cross and speed: distributions, every other installed brain, and wall-clock time.

A statistical test fails only if two seeds agree. 16 000 events find a bias of the rate by 5 % with a
probability of 0.998.
"""

from __future__ import annotations

from collections.abc import Callable
from math import erfc, sqrt
from time import perf_counter

import numpy as np
import numpy.typing as npt

from nrp_conformance.base import skip_undeclared
from nrp_conformance.brain.kit import EXACT_MS, BrainKit, network, poisson, record
from nrp_core import brains
from nrp_core.brain import BrainBackend, BrainOptions
from nrp_core.clock import milliseconds
from nrp_core.errors import BackendError
from nrp_core.world import FloatArray

Counts = npt.NDArray[np.float64]

STATISTICAL_SEEDS = (11, 29)
UNLIKELY = 1e-3
RATE_HZ, N_CELLS, DURATION_S, BIN_MS = 100.0, 8, 20.0, 20.0

SEEDS = range(1, 7)
DURATION_MS = 400.0


def require_likely(probability: Callable[[int], float]) -> float:
    """Fail only if the result has a probability below one in a thousand for both of two fixed seeds.

    Args:
        probability: runs an experiment with a seed and returns the two-sided p-value of its result.

    Returns:
        The larger of the two.
    """
    largest = max(probability(seed) for seed in STATISTICAL_SEEDS)
    assert largest >= UNLIKELY, f"probability below 1 in 1000 for both seeds: p = {largest:.2g}"
    return largest


def normal_p_value(z: float) -> float:
    """Return the two-sided p-value of a standard normal deviate."""
    return erfc(abs(z) / sqrt(2))


def chi_square_p_value(x: float, freedom: int) -> float:
    """Return the two-sided p-value of a chi-square value (Wilson & Hilferty 1931, PNAS 17:684)."""
    spread = 2 / (9 * freedom)
    return normal_p_value(((x / freedom) ** (1 / 3) - (1 - spread)) / sqrt(spread))


class StatisticalTests(BrainKit):
    """Poisson sources: mean, variance, independence of each other and of the past."""

    level = "statistical"

    def test_a_poisson_source_has_the_given_rate(self) -> None:
        expected = RATE_HZ * DURATION_S * N_CELLS

        def probability(seed: int) -> float:
            return normal_p_value((self._counts(seed).sum() - expected) / expected**0.5)

        self.note("p", require_likely(probability))

    def test_the_counts_of_a_poisson_source_vary_as_much_as_their_mean(self) -> None:
        def probability(seed: int) -> float:
            counts = self._counts(seed)
            freedom = counts.size - 1
            return chi_square_p_value(freedom * counts.var(ddof=1) / counts.mean(), freedom)

        self.note("p", require_likely(probability))

    def test_poisson_sources_are_independent_of_each_other(self) -> None:
        def probability(seed: int) -> float:
            counts = self._counts(seed)
            return _independence_p_value(counts[:-1].ravel(), counts[1:].ravel())

        self.note("p", require_likely(probability))

    def test_a_poisson_source_does_not_remember_its_past(self) -> None:
        def probability(seed: int) -> float:
            counts = self._counts(seed)
            return _independence_p_value(counts[:, :-1].ravel(), counts[:, 1:].ravel())

        self.note("p", require_likely(probability))

    def _counts(self, seed: int) -> Counts:
        """Return spikes by cell and bin."""
        brain = self.open(poisson("noise", N_CELLS, RATE_HZ), self.cells("n"), seed=seed)
        recorded = record(brain, range(N_CELLS))
        self.run(brain, DURATION_S * 1000)
        found = recorded.spikes()
        edges = [np.arange(N_CELLS + 1) - 0.5, np.arange(0, DURATION_S * 1000 + BIN_MS, BIN_MS)]
        counts: Counts = np.histogram2d(found.neurons, found.times_ms, edges)[0]
        return counts


def _independence_p_value(one: Counts, two: Counts) -> float:
    """Return the p-value of a correlation under independence."""
    return normal_p_value(float(np.corrcoef(one, two)[0, 1]) * len(one) ** 0.5)


class BrainCrossTests(BrainKit):
    """Every brain gets the same network and noise, so differences come from the brain itself."""

    level = "cross"

    def test_rates_agree_with_those_of_every_other_installed_brain(self) -> None:
        """The rates agree within the spread of seeds, and one step of each grid per interval."""
        mine = self._spike_counts(self.backend, self.chosen)
        others = self._others()
        if not others:
            skip_undeclared("another installed brain that has these cells")
        for name, (other, options) in others.items():
            theirs = self._spike_counts(other, options)
            resolution_ns = other.capabilities(options).resolution_ns or 0
            step_ms = self.tolerance_ms + (milliseconds(resolution_ns) or EXACT_MS)
            spread = np.sqrt((mine.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / len(SEEDS))
            rates = np.maximum(mine.mean(axis=0), theirs.mean(axis=0))
            longer = rates * rates * step_ms / DURATION_MS  # n intervals, each longer by a step
            difference = np.abs(mine.mean(axis=0) - theirs.mean(axis=0))
            self.note(f"largest_rate_difference_to_{name}_hz", float(difference.max() * 1000 / DURATION_MS))
            assert (difference <= 4 * spread + longer + 1).all(), (name, difference, spread)

    def _others(self) -> dict[str, tuple[BrainBackend, BrainOptions]]:
        found = {}
        for name in brains().names():
            try:
                backend = brains().load(name)
            except BackendError:
                continue
            options = backend.options()
            if name != self.backend_name and self.sample.cell_type in backend.capabilities(options).cells:
                found[name] = backend, options
        return found

    def _spike_counts(self, backend: BrainBackend, options: BrainOptions) -> FloatArray:
        """Return the spikes of the simulated cells, by seed and cell."""
        counts = []
        for seed in SEEDS:
            with backend.open(network(*self.busy()), seed=seed, options=options) as brain:
                recorded = record(brain, range(9))
                brain.run_until(round(DURATION_MS * 1e6))
                counts.append(np.bincount(recorded.spikes().neurons, minlength=9))
        return np.array(counts, float)


class SpeedTests(BrainKit):
    """Only reported; this test cannot fail."""

    level = "speed"

    def test_the_speed(self) -> None:
        brain = self.open(*self.busy())
        self.run(brain, 20)
        started = perf_counter()
        for until in range(40, 1020, 20):
            self.run(brain, until)
        self.note("simulated_seconds_per_second", 0.98 / (perf_counter() - started))
