"""Capability: declared features work, and others are refused rather than silently left out."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from pydantic import ValidationError

from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.brain.network.data import Population
from nrp_core.brain.network.synapses import LAWS, STDP
from nrp_core.clock import milliseconds
from nrp_core.conformance.brain.kit import BrainKit, record, train
from nrp_core.conformance.brain.parts import cells, connect, spikes
from nrp_core.conformance.brain.samples import SAMPLES
from nrp_core.conformance.guard import undeclared
from nrp_core.errors import CapabilityError, TimestepError
from nrp_core.simulation import Determinism

SYNAPSES: dict[str, dict[str, Any]] = {name: law.defaults for name, law in LAWS.items()}
SYNAPSES[STDP]["w_max"] = 9.0  # larger than the weights of all samples
RULE = LAWS[STDP].first_parts


class CapabilityTests(BrainKit):
    """The declaration of capabilities is correct, in both directions."""

    level = "capability"

    def test_capabilities_are_the_same_at_every_call(self) -> None:
        declared = self.capabilities
        assert self.backend.capabilities(self.chosen) == declared
        assert self.open(self.cells("n")).capabilities == declared
        assert declared.extensions <= declared.cells | declared.synapses
        assert declared.resolution_ns is None or declared.resolution_ns > 0

    def test_every_declared_cell_can_be_opened_and_run(self) -> None:
        for name in sorted(self.capabilities.cells & SAMPLES.keys()):
            with self.open(cells(SAMPLES[name], "n", 2)) as brain:
                self.run(brain, 3)

    def test_undeclared_cells_are_refused(self) -> None:
        for name in sorted({*SAMPLES, "NoSuchCell"} - self.capabilities.cells):
            unknown = replace(cells(self.sample, "n"), cell_type="NoSuchCell")
            with pytest.raises(CapabilityError):
                self.open(cells(SAMPLES[name], "n") if name in SAMPLES else unknown)

    def test_unknown_source_cells_are_refused(self) -> None:
        with pytest.raises(CapabilityError):
            self.open(Population("s", 1, "SpikeSourceNobodyKnows", {}))

    @pytest.mark.parametrize("kind", sorted(SYNAPSES))
    def test_a_synapse_type_works_if_declared_and_is_refused_if_not(self, kind: str) -> None:
        rule = LAWS[kind].first_parts or None
        synapse = connect("s", "n", self.sample.strong, 1.0, kind=kind, rule=rule, **SYNAPSES[kind])
        parts = spikes("s", [2.0, 30.0]), self.cells("n"), synapse
        if kind in self.capabilities.synapses:
            self.run(self.open(*parts), 40)
        else:
            with pytest.raises(CapabilityError):
                self.open(*parts)

    def test_an_unknown_synapse_type_is_refused(self) -> None:
        with pytest.raises(CapabilityError):
            self.open(spikes("s", [2.0]), self.cells("n"), connect("s", "n", 1.0, 1.0, kind="nobody_knows"))

    def test_declared_state_variables_can_be_read(self) -> None:
        for name in sorted(self.capabilities.cells & SAMPLES.keys()):
            brain = self.open(cells(SAMPLES[name], "n", 3))
            self.run(brain, 2)
            readable = 0
            for variable in sorted(self.capabilities.state_variables):
                try:
                    values = brain.read_state(variable, [0, 2])
                except CapabilityError:
                    continue  # a variable that only other cells have
                readable += 1
                assert values.shape == (2,)
                assert all(map(math.isfinite, values))
            assert readable or not self.capabilities.state_variables, name
            brain.close()

    def test_undeclared_state_variables_are_refused(self) -> None:
        brain = self.open(self.cells("n"))
        for variable in ({"v", "gsyn_exc"} - self.capabilities.state_variables) | {"no_such_variable"}:
            with pytest.raises(CapabilityError):
                brain.read_state(variable, [0])

    def test_state_is_returned_in_the_requested_order(self) -> None:
        if "v" not in self.capabilities.state_variables:
            undeclared("state variable v")
        brain = self.open(self.cells("a", 3, i_offset=[0.0, 0.1, 0.2]), spikes("s", [1.0]), self.cells("b"))
        self.run(brain, 6)
        first, *_, last = brain.read_state("v", [0, 1, 2])
        assert first < last
        assert list(brain.read_state("v", [2, 4, 0])) == [last, first, first]

    def test_undeclared_snapshots_are_refused(self) -> None:
        brain = self.open(*self.busy())
        self.run(brain, 5)
        if self.capabilities.snapshot:
            assert brain.snapshot().t_ns == brain.now_ns
        else:
            with pytest.raises(CapabilityError):
                brain.snapshot()

    def test_a_brain_with_a_grid_stops_only_on_it_and_one_without_stops_anywhere(self) -> None:
        brain = self.open(self.cells("n"))
        step_ns = self.capabilities.resolution_ns
        if step_ns is None:
            brain.run_until(1_234_567)
            assert brain.now_ns == 1_234_567
        else:
            with pytest.raises(TimestepError):
                brain.run_until(step_ns + step_ns // 2 + 1)

    def test_the_spikes_of_a_brain_with_a_grid_lie_on_it(self) -> None:
        step_ns = self.capabilities.resolution_ns
        if step_ns is None:
            undeclared("a resolution")
        brain = self.open(
            self.cells("n", 5, i_offset=[self.sample.current_na * f for f in (1, 1.1, 2, 3, 4)])
        )
        heard = record(brain)
        self.run(brain, 50)
        steps = heard.spikes().times_ms / milliseconds(step_ns)
        assert len(steps), "no cell fired"
        assert steps == pytest.approx(steps.round(), abs=1e-6)

    def test_runs_repeat_as_declared(self) -> None:
        if self.capabilities.determinism is Determinism.STATISTICAL:
            undeclared("repeatable runs")
        trains = []
        for _ in range(2):
            with self.open(*self.busy()) as brain:
                heard = record(brain)
                brain.add_source(PoissonSource(rate=200.0, weight=self.sample.strong), [5, 6], name="noise")
                self.run(brain, 60)
                trains.append(train(heard))
        assert trains[0] == trains[1]

    def test_unknown_options_are_refused(self) -> None:
        with pytest.raises(ValidationError):
            self.backend.options.model_validate({**self.options, "no_such_option": 1})
