"""Monitors show what their device reads, when their function says so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from golden import Golden

import nrp_core.dsl as nrp
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import TransferFunctionError

MS = 1_000_000


def monitor(neurons: Any, kind: Any) -> nrp.TransferFunction:
    @nrp.NeuronMonitor(neurons, kind)
    def watch(t):  # type: ignore[no-untyped-def]
        return True if t < 0.05 else None

    return watch


def run_once(function: nrp.TransferFunction, topic: str) -> list[Any]:
    """Let the first and the last of 3 cells fire, and return what is shown of it after 20 ms."""
    brain, world = MockBrain({"cells": 3}), MockWorld()
    function.bind(brain, world)
    brain.fire(np.array([0, 2]), np.array([5.0, 7.0]))
    brain.run_until(20 * MS)
    world.run_until(20 * MS)
    function.run(20 * MS)
    return world.sent(topic)


def test_spikes_are_shown_with_their_places_and_times() -> None:
    (event,) = run_once(monitor(nrp.brain.cells[1:], nrp.spike_recorder), "/monitor/spike_recorder")
    assert (event.simulation_time, event.neuron_count, event.monitor_name) == (0.02, 2, "watch")
    assert event.population_label == "cells"
    assert [(spike.neuron, spike.time) for spike in event.spikes] == [(1, 7.0)]


def test_each_selection_of_a_group_has_a_message_of_its_own() -> None:
    neurons = nrp.map_neurons(range(3), lambda i: nrp.brain.cells[i])
    events = run_once(monitor(neurons, nrp.spike_recorder), "/monitor/spike_recorder")
    assert [len(event.spikes) for event in events] == [1, 0, 1]


@pytest.mark.parametrize("kind", ["leaky_integrator_alpha", "leaky_integrator_exp", "population_rate"])
def test_a_rate_or_voltage_is_shown_as_the_device_reads_it(kind: str) -> None:
    function = monitor(nrp.brain.cells, getattr(nrp, kind))
    (shown,) = run_once(function, f"/monitor/{kind}")
    device: Any = function.adapters["device"]
    assert shown.rate == (device.rate if kind == "population_rate" else device.voltage) > 0


def test_nothing_is_shown_when_the_function_returns_none() -> None:
    function = monitor(nrp.brain.cells, nrp.population_rate)
    world = MockWorld()
    function.bind(MockBrain({"cells": 3}), world)
    function.run(60 * MS)
    assert world.sent("/monitor/population_rate") == []


def test_a_kind_without_a_monitor_is_refused(golden: Golden) -> None:
    with golden.raises(TransferFunctionError):
        nrp.NeuronMonitor(nrp.brain.cells, nrp.poisson)
