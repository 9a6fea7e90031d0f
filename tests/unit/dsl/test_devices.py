"""Devices show what they have, and say what they have not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.dsl import device_kinds as kinds
from nrp_core.dsl.device_kinds import KINDS, DeviceKind
from nrp_core.dsl.devices import Device
from nrp_core.dsl.parameters import Binding
from nrp_core.dsl.selection import Selection
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.network.pynn import builder

MS = 1_000_000


def opened(kind: DeviceKind, brain: MockBrain | None = None, neurons: Any = (0, 2), **options: Any) -> Device:
    binding = Binding("drive", brain or MockBrain({"cells": 4}), MockWorld())
    selection = Selection(np.array(neurons), "cells")
    return kind.open(binding, selection, options, parameter="wheel", name="drive/wheel")


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_every_kind_opens_on_its_own_defaults_and_shows_its_attributes(kind: DeviceKind) -> None:
    device = opened(kind)
    assert {name: getattr(device, name) for name in device.attributes()}.keys() >= {"active"}
    sources = ("poisson", "fixed_frequency", "dc_source", "ac_source", "nc_source", "injector")
    assert kind.drives is (kind.name in sources)


@pytest.mark.parametrize(
    ("kind", "attribute"),
    [(kinds.poisson, "rate"), (kinds.fixed_frequency, "rate"), (kinds.dc_source, "amplitude")],
)
def test_the_input_of_a_device_is_set_and_read_by_the_same_attribute(
    kind: DeviceKind, attribute: str
) -> None:
    device = opened(kind)
    setattr(device, attribute, 2.5)
    assert getattr(device, attribute) == 2.5
    assert getattr(device.port, attribute) == 2.5


def test_one_value_for_each_neuron_is_taken() -> None:
    device = opened(kinds.poisson)
    device.rate = [1.0, 2.0]
    assert device.rate.tolist() == [1.0, 2.0]


@pytest.mark.parametrize("rate", [-1.0, float("nan"), float("inf"), [1, 2, 3], "fast", None, {}])
def test_a_rate_that_cannot_be_is_refused_by_the_name_of_the_parameter(rate: object, golden: Golden) -> None:
    device = opened(kinds.poisson)
    with golden.raises(ValueError):
        device.rate = rate
    assert device.rate == 0.0


def test_a_read_only_attribute_cannot_be_set(golden: Golden) -> None:
    with golden.raises(AttributeError):
        opened(kinds.leaky_integrator_alpha).voltage = 1.0


def test_a_misspelt_attribute_is_neither_read_nor_set(golden: Golden) -> None:
    device = opened(kinds.poisson)
    with golden.raises(AttributeError, match="'wheel'.*'rat'.*'rate'"):
        _ = device.rat
    with golden.raises(AttributeError, match="'rate'"):
        device.rats = 5.0


def test_an_inactive_source_keeps_its_setting_and_a_released_one_is_gone() -> None:
    brain = MockBrain({"cells": 4})
    device = opened(kinds.dc_source, brain)
    device.amplitude = 1.0
    device.active = False
    assert device.amplitude == 1.0
    assert not device.port.active
    device.release()
    assert brain.devices == ()


def test_a_recorder_gives_the_spikes_since_the_function_last_ran() -> None:
    brain = MockBrain({"cells": 4})
    recorder = opened(kinds.spike_recorder, brain)
    brain.fire([0, 1, 2], [1.0, 2.0, 3.0])
    brain.run_until(20 * MS)
    recorder.refresh(brain.now_ns)
    assert recorder.times.tolist() == [[0, 1.0], [2, 3.0]]
    assert recorder.value_text() == "times = 2 rows of neuron and ms"
    assert recorder.spiked
    brain.run_until(40 * MS)
    recorder.refresh(brain.now_ns)
    assert not recorder.spiked
    assert recorder.times.shape == (0, 2)
    brain.fire([2], [41.0])
    brain.run_until(60 * MS)
    brain.run_until(80 * MS)
    recorder.refresh(brain.now_ns)
    assert recorder.times.tolist() == [[2, 41.0]]


def test_a_recorder_can_count_neurons_within_its_selection() -> None:
    brain = MockBrain({"cells": 4})
    recorder = opened(kinds.spike_recorder, brain, neurons=(3, 1), use_ids=False)
    brain.fire([1, 3], [1.0, 2.0])
    brain.run_until(20 * MS)
    recorder.refresh(brain.now_ns)
    assert recorder.times.tolist() == [[1, 1.0], [0, 2.0]]
    assert (recorder.neurons.tolist(), recorder.neurons_count, recorder.population_name) == (
        [3, 1],
        2,
        "cells",
    )


def test_a_reset_recorder_has_no_spikes_and_starts_at_time_0() -> None:
    brain = MockBrain({"cells": 4})
    recorder = opened(kinds.spike_recorder, brain)
    brain.fire([0], [1.0])
    brain.run_until(20 * MS)
    recorder.refresh(brain.now_ns)
    brain.reset()
    recorder.reset()
    assert not recorder.spiked
    brain.fire([0], [2.0])
    brain.run_until(20 * MS)
    recorder.refresh(brain.now_ns)
    assert recorder.times.tolist() == [[0, 2.0]]


def test_an_injector_sends_spikes_to_places_among_its_neurons(golden: Golden) -> None:
    brain = MockBrain({"cells": 4})
    device = opened(kinds.injector, brain, neurons=(0, 2, 3), weight=0.5, delay=2.0)
    device.inject_spikes([1])
    device.inject_spikes(times_ms=7.0)
    events = [device.port.events(0.0, 5.0), device.port.events(5.0, 10.0)]
    assert [part.neurons.tolist() for part in events] == [[2], [0, 2, 3]]
    assert [part.times_ms.tolist() for part in events] == [[2.0], [9.0, 9.0, 9.0]]
    with golden.raises(ValueError, match=r"0\.\.2.*\[3\]"):
        device.inject_spikes(3)
    with golden.raises(ValueError, match="10"):
        device.inject_spikes(0, 4.0)


def test_a_voltage_recorder_shows_the_samples_since_the_function_last_ran() -> None:
    brain = MockBrain({"cells": 4})
    device = opened(kinds.voltage_recorder, brain, dt=2.0)
    brain.run_until(5 * MS)
    device.refresh(5 * MS)
    assert device.times.tolist() == [0.0, 2.0, 4.0]
    brain.values["v"][2] = -50.0
    brain.run_until(7 * MS)
    device.refresh(7 * MS)
    assert (device.times.tolist(), device.values.tolist()) == ([6.0], [[-65.0, -50.0]])
    assert opened(kinds.conductance_recorder, brain, variable="gsyn_inh").values.shape == (0, 2)


def test_a_recorder_of_a_variable_of_equations_opens_on_a_mock() -> None:
    sim = builder()
    cell = sim.EquationCell(
        "dv/dt = -v/tau : mV\nda/dt = -a/tau : mV", threshold="v > tau*volt/second", reset="a += 1*mV",
        receptors={"excitatory": "v"}, parameters={"tau": "20 ms"},
    )  # fmt: skip
    sim.Population(3, cell(), label="cells")
    brain = MockBrain(sim.network())
    device = opened(kinds.voltage_recorder, brain, variable="a", dt=2.0)
    brain.values["a"][:] = [1.0, 2.0, 3.0]
    brain.run_until(2 * MS)
    device.refresh(2 * MS)
    assert device.values.tolist() == [[0.0, 0.0], [1.0, 3.0]]


TIRING = {"type": "TsodyksMarkram", "U": 0.5, "tau_rec": 100.0, "tau_facil": 0.0}


def test_synapses_of_a_source_tire_each_for_itself() -> None:
    device = opened(kinds.fixed_frequency, weight=2.0, synapse_type=TIRING, rate=100.0)
    events = device.port.events(0.0, 20.0)
    recovering = 0.5 * np.exp(-10.0 / 100.0)  # of what the first spike used
    expected = [2.0 * 0.5, 2.0 * 0.5, *[2.0 * 0.5 * (1 - recovering)] * 2]
    assert events.weights == pytest.approx(expected)
    saved = device.port.save()
    later = device.port.events(20.0, 60.0).weights
    device.port.restore(saved)
    assert (device.port.events(20.0, 60.0).weights == later).all()


def test_synapses_of_an_integrator_tire() -> None:
    voltages = []
    for synapse_type in (None, TIRING, TIRING | {"U": 1.0, "tau_rec": 1e-3}):
        brain = MockBrain({"cells": 4})
        device = opened(kinds.leaky_integrator_exp, brain, synapse_type=synapse_type)
        brain.fire([0, 0], [2.0, 8.0])
        brain.run_until(10 * MS)
        voltages.append(device.voltage)
    fresh, tired, always_fresh = voltages
    assert 0 < tired < 0.5 * fresh
    assert always_fresh == pytest.approx(fresh, rel=1e-2)


@pytest.mark.parametrize(
    ("synapse_type", "message"),
    [
        ({"type": "STP"}, "TsodyksMarkram, not 'STP'"),
        ({"type": "TsodyksMarkram", "U": 0.5}, "needs 'tau_rec'"),
        ({**TIRING, "tau_fac": 1.0}, "has no 'tau_fac'"),
        ({**TIRING, "U": 1.5}, r"1\.5"),
    ],
)
def test_a_synapse_type_that_cannot_be_is_refused(
    synapse_type: dict[str, Any], message: str, golden: Golden
) -> None:
    with golden.raises(ValueError, match=message):
        opened(kinds.poisson, synapse_type=synapse_type)


def test_a_connector_gives_weight_and_delay_unless_they_are_given_themselves() -> None:
    connector = {"mode": "AllToAll", "weight": 3.0, "delay": 2.0}
    events = opened(kinds.fixed_frequency, rate=100.0, delay=4.0, connector=connector).port.events(0.0, 10.0)
    assert (events.weights.tolist(), events.times_ms.tolist()) == ([3.0, 3.0], [14.0, 14.0])


def test_a_fixed_connector_sets_the_number_of_generators_and_of_neurons(
    golden: Golden,
) -> None:
    fixed = {"mode": "Fixed", "n": 3}
    assert len(opened(kinds.fixed_frequency, rate=100.0, connector=fixed).port.events(0.0, 10.0)) == 6
    device = opened(kinds.leaky_integrator_alpha, neurons=(0, 1, 2, 3), connector=fixed)
    assert len(set(device.port.neurons.tolist())) == 3
    for wrong in ({"mode": "Some"}, {"mode": "Fixed", "n": 0}):
        with golden.raises(ValueError):
            opened(kinds.poisson, connector=wrong)
