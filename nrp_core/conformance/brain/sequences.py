"""Random sequences of calls on a brain."""

from __future__ import annotations

from functools import partial
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import rule

from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource, PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS
from nrp_core.conformance.brain.kit import BrainKit, record, train
from nrp_core.conformance.brain.parts import network
from nrp_core.conformance.sequences import SequenceMachine, check_sequences


class SequenceTests(BrainKit):
    """Calls in random order."""

    level = "sequences"

    def test_any_sequence_of_calls_has_one_meaning(self) -> None:
        self.require_repeatable()
        check_sequences(partial(_BrainMachine, self), examples=20, length=15)


class _BrainMachine(SequenceMachine):
    """Sets devices while a brain runs, is reset and is restored."""

    def __init__(self, kit: BrainKit) -> None:
        self._kit = kit
        step_ns = kit.capabilities.resolution_ns or NS_PER_MS // 7
        super().__init__(can_restore=kit.capabilities.snapshot, step_ns=step_ns * -(-NS_PER_MS // step_ns))

    def fresh(self) -> Brain:
        kit, sample = self._kit, self._kit.sample
        brain = kit.backend.open(network(*kit.busy()), seed=3, options=kit.chosen)
        brain.add_source(PoissonSource(rate=80.0, weight=sample.strong), [5, 6], name="noise")
        brain.add_source(FixedFrequencySource(rate=30.0, weight=sample.strong), [7], name="beat")
        brain.add_source(DCSource(), [0, 8], name="dc")
        record(brain)
        return brain

    def apply(self, simulation: Brain, name: str, value: Any) -> None:
        device, _, setting = name.partition(".")
        port: Any = next(port for port in simulation.devices if port.name == device)
        setattr(port, setting, value)

    def seen(self, simulation: Brain) -> object:
        return train(simulation.devices[-1])  # type: ignore[arg-type]  # the recorder came last

    @rule(rate=st.sampled_from([0.0, 50.0, 400.0]))
    def set_noise(self, rate: float) -> None:
        self.do("noise.rate", rate)

    @rule(rate=st.sampled_from([0.0, 30.0, 90.0]))
    def set_beat(self, rate: float) -> None:
        self.do("beat.rate", rate)

    @rule(share=st.sampled_from([0.0, 0.5, 2.0]))
    def set_current(self, share: float) -> None:
        self.do("dc.amplitude", share * self._kit.sample.current_na)

    @rule(name=st.sampled_from(["noise", "beat", "dc"]), active=st.booleans())
    def switch(self, name: str, active: bool) -> None:
        self.do(f"{name}.active", active)
