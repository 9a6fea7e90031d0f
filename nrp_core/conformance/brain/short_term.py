"""Capability: each depressing synapse has its own state of release."""

from __future__ import annotations

from nrp_core.brain.devices.sinks import SpikeRecorderPort
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.synapses import TSODYKS_MARKRAM
from nrp_core.conformance.brain.kit import BrainKit, record, times, train
from nrp_core.conformance.brain.parts import connect, spikes
from nrp_core.conformance.guard import undeclared

USE = 0.98
"""The share that the first spike releases; with the strong synapse it makes a cell fire."""


class ShortTermTests(BrainKit):
    """A first spike makes a cell fire; a second one soon after does not."""

    level = "capability"

    def test_each_synapse_depresses_by_its_own_constants(self) -> None:
        heard, brain = self._depressing([USE, 0.02, USE], [5000.0, 5000.0, 2.0])
        self.run(brain, 70)
        assert len(times(heard, 1)) == 1, "the first synapse is empty when the second spike comes"
        assert not times(heard, 2), "the second synapse hardly releases anything"
        assert len(times(heard, 3)) == 2, "the third synapse is full again when the second spike comes"

    def test_a_reset_restores_depressed_synapses(self) -> None:
        self.require_repeatable()
        heard, brain = self._depressing(USE, 5000.0)
        self.run(brain, 30)
        expected = train(heard)
        assert expected
        brain.reset()
        self.run(brain, 30)
        assert train(heard) == expected

    def test_a_snapshot_keeps_the_depression_of_synapses(self) -> None:
        self.require_snapshot()
        heard, brain = self._depressing(USE, 5000.0)
        self.run(brain, 30)
        snapshot = brain.snapshot()
        there, fresh = self._depressing(USE, 5000.0)
        for again, found in ((brain, heard), (fresh, there)):
            again.restore(snapshot)
            self.run(again, 70)
            assert not train(found, 30.0), "the synapses are still empty when the second spike comes"

    def _depressing(
        self, use: float | list[float], recovery_ms: float | list[float]
    ) -> tuple[SpikeRecorderPort, Brain]:
        """Open three cells that a source with two spikes makes fire, and record them."""
        if TSODYKS_MARKRAM not in self.capabilities.synapses:
            undeclared("tsodyks_markram synapses")
        plastic = connect(
            "s", "n", self.sample.strong / USE, 1.0, pairs=[(0, 0), (0, 1), (0, 2)],
            kind=TSODYKS_MARKRAM, U=use, tau_rec=recovery_ms, tau_facil=0.0,
        )  # fmt: skip
        brain = self.open(spikes("s", [4.0, 40.0]), self.cells("n", 3), plastic)
        return record(brain, [1, 2, 3]), brain
