"""A script of Brian2 in the loop: the same spikes as in Brian2 alone, devices, and what is refused."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_core.brain import Brain, DCSource, SpikeInjector, SpikeRecorder
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.experiment import network_from

from nrp_brain_brian2.brain import seed_of

Script = Callable[[str], Path]
Opened = Callable[..., Brain]
RUN = "run(40*ms)\n"
IN_A_POOL = """
from multiprocessing import get_context

def one(_):
    run(1*ms)

with get_context("fork").Pool(1) as pool:
    pool.map(one, [0])
"""


def spikes_in_the_loop(brain: Brain, step_ms: int = 2, until_ms: int = 40) -> Any:
    recorder = brain.add_sink(SpikeRecorder(), np.arange(brain.network.size), name="spikes")
    for t_ms in range(step_ms, until_ms + 1, step_ms):
        brain.run_until(t_ms * NS_PER_MS)
    return recorder.spikes()


def test_spikes_are_those_of_brian2_alone(script: Script, opened: Opened) -> None:
    path = script(RUN)
    with opened(path) as brain:
        found = spikes_in_the_loop(brain)
    import brian2

    brian2.prefs.codegen.target = "numpy"
    brian2.start_scope()
    brian2.seed(seed_of(1))
    alone: dict[str, Any] = {}
    exec(path.read_text().replace(RUN, "monitor = SpikeMonitor(cells)\n" + RUN), alone)
    monitor = alone["monitor"]
    assert len(found) > 20
    at = np.argsort(found.times_ms + 1e-4 * found.neurons)
    expected = np.argsort(np.array(monitor.t_) * 1e3 + 1e-4 * np.array(monitor.i))
    assert found.neurons[at].tolist() == np.array(monitor.i)[expected].tolist()
    np.testing.assert_allclose(found.times_ms[at], 1e3 * np.array(monitor.t_)[expected] + 0.1, atol=1e-9)


def test_groups_are_populations_and_subgroups_are_views(script: Script) -> None:
    end = "first.run_regularly('v += 0*mV', dt=1*ms)\n"  # it makes the subgroup an object of the network
    network = network_from(script(end + RUN), simulator="brian2", populations={"last": [5]})
    assert {label: one.size for label, one in network.populations.items()} == {"cells": 6}
    assert network.neurons("first").tolist() == [0, 1]
    assert network.neurons("last").tolist() == [5]


def test_an_explicit_network_inside_a_function_is_stepped(script: Script, opened: Opened) -> None:
    end = "def main():\n    own = build()\n    net = Network(own)\n    net.run(1*second)\nmain()\n"
    with opened(script(end)) as brain:
        assert list(brain.network.populations) == ["own"]
        assert len(spikes_in_the_loop(brain)) > 10


def test_the_clocks_of_monitors_and_operations_do_not_limit_the_steps(script: Script, opened: Opened) -> None:
    end = "watch = StateMonitor(cells, 'v', True, dt=0.7*ms)\nnote = NetworkOperation(lambda: 0, dt=0.3*ms)\n"
    with opened(script(end + RUN)) as brain:
        assert brain.capabilities.resolution_ns == 100_000


def test_a_reset_repeats_the_run(script: Script, opened: Opened) -> None:
    with opened(script(RUN)) as brain:
        before = spikes_in_the_loop(brain, 10)
        brain.reset()
        after = spikes_in_the_loop(brain, 5)
        assert brain._groups[0][0].name == "neurongroup"  # type: ignore[attr-defined]  # Brian2 orders by name
    assert before.times_ms.tolist() == after.times_ms.tolist()
    assert before.neurons.tolist() == after.neurons.tolist()


def test_a_current_moves_the_voltage_as_the_equation_says(script: Script, opened: Opened) -> None:
    with opened(script("cells.v = 0*mV\n" + RUN.replace("run", "kicks.active = False; run"))) as brain:
        brain.add_source(DCSource(amplitude=-1.0), [3], name="current")
        brain.run_until(5 * NS_PER_MS)
        last = brain.read_state("v", [2, 3])
    expected = np.array([20.0, 10.0]) * (1 - np.exp(-0.5))
    np.testing.assert_allclose(last, expected, rtol=1e-6)


def test_spikes_of_a_device_add_their_weight_to_the_voltage(script: Script, opened: Opened) -> None:
    end = "cells.v = 0*mV\nkicks.active = False\ntau = 1e9*ms\n" + RUN
    with opened(script(end)) as brain:
        source = brain.add_source(SpikeInjector(weight=3.0, delay=0.1), [4], name="spikes")
        assert hasattr(source, "inject_spikes")
        source.inject_spikes()
        brain.run_until(2 * NS_PER_MS)
        np.testing.assert_allclose(brain.read_state("v", [4, 5]), [3.0, 0.0], atol=1e-4)


@pytest.mark.parametrize(
    ("end", "kind", "message"),
    [
        ("set_device('cpp_standalone')\n" + RUN, CapabilityError, "standalone"),
        ("\n", NetworkError, "ends without"),
        (IN_A_POOL, CapabilityError, "another process"),
        ("cells.w = 3\n" + RUN, NetworkError, "AttributeError"),
    ],
)
def test_a_script_that_cannot_be_stepped_is_refused(
    script: Script, golden: Any, end: str, kind: type[Exception], message: str
) -> None:
    with golden.raises(kind, match=message):
        network_from(script(end), simulator="brian2")


def test_a_device_without_a_variable_is_refused(script: Script, opened: Opened, golden: Any) -> None:
    with opened(script(RUN), inputs={"current": "J"}) as brain:
        brain.add_source(DCSource(amplitude=1.0), [0], name="current")
        with golden.raises(CapabilityError, match="'cells'"):
            brain.run_until(NS_PER_MS)
