"""Functions that messages, spikes and voltages trigger, as on the SpiNNaker machines of the platform."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.experiment.running.run import Run

BRAIN = """
from hbp_nrp_cle.brainsim import simulator as sim
sim.setup(timestep=1.0)
left = sim.Population(1, sim.IF_curr_exp(tau_refrac=25.0), label="left")
right = sim.Population(1, sim.IF_curr_exp(tau_refrac=25.0), label="right")
for cells, times in ((left, [30.0, 110.0]), (right, [])):
    train = sim.Population(1, sim.SpikeSourceArray(spike_times=times))
    sim.Projection(train, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=10.0, delay=1.0))
"""
FUNCTIONS = """
# Imported Python Transfer Function
@nrp.MapSpikeSink("rec", nrp.brain.left, nrp.spike_recorder)
@nrp.MapVariable("seen", initial_value=[])
@nrp.Neuron2Robot(triggers="rec")
def live_monitor(t, rec, seen):
    seen.value.append((round(t, 3), len(rec.times)))

@nrp.MapSpikeSink("rec", nrp.brain.right, nrp.spike_recorder)
@nrp.Neuron2Robot(triggers=["rec"])
def quiet(t, rec):
    raise ValueError("no cell of 'right' ever spikes")

@nrp.MapSpikeSink("left_wheel_neuron", nrp.brain.left, nrp.leaky_integrator_exp, weight=2.0, timesteps=100)
@nrp.MapSpikeSink("right_wheel_neuron", nrp.brain.right, nrp.leaky_integrator_exp, weight=2.0)
@nrp.MapVariable("times", initial_value=[])
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist), triggers=["left_wheel_neuron"])
def linear_twist(t, left_wheel_neuron, right_wheel_neuron, times):
    times.value.append((round(t, 3), left_wheel_neuron.voltage > 0, right_wheel_neuron.voltage))

@nrp.MapSpikeSink("cells", nrp.brain.left, nrp.leaky_integrator_exp)
@nrp.MapVariable("times", initial_value=[])
@nrp.Neuron2Robot(triggers=["cells"])
def fast(t, cells, times):
    times.value.append(round(t, 3))
"""
IN_STEPS = [0.02 * i for i in range(15)]


@pytest.fixture
def run(written: Callable[..., Path]) -> Iterator[Run]:
    """The functions after 0.3 s."""
    path = written(BRAIN, FUNCTIONS, "<mode>SynchronousSpinnakerSimulation</mode>")
    with Run(read_exc(path, ["brain.backend=event"])) as opened:
        opened.run_until(0.3)
        yield opened


def values(run: Run, function: str, variable: str) -> list[object]:
    (found,) = (one for one in run.loop.functions if one.name == function)
    return found.adapters[variable].value  # type: ignore[attr-defined,no-any-return]


def test_a_spike_recorder_triggers_when_neurons_have_spiked_and_then_forgets_them(run: Run) -> None:
    assert not run.result().failures
    # the cell spikes once for each spike of the train, in the steps that begin at 20 and 100 ms
    assert values(run, "live_monitor", "seen") == [(0.02, 1), (0.1, 1)]


def test_a_leaky_integrator_triggers_after_each_of_its_time_steps(run: Run) -> None:
    # 100 time steps of 1 ms: 100, 200 and 300 ms, which end the steps that begin at 80, 180 and 280 ms
    assert values(run, "linear_twist", "times") == [(0.08, True, 0), (0.18, True, 0), (0.28, True, 0)]
    # 10 time steps, the default, are less than a step of the loop
    assert values(run, "fast", "times") == pytest.approx(IN_STEPS)
    assert not any("timesteps" in str(problem) for problem in run.result().problems)
