"""Devices show what they have, and say what they have not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nrp_core.dsl import kinds
from nrp_core.dsl.binding import Binding
from nrp_core.dsl.devices import Device
from nrp_core.dsl.kinds import KINDS, DeviceKind
from nrp_core.dsl.mocks import MockBrain, MockWorld
from nrp_core.dsl.selection import Selection

MS = 1_000_000


def opened(kind: DeviceKind, brain: MockBrain | None = None, neurons: Any = (0, 2), **options: Any) -> Device:
    binding = Binding("drive", brain or MockBrain({"cells": 4}), MockWorld())
    selection = Selection(np.array(neurons), "cells")
    return kind.open(binding, selection, options, parameter="wheel", name="drive/wheel")


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_every_kind_opens_on_its_own_defaults_and_shows_its_attributes(kind: DeviceKind) -> None:
    device = opened(kind)
    assert {name: getattr(device, name) for name in device.attributes()}.keys() > {"active"}
    sources = ("poisson", "fixed_frequency", "dc_source", "ac_source", "nc_source")
    assert kind.drives is (kind.name in sources)


@pytest.mark.parametrize(
    ("kind", "attribute"),
    [(kinds.poisson, "rate"), (kinds.fixed_frequency, "rate"), (kinds.dc_source, "amplitude")],
)
def test_what_drives_neurons_is_set_and_read_by_the_same_attribute(kind: DeviceKind, attribute: str) -> None:
    device = opened(kind)
    setattr(device, attribute, 2.5)
    assert getattr(device, attribute) == 2.5
    assert getattr(device.port, attribute) == 2.5


def test_one_value_for_each_neuron_is_taken() -> None:
    device = opened(kinds.poisson)
    device.rate = [1.0, 2.0]
    assert device.rate.tolist() == [1.0, 2.0]


@pytest.mark.parametrize("rate", [-1.0, float("nan"), float("inf"), [1, 2, 3], "fast", None, {}])
def test_a_rate_that_cannot_be_is_refused_by_the_name_of_the_parameter(rate: object) -> None:
    device = opened(kinds.poisson)
    with pytest.raises(ValueError, match="wheel"):
        device.rate = rate
    assert device.rate == 0.0


def test_what_is_only_read_cannot_be_set() -> None:
    with pytest.raises(AttributeError, match=r"wheel\.voltage can only be read"):
        opened(kinds.leaky_integrator_alpha).voltage = 1.0


def test_a_misspelt_attribute_is_neither_read_nor_set() -> None:
    device = opened(kinds.poisson)
    with pytest.raises(AttributeError, match=r"wheel is a SpikeGenerator .* did you mean 'rate'"):
        _ = device.rat
    with pytest.raises(AttributeError, match="did you mean 'rate'"):
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
