"""A recorded brain as a brain backend: it fires as recorded, for any input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.network.data import Network, Population
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.experiment.making.prepare import Plan, Side
from nrp_core.recording.layout import spikes_topic
from nrp_core.recording.reading.playback import Playback
from nrp_core.recording.reading.recording import Recording
from nrp_core.simulation import Determinism


class RecordedBrainBackend(BrainBackend):
    """Opens the brain of a recording.

    Args:
        recording: the recording.
        capabilities: the capabilities of the recorded brain.
    """

    def __init__(self, recording: Recording, capabilities: BrainCapabilities) -> None:
        self._recording = recording
        self._capabilities = replace(
            capabilities, determinism=Determinism.BITWISE, state_variables=frozenset(), snapshot=False,
            releases_gil=False,
        )  # fmt: skip

    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        return self._capabilities

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        return RecordedBrain(self._recording, network, seed, self._capabilities)


class RecordedBrain(Brain):
    """A network in which every neuron fires as recorded, for any input."""

    def __init__(
        self, recording: Recording, network: Network, seed: int, capabilities: BrainCapabilities
    ) -> None:
        super().__init__(network, seed=seed, capabilities=capabilities, identity="recorded")
        self._playback = Playback(recording, {spikes_topic(label) for label in network.populations})
        self._until_ns = 0
        self._playback.until(0)

    def _emits(self, population: Population) -> bool:
        return True  # the spikes of its sources were recorded, too

    def _do_run_until(self, t_ns: int) -> None:
        self._until_ns = t_ns

    def _do_take_spikes(self) -> Spikes:
        messages = [one.message for one in self._playback.until(self._until_ns)]
        return Spikes.merged([
            Spikes(one.ids.astype(np.int64) + self.network.offsets[one.population], one.times_ms)
            for one in messages
        ])  # fmt: skip

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None: ...

    def _do_inject(self, events: SynapticEvents) -> None: ...

    def _do_set_current(self, currents_na: FloatArray) -> None: ...

    def _do_reset(self, seed: int) -> None:
        self._until_ns = 0
        self._playback.reset()
        self._playback.until(0)

    def _reset_state(self) -> None:
        """Do nothing: what it fires from then on is recorded, too."""

    def _do_close(self) -> None: ...


def with_recorded_brain(plan: Plan, recording: Recording) -> Plan:
    """Return a plan with a recorded brain."""
    backend = RecordedBrainBackend(recording, plan.brain.capabilities)
    return replace(plan, brain=Side(backend, BrainOptions(), backend.capabilities(BrainOptions())))
