"""What is wrong with a transfer function is said where it is declared."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from golden import Golden

from nrp_core.dsl.functions import Flow, TransferFunction
from nrp_core.errors import ExperimentError, TransferFunctionError

Load = Callable[[str], list[TransferFunction]]


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (1, "@nrp.Robot2Neuron()\ndef f(x): pass", "'f'"),
        (1, "@nrp.Robot2Neuron()\ndef f(): pass", ""),
        (1, "@nrp.Robot2Neuron()\ndef f(t, *x): pass", r"no \*, \*\* or /"),
        (1, "@nrp.Robot2Neuron()\ndef f(t, *, x): pass", "plain parameters"),
        (1, "@nrp.Robot2Neuron()\ndef f(t): yield t", ""),
        (1, "@nrp.Robot2Neuron()\nasync def f(t): pass", "not async"),
        (1, "@nrp.MapVariable('t')\n@nrp.Robot2Neuron()\ndef f(t): pass", "'t'"),
        (
            1,
            "@nrp.MapVariable('cam')\n@nrp.Robot2Neuron()\ndef f(t, camera): pass",
            "'cam'.*'camera'",
        ),
        (
            1,
            "@nrp.MapVariable('x')\n@nrp.MapVariable('x')\n@nrp.Robot2Neuron()\ndef f(t, x): pass",
            "'x'.*:2",
        ),
        (
            1,
            "@nrp.MapSpikeSource('x', nrp.brain.a,\n  nrp.leaky_integrator_alpha)\ndef f(t, x): pass",
            "leaky_integrator_alpha.*fixed_frequency, dc_source",
        ),
        (
            2,
            "x = 1\n@nrp.MapSpikeSink('x', nrp.brain.a, nrp.poisson)\ndef f(t, x): pass",
            "MapSpikeSink",
        ),
        (1, "@nrp.MapSpikeSink('x', nrp.brain.a, 'poisson')\ndef f(t, x): pass", "'poisson'"),
        (
            1,
            "@nrp.MapSpikeSource('x', nrp.brain.a, nrp.poisson, wieght=3)\ndef f(t, x): pass",
            "'wieght'.*'weight'",
        ),
        (1, "@nrp.MapVariable('x', scope='world')\ndef f(t, x): pass", "unknown scope 'world'"),
        (1, "@nrp.MapVariable(3)\ndef f(t, x): pass", ""),
        (1, "@nrp.MapRobotSubscriber('x', 5)\ndef f(t, x): pass", ""),
        (1, "@nrp.Neuron2Robot(Topic('', None))\ndef f(t): pass", ""),
        (1, "@nrp.Neuron2Robot(Topic('/a', 'std_msgs/Flaot64'))\ndef f(t): pass", "'Float64'"),
        (1, "@nrp.Neuron2Robot(Topic('/a', 'std_msg/Float64'))\ndef f(t): pass", "'std_msgs'"),
        (1, "@nrp.Neuron2Robot(Topic('/a', 3))\ndef f(t): pass", ""),
        (
            1,
            "@nrp.Robot2Neuron(triggers='x')\ndef f(t): pass",
            "'x'",
        ),
        (1, "@nrp.Robot2Neuron(triggers=5)\ndef f(t): pass", ""),
        (1, "@nrp.Robot2Neuron(throttling_rate=0)\ndef f(t): pass", ""),
        (1, "@nrp.Robot2Neuron(throttling_rate=True)\ndef f(t): pass", "not True"),
        (1, "@nrp.Robot2Neuron(throttling_rate='30 Hz')\ndef f(t): pass", "not '30 Hz'"),
        (1, "@nrp.Robot2Neuron(priority='high')\ndef f(t): pass", "integer, not 'high'"),
        (1, "@nrp.Robot2Neuron()\nclass F: pass", ""),
        (
            1,
            "@nrp.Robot2Neuron()\n@nrp.MapVariable('x')\ndef f(t, x): pass",
            "'f'.*@Robot2Neuron",
        ),
        (
            4,
            "@nrp.Robot2Neuron()\ndef f(t): pass\n\n@nrp.Robot2Neuron()\ndef f(t): pass",
            "'f'.*functions.py:1",
        ),
    ],
)
def test_a_wrong_declaration_is_refused_with_its_line(
    load: Load, line: int, text: str, message: str, golden: Golden
) -> None:
    with golden.raises(ExperimentError, match=message) as caught:
        load(text)
    assert caught.value.path is not None
    assert (caught.value.path.name, caught.value.line) == ("functions.py", line)


def test_a_mapping_alone_makes_the_transfer_function(load: Load) -> None:
    (reads,) = load("@nrp.MapSpikeSink('x', nrp.brain.a, nrp.population_rate)\ndef f(t, x): pass")
    (drives,) = load("@nrp.MapSpikeSource('x', nrp.brain.a, nrp.poisson)\ndef f(t, x): pass")
    assert (reads.flow, drives.flow) == (Flow.NEURON_TO_ROBOT, Flow.ROBOT_TO_NEURON)


def test_a_transfer_function_can_be_called_with_anything(load: Load) -> None:
    (function,) = load(
        "@nrp.MapVariable('x')\n@nrp.Robot2Neuron()\ndef f(t, x):\n    'Adds.'\n    return t + x"
    )
    assert function(1, x=2) == 3
    assert function.__doc__ == "Adds."


def test_a_transfer_function_prints_what_it_maps(load: Load) -> None:
    (function,) = load(
        """
        @nrp.MapSpikeSink("left", nrp.brain.actors[0], nrp.leaky_integrator_alpha, tau_m=5.0)
        @nrp.MapRobotSubscriber("camera", "/husky/camera")
        @nrp.MapRobotPublisher("command", Topic("/arm", "std_msgs/Float64"))
        @nrp.MapVariable("count", initial_value=0)
        @nrp.MapVariable("total", scope=nrp.GLOBAL)
        @nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
        def drive(t, left, camera, command, count, total, extra):
            pass
        """
    )
    path = function.place.path
    assert str(function).splitlines() == [
        f"Neuron2Robot drive, {path}:1",
        "  left: leaky_integrator_alpha on brain.actors[0], tau_m=5.0",
        "  camera: reads /husky/camera",
        "  command: publishes on /arm (std_msgs/msg/Float64)",
        "  count: variable",
        "  total: shared variable 'total'",
        "  extra: not mapped",
        "  returns to /husky/cmd_vel (geometry_msgs/msg/Twist)",
    ]
    assert repr(function) == (
        f"<Neuron2Robot drive(t, left, camera, command, count, total, extra) at {path}:1>"
    )


def test_a_mapped_parameter_is_an_attribute_only_once_it_is_bound(load: Load, golden: Golden) -> None:
    (function,) = load("@nrp.MapVariable('count')\n@nrp.Robot2Neuron()\ndef f(t, count): pass")
    with golden.raises(AttributeError, match=r"'f'.*bind\(brain.*'count'"):
        _ = function.count
    with golden.raises(AttributeError, match="'counts'"):
        _ = function.counts


def test_the_error_is_also_a_value_error(load: Load, golden: Golden) -> None:
    with golden.raises(ValueError):
        load("@nrp.Robot2Neuron()\ndef f(): pass")
    assert issubclass(TransferFunctionError, ValueError)
