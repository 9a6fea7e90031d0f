"""Binding gives every parameter what it stands for, or says which one cannot have it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import nrp_experiments.bodies
import numpy as np
import pytest
from golden import Golden

from nrp_core import Scene, read_model
from nrp_core.dsl.devices import DeviceGroup
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import (
    CapabilityError,
    ExperimentError,
    LifecycleError,
    NeuronSelectionError,
    TopicError,
    TransferFunctionError,
)
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.std_msgs import Float64

BODIES = Path(nrp_experiments.bodies.__path__[0])

Load = Callable[[str], list[TransferFunction]]


def brain() -> MockBrain:
    return MockBrain({"sensors": 5, "actors": 2})


def world() -> MockWorld:
    return MockWorld({"/arm": Float64, "/husky/cmd_vel": Twist})


WRONG: list[tuple[type[ExperimentError], str, str, str]] = [
    (
        NeuronSelectionError,
        "MapSpikeSink('x', nrp.brain.actor, nrp.population_rate)",
        "Neuron2Robot()",
        "'f', parameter 'x': the brain has no population 'actor'; did you mean 'actors'",
    ),
    (
        NeuronSelectionError,
        "MapSpikeSink('x', nrp.brain.actors[2], nrp.population_rate)",
        "Neuron2Robot()",
        "'actors' has 2 neurons, 0..1; 2 is out of range",
    ),
    (
        TransferFunctionError,
        "MapSpikeSource('x', nrp.brain.actors, nrp.poisson, delay=-1)",
        "Robot2Neuron()",
        "parameter 'x': delay must be 0 ms or more, not -1",
    ),
    (
        TransferFunctionError,
        "MapSpikeSource('x', nrp.brain.actors, nrp.poisson, weight='big')",
        "Robot2Neuron()",
        "'f', parameter 'x': ",
    ),
    (
        TransferFunctionError,
        "MapSpikeSource('x', nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.poisson, weight=[1] * 3)",
        "Robot2Neuron()",
        "'weight' has 3 values for 2 devices",
    ),
    (
        NeuronSelectionError,
        "MapVariable('x', initial_value=nrp.resolve(lambda brain: 1 // 0))",
        "Robot2Neuron()",
        "ZeroDivisionError",
    ),
    (
        TopicError,
        "MapRobotSubscriber('x', '/husky/cmd_vell')",
        "Robot2Neuron()",
        "no topic '/husky/cmd_vell'; did you mean '/husky/cmd_vel'",
    ),
    (
        TopicError,
        "MapRobotSubscriber('x', Topic('/arm', 'std_msgs/String'))",
        "Robot2Neuron()",
        "'/arm' carries std_msgs/msg/Float64, not std_msgs/msg/String",
    ),
    (
        TopicError,
        "MapRobotPublisher('x', '/legg')",
        "Robot2Neuron()",
        r"which needs its type: Topic\('/legg', TYPE\)",
    ),
    (
        TopicError,
        "MapVariable('x')",
        "Neuron2Robot(Topic('/arm', 'std_msgs/String'))",
        "return value of transfer function 'f': '/arm' carries",
    ),
    (
        TransferFunctionError,
        "MapVariable('x')",
        "Robot2Neuron(triggers=['x'])",
        "cannot be triggered by 'x'; only subscribed topics and spike recorders",
    ),
]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'name="elbow" type="revolute"',
            'name="elbow" type="fixed"',
            "'elbow'",
        ),
        (
            "<limit><lower>-2.5",
            "<mimic joint='shoulder'><multiplier>1</multiplier></mimic><limit><lower>-2.5",
            "'elbow'.*'shoulder'",
        ),
    ],
)
def test_a_command_for_a_joint_that_takes_none_is_refused_with_the_reason(
    load: Load, tmp_path: Path, old: str, new: str, message: str, golden: Golden
) -> None:
    text = (BODIES / "arm.sdf").read_text()
    assert old in text
    (tmp_path / "arm.sdf").write_text(
        text.replace(old, new).replace("<plugin", "<unused").replace("</plugin", "</unused")
    )
    arm = MockWorld(scene=Scene((read_model(tmp_path / "arm.sdf"),)))
    (function,) = load(
        "@nrp.MapRobotPublisher('x', Topic('/arm/elbow/cmd_pos', 'std_msgs/Float64'))\n"
        "@nrp.Robot2Neuron()\ndef f(t, x): pass"
    )
    with golden.raises(TopicError, match=message):
        function.bind(brain(), arm)


def test_a_topic_that_differs_by_a_prefix_is_proposed_first(load: Load, golden: Golden) -> None:
    (function,) = load(
        "@nrp.MapRobotSubscriber('x', Topic('/husky/scan', 'std_msgs/Float64'))\n"
        "@nrp.Robot2Neuron()\ndef f(t, x): pass"
    )
    with golden.raises(TopicError, match="'/scan'"):
        function.bind(brain(), MockWorld({"/scan": Float64, "/husky/span": Float64}))


@pytest.mark.parametrize(("kind", "mapping", "decorator", "message"), WRONG)
def test_an_unknown_name_is_reported_with_function_parameter_and_line(
    load: Load, kind: type[ExperimentError], mapping: str, decorator: str, message: str
) -> None:
    (function,) = load(f"@nrp.{mapping}\n@nrp.{decorator}\ndef f(t, x): pass")
    mind, robot = brain(), world()
    with pytest.raises(kind, match=message) as caught:
        function.bind(mind, robot)
    assert Path(str(caught.value.path)).name == "functions.py"
    assert caught.value.line == 1
    assert not function.is_bound
    assert mind.devices == ()


def test_a_parameter_that_is_not_mapped_is_reported(load: Load, golden: Golden) -> None:
    (function,) = load("@nrp.Robot2Neuron()\ndef f(t, x): pass")
    with golden.raises(TransferFunctionError, match="'x'"):
        function.bind(brain(), world())


def test_bindings_before_a_failure_are_released(load: Load, golden: Golden) -> None:
    (function,) = load(
        """
        @nrp.MapSpikeSource("good", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.poisson)
        @nrp.MapSpikeSource("half", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.poisson,
                            delay=[0.1, -1.0])
        @nrp.Robot2Neuron()
        def f(t, good, half): pass
        """
    )
    mind = brain()
    with golden.raises(TransferFunctionError):
        function.bind(mind, world())
    assert mind.devices == ()


def test_a_missing_capability_stays_a_capability_error_with_its_line(load: Load, golden: Golden) -> None:
    (function,) = load(
        "@nrp.MapSpikeSink('x', nrp.brain.actors, nrp.leaky_integrator_exp, v_thresh=1.0)\ndef f(t, x): pass"
    )
    with golden.raises(CapabilityError, match="functions.py:1.*'x'"):
        function.bind(brain(), world())


def test_bound_parameters_are_attributes_and_are_given_back(load: Load, golden: Golden) -> None:
    (function,) = load(
        """
        @nrp.MapSpikeSource("eye", nrp.brain.sensors[0, 2], nrp.poisson, weight=0.5)
        @nrp.MapSpikeSink("wheels", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.population_rate)
        @nrp.MapRobotSubscriber("arm", "/arm")
        @nrp.Robot2Neuron()
        def f(t, eye, wheels, arm): pass
        """
    )
    mind, robot = brain(), world()
    function.bind(mind, robot)
    assert function.eye.port.neurons.tolist() == [0, 2]
    assert isinstance(function.wheels, DeviceGroup)
    assert [wheel.port.name for wheel in function.wheels] == ["f/wheels/0", "f/wheels/1"]
    assert function.eye.port.name == "f/eye"
    assert len(mind.devices) == 3
    with golden.raises(LifecycleError):
        function.bind(mind, robot)
    function.unbind()
    assert not mind.devices
    function.bind(mind, robot)
    assert len(mind.devices) == 3


def test_settings_may_depend_on_the_brain_and_differ_within_a_group(load: Load) -> None:
    (function,) = load(
        """
        @nrp.MapSpikeSource("eyes", nrp.map_neurons(3, lambda i: nrp.brain.sensors[i]), nrp.poisson,
                            rate=[1.0, 2.0, 3.0])
        @nrp.MapSpikeSource("one", nrp.brain.sensors[0], nrp.poisson, rate=nrp.brain.sensors.size)
        @nrp.MapVariable("n", initial_value=nrp.brain.actors.size)
        @nrp.Robot2Neuron()
        def f(t, eyes, one, n): pass
        """
    )
    function.bind(brain(), world())
    assert function.eyes.rate == [1, 2, 3]
    assert function.one.rate == 5
    assert function.n.value == 2


def test_running_an_unbound_function_is_refused(load: Load, golden: Golden) -> None:
    (function,) = load("@nrp.Robot2Neuron()\ndef f(t): pass")
    with golden.raises(LifecycleError):
        function.run(0)


def test_an_inactive_function_is_not_due_and_its_sources_are_silent(load: Load) -> None:
    (function,) = load(
        "@nrp.MapSpikeSource('x', nrp.brain.sensors, nrp.dc_source)\n@nrp.Robot2Neuron()\ndef f(t, x): pass"
    )
    function.active = False
    function.bind(brain(), world())
    assert not list(function.calls_due(0))
    assert not function.x.active
    function.x.amplitude = 1.0
    function.active = True
    assert list(function.calls_due(0))
    assert function.x.active
    assert np.all(function.x.port.current_na(0.0) == 1.0)
