"""A transfer function is tested in three lines."""

from __future__ import annotations

from collections.abc import Callable

from golden import Golden

from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.testing import Rig
from nrp_core.errors import TransferFunctionError

Load = Callable[[str], list[TransferFunction]]

EVERYTHING = """
@nrp.MapSpikeSink("wheel", nrp.brain.actors[0], nrp.leaky_integrator_exp)
@nrp.MapSpikeSink("rates", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.population_rate)
@nrp.MapSpikeSink("spikes", nrp.brain.actors[3:], nrp.spike_recorder)
@nrp.MapSpikeSource("eye", nrp.brain.sensors, nrp.poisson)
@nrp.MapVariable("gain", initial_value=2.0)
@nrp.Neuron2Robot(Topic("/arm", std_msgs.msg.Float64))
def f(t, wheel, rates, spikes, eye, gain):
    eye.rate = sum(rates.rate) + len(spikes.times)
    return std_msgs.msg.Float64(gain.value * wheel.voltage)
"""


def test_set_what_it_sees_run_it_and_look_at_what_it_wrote(load: Load) -> None:
    (function,) = load(EVERYTHING)
    rig = Rig(function)
    rig.set(wheel=0.5, rates=[10.0, 20.0], spikes=[3.0, 1.0], gain=4.0)
    rig.run()
    assert function.eye.rate == 32.0
    assert rig.sent("/arm")[-1].data == 2.0
    rig.run()
    assert function.eye.rate == 30.0  # the spikes were of the step before


def test_a_function_can_go_from_rig_to_rig(load: Load) -> None:
    (function,) = load(EVERYTHING)
    first = Rig(function)
    first.set(wheel=0.5)
    second = Rig(function)
    second.run()
    assert second.sent("/arm")[-1].data == 0.0
    assert first.brain.devices == ()


def test_an_input_that_the_function_does_not_read_cannot_be_set(load: Load, golden: Golden) -> None:
    (function,) = load(EVERYTHING)
    rig = Rig(function)
    with golden.raises(TransferFunctionError, match="'wheels'.*'wheel'"):
        rig.set(wheels=1.0)
    with golden.raises(TransferFunctionError, match="'f'.*'eye'"):
        rig.set(eye=1.0)


def test_a_list_for_a_group_must_fit(load: Load, golden: Golden) -> None:
    (function,) = load(EVERYTHING)
    with golden.raises(ValueError):
        Rig(function).set(rates=[1.0])


def test_a_monitor_is_tested_likewise(load: Load) -> None:
    (monitor,) = load(
        "@nrp.NeuronMonitor(nrp.brain.actors, nrp.population_rate)\n"
        "def busy(t):\n    return True if t > 0.03 else None\n"
    )
    rig = Rig(monitor)
    rig.set(device=12.0)
    rig.run()
    assert rig.sent("/monitor/population_rate") == []
    rig.run()
    assert rig.sent("/monitor/population_rate")[-1].rate == 12.0


def test_a_text_for_a_number_is_refused_by_the_name_of_the_setting(load: Load, golden: Golden) -> None:
    (function,) = load(
        "@nrp.MapSpikeSource('eye', nrp.brain.sensors, nrp.poisson, weight='0.1')\n"
        "@nrp.Robot2Neuron()\ndef see(t, eye):\n    eye.rate = 1.0\n"
    )
    with golden.raises(TransferFunctionError, match=r"'0\.1'"):
        Rig(function)
