"""Devices of users' own."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from golden import Golden

import nrp_core.dsl as nrp
from nrp_core.brain.devices.sinks import PopulationRate
from nrp_core.brain.devices.sources import DCSource, PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.dsl.selection import Selection
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import TransferFunctionError


class Probe(nrp.CustomDevice):
    """Drives neurons and hears what comes of it."""

    def apply(self, neurons: Any, brain: Brain, current: float = 0.1, tau: float = 20.0) -> None:
        chosen = neurons if isinstance(neurons, list) else [neurons]
        for i, one in enumerate(chosen):
            brain.add_source(DCSource(amplitude=current), one.ids, name=f"probe {i}")
        self._heard = brain.add_sink(PopulationRate(tau_fall=tau), chosen[0].ids, name="probe")

    @property
    def level(self) -> float:
        return float(self._heard.rate)  # type: ignore[attr-defined]


def probed(neurons: Any = None, device: Any = None, **settings: Any) -> nrp.TransferFunction:
    @nrp.MapSpikeSink(
        "probe", nrp.brain.cells[1:3] if neurons is None else neurons, device or Probe(), **settings
    )
    @nrp.Neuron2Robot()
    def f(t: float, probe: Any) -> None: ...

    return f


def bound(function: nrp.TransferFunction, brain: MockBrain | None = None) -> nrp.TransferFunction:
    return function.bind(brain or MockBrain({"cells": 4}), MockWorld())


def test_it_works_on_the_neurons_that_were_chosen_with_its_own_settings() -> None:
    brain = MockBrain({"cells": 4})
    function = bound(probed(current=0.7), brain)
    assert [port.neurons.tolist() for port in brain.devices] == [[1, 2], [1, 2]]
    assert brain.devices[0].amplitude == 0.7  # type: ignore[union-attr]
    assert function.probe.level == 0.0


def test_functions_with_equal_devices_are_described_alike() -> None:
    one, other = str(probed()), str(probed())
    assert one == other
    assert "Probe() on brain.cells" in one


def test_a_removed_function_takes_its_devices_with_it() -> None:
    brain = MockBrain({"cells": 4})
    other = brain.add_source(PoissonSource(), [0], name="other")
    function = bound(probed(), brain)
    assert len(brain.devices) == 3
    function.unbind()
    assert brain.devices == (other,)


def test_it_falls_silent_with_its_function() -> None:
    function = bound(probed())
    function.active = False
    assert not any(port.active for port in function.probe._ports)


def test_one_object_serves_several_parameters_each_with_a_copy() -> None:
    device, brain = Probe(), MockBrain({"cells": 4})
    first, second = bound(probed(device=device), brain), bound(probed(device=device), brain)
    assert first.probe is not second.probe
    assert len(brain.devices) == 4


def test_it_gets_all_selections_of_a_list() -> None:
    brain = MockBrain({"cells": 4})
    bound(probed(nrp.map_neurons(3, lambda i: nrp.brain.cells[i])), brain)
    assert len(brain.devices) == 4


def test_a_setting_that_it_does_not_take_is_reported_where_it_is_given() -> None:
    function = probed(colour="red")
    with pytest.raises(TransferFunctionError, match=r"test_custom.py.*'probe'.*colour"):
        bound(function)


def test_a_device_that_fails_leaves_nothing_behind(golden: Golden) -> None:
    class Half(nrp.CustomDevice):
        def apply(self, neurons: Selection | list[Selection], brain: Brain, **settings: Any) -> None:
            brain.add_source(DCSource(), [0], name="half")
            raise ValueError("the other half is missing")

    brain = MockBrain({"cells": 4})
    with golden.raises(TransferFunctionError):
        bound(probed(device=Half()), brain)
    assert brain.devices == ()


def test_a_device_that_a_functions_file_defines_can_be_saved_with_its_state() -> None:
    class Counting(Probe):  # as in such a file, which cannot be imported
        looks = 0

        @property
        def level(self) -> float:
            self.looks += 1
            return super().level

        def save(self) -> int:
            return self.looks

        def restore(self, saved: int) -> None:
            self.looks = saved

    function = bound(probed(device=Counting()))
    assert (function.probe.level, function.probe.looks) == (0.0, 1)
    saved = pickle.dumps(function.save())
    assert (function.probe.level, function.probe.looks) == (0.0, 2)
    function.restore(pickle.loads(saved))
    assert function.probe.looks == 1
