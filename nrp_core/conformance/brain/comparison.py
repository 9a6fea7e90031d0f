"""Cross and speed: against every other installed brain, and against wall-clock time."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.backends import brains
from nrp_core.clock import milliseconds
from nrp_core.conformance.brain.kit import EXACT_MS, BrainKit, record
from nrp_core.conformance.brain.parts import network
from nrp_core.conformance.guard import undeclared
from nrp_core.errors import BackendError

SEEDS = range(1, 7)
DURATION_MS = 400.0


class CrossTests(BrainKit):
    """Every brain gets the same network and noise, so differences come from the brain itself."""

    level = "cross"

    def test_rates_agree_with_those_of_every_other_installed_brain(self) -> None:
        """The rates agree within the spread of seeds, and one step of each grid per interval."""
        mine = self._spike_counts(self.backend, self.chosen)
        others = self._others()
        if not others:
            undeclared("another installed brain that has these cells")
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
                heard = record(brain, range(9))
                brain.run_until(round(DURATION_MS * 1e6))
                counts.append(np.bincount(heard.spikes().neurons, minlength=9))
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
