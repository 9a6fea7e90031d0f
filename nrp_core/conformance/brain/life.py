"""Contract: calls in a wrong order are refused with a clear error."""

from __future__ import annotations

import pytest

from nrp_core.brain.backend import BRAIN_INTERFACE_VERSION
from nrp_core.brain.devices.sources import DCSource
from nrp_core.clock import NS_PER_MS
from nrp_core.conformance.brain.kit import BrainKit, record
from nrp_core.conformance.brain.samples import SAMPLES
from nrp_core.errors import LifecycleError


class LifeTests(BrainKit):
    """The life cycle of a brain, from opening to closing."""

    def test_a_fresh_brain_is_at_time_zero_with_its_seed(self) -> None:
        brain = self.open(self.cells("n", 3), seed=12)
        assert (brain.now_ns, brain.seed, brain.network.size) == (0, 12, 3)
        assert self.backend.interface_version == BRAIN_INTERFACE_VERSION

    def test_at_least_one_declared_cell_is_a_standard_one(self) -> None:
        """Nearly all tests need one of the standard cells."""
        declared = self.capabilities.cells
        assert declared & SAMPLES.keys(), f"declared: {sorted(declared)}; standard: {sorted(SAMPLES)}"

    def test_time_does_not_run_backwards(self) -> None:
        brain = self.open(self.cells("n"))
        self.run(brain, 10)
        with pytest.raises(LifecycleError):
            self.run(brain, 5)
        assert brain.now_ns == self.grid_ns(10)

    def test_running_to_the_current_time_does_nothing(self) -> None:
        brain = self.open(*self.busy())
        heard = record(brain)
        self.run(brain, 20)
        before = len(heard.spikes())
        self.run(brain, 20)
        assert len(heard.spikes()) == before

    def test_a_closed_brain_refuses_every_call_and_can_be_closed_again(self) -> None:
        brain = self.open(self.cells("n"))
        self.run(brain, 5)
        brain.close()
        brain.close()
        for attempt in (
            lambda: self.run(brain, 10),
            brain.reset,
            brain.snapshot,
            lambda: brain.add_source(DCSource(amplitude=1.0), [0], name="dc"),
        ):
            with pytest.raises(LifecycleError):
                attempt()

    def test_closing_one_brain_leaves_another_running(self) -> None:
        one, two = self.open(*self.busy()), self.open(*self.busy())
        heard = record(two)
        self.run(one, 10)
        one.close()
        self.run(two, 30)
        assert len(heard.spikes())

    def test_an_empty_window_and_a_network_without_synapses_are_valid(self) -> None:
        brain = self.open(self.cells("n", 1))
        heard = record(brain)
        for step in range(1, 6):
            brain.run_until(step * max(NS_PER_MS, self.capabilities.resolution_ns or 0))
        assert len(heard.spikes()) == 0
