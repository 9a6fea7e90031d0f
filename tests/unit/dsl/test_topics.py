"""Topics as functions see them: the last message, whether it is new, and what may be sent."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.messages import message_packages, message_type
from nrp_core.dsl.parameters import (
    PreprocessedTopic,
    PublishedTopic,
    ReceivedMessage,
    SubscribedTopic,
    Topic,
)
from nrp_core.dsl.testing import MockBrain, MockWorld, Rig
from nrp_core.errors import TopicError, TransferFunctionError
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.std_msgs import Float64

Load = Callable[[str], list[TransferFunction]]

READS = """
@nrp.MapRobotSubscriber("x", Topic("/x", "std_msgs/Float64"))
@nrp.Robot2Neuron({})
def f(t, x):
    return x.value, x.changed
"""


def subscribed(initial: Any = None) -> tuple[MockWorld, SubscribedTopic]:
    world = MockWorld({"/x": Float64})
    return world, SubscribedTopic(world, Topic("/x"), initial)


def test_before_the_first_message_the_value_is_none_or_the_given_default() -> None:
    _, topic = subscribed()
    topic.refresh(0)
    assert (topic.value, topic.changed) == (None, False)
    assert subscribed(Float64(3.0))[1].value == Float64(3.0)


def test_a_message_is_new_to_each_reader_once() -> None:
    world, early = subscribed()
    late = SubscribedTopic(world, Topic("/x"))
    early.refresh(0)
    world.put("/x", Float64(1.0))  # after the first reader looked, before the second does
    late.refresh(0)
    assert (late.value, late.changed) == (Float64(1.0), True)
    early.refresh(20)
    late.refresh(20)
    assert (early.value, early.changed) == (Float64(1.0), True)
    assert (late.value, late.changed) == (Float64(1.0), False)


def test_two_equal_messages_are_two_changes() -> None:
    world, topic = subscribed()
    for _ in range(2):
        world.put("/x", Float64(1.0))
        topic.refresh(0)
        assert topic.changed


def test_a_function_gets_all_messages_since_it_last_ran_with_their_times() -> None:
    world, topic = subscribed()
    assert topic.messages == []
    for step in (20, 40, 60):
        for x in (step, step + 1):
            world.put("/x", Float64(x))
        world.run_until(step * 1_000_000)
    topic.refresh(0)
    assert [(t, message.data) for t, message in topic.messages] == [
        (0.0, 20), (0.0, 21), (0.02, 40), (0.02, 41), (0.04, 60), (0.04, 61),
    ]  # fmt: skip
    assert topic.messages[-1].value is topic.value
    topic.refresh(0)
    assert (topic.messages, topic.value.data, topic.changed) == ([], 61, False)


def test_messages_that_a_function_did_not_run_for_are_dropped_and_reported(golden: Golden) -> None:
    world = MockWorld({"/x": Float64})
    topic = SubscribedTopic(world, Topic("/x"), function="rarely")
    for step in range(200):
        world.put("/x", Float64(step))
        world.run_until((step + 1) * 10_000_000)
    topic.refresh(0)
    assert topic.value.data == 199
    assert not world.warnings
    assert len(topic.messages) == 101
    golden(*(finding.message for finding in world.warnings))


def test_messages_between_two_runs_reach_a_rare_reader() -> None:
    world, topic = subscribed()
    world.put("/x", Float64(1.0))
    world.run_until(20_000_000)
    world.run_until(40_000_000)
    topic.refresh(0)
    assert topic.changed


def test_the_value_stays_the_same_while_the_function_runs() -> None:
    world, topic = subscribed()
    topic.refresh(0)
    world.put("/x", Float64(1.0))
    assert (topic.value, topic.changed) == (None, False)


def test_reset_forgets_the_value() -> None:
    world, topic = subscribed(Float64(7.0))
    world.put("/x", Float64(1.0))
    topic.refresh(0)
    world.reset()
    topic.reset()
    topic.refresh(0)
    assert (topic.value, topic.changed) == (Float64(7.0), False)


def test_a_function_triggered_by_a_topic_is_due_when_something_came(load: Load) -> None:
    (function,) = load(READS.format("triggers='x'"))
    rig = Rig(function)
    assert not list(function.calls_due(0))
    rig.set(x=Float64(1.0))
    assert list(function.calls_due(0))
    assert rig.run() == (Float64(1.0), True)
    assert not list(function.calls_due(20_000_000))


EACH = """
seen = []
@nrp.MapRobotSubscriber("z", Topic("/z", "std_msgs/Float64"))
@nrp.MapRobotSubscriber("y", Topic("/y", "std_msgs/Float64"))
@nrp.MapRobotSubscriber("x", Topic("/x", "std_msgs/Float64"))
@nrp.Robot2Neuron(triggers=["x", "y"], calls="each"{})
def f(t, x, y, z):
    return (t, *([message.value.data for message in topic.messages] for topic in (x, y, z)))
"""


def test_each_message_of_its_triggers_calls_a_function_in_the_order_of_their_times(load: Load) -> None:
    (function,) = load(EACH.format(""))
    rig = Rig(function)
    for name, t in (("y", 0.003), ("x", 0.001), ("x", 0.004), ("z", 0.002), ("z", 0.003), ("z", 0.009)):
        rig.set(**{name: ReceivedMessage(t, Float64(1000 * t))})
    assert rig.run() == [(0.001, [1], [], []), (0.003, [], [3], [2, 3]), (0.004, [4], [], [])]
    assert rig.run() == []
    rig.set(x=ReceivedMessage(0.021, Float64(21)))
    assert rig.run() == [(0.021, [21], [], [9])]


def test_messages_that_a_throttling_rate_does_not_admit_come_with_the_next_call(load: Load) -> None:
    (function,) = load(EACH.format(", throttling_rate=500"))
    rig = Rig(function)
    for ms in range(20):
        rig.set(x=ReceivedMessage(ms / 1000, Float64(ms)))
    calls = rig.run()
    assert [t for t, *_ in calls] == [ms / 1000 for ms in range(0, 20, 2)]
    assert [len(x) for _, x, _, _ in calls] == [1] + 9 * [2]


@pytest.mark.parametrize("wrong", ["calls='all', triggers='x'", "calls='each'", "calls='each', triggers='t'"])
def test_calls_are_once_or_each_and_need_triggers(load: Load, wrong: str, golden: Golden) -> None:
    with golden.raises(TransferFunctionError, match="calls"):
        load(READS.format(wrong))


SPIKES = """
@nrp.MapSpikeSink("x", {}, nrp.spike_recorder)
@nrp.Neuron2Robot(triggers="x")
def f(t, x): return [len(one.times) for one in ({})]
"""


@pytest.mark.parametrize(
    ("neurons", "each"),
    [("nrp.brain.p", "[x]"), ("nrp.map_neurons(range(2), lambda i: nrp.brain.p[i])", "x")],
)
def test_a_function_triggered_by_a_spike_recorder_is_due_when_a_neuron_spiked(
    load: Load, neurons: str, each: str
) -> None:
    (function,) = load(SPIKES.format(neurons, each))
    rig = Rig(function, brain=MockBrain({"p": 2}))
    assert not list(function.calls_due(0))
    rig.set(x=[5.0] if each == "[x]" else [[], [5.0]])
    assert list(function.calls_due(0))
    assert sum(rig.run()) == 1
    assert not list(function.calls_due(20_000_000))


def test_a_throttled_trigger_waits_for_its_period(load: Load) -> None:
    (function,) = load(READS.format("triggers=['x'], throttling_rate=10"))
    rig = Rig(function)
    due = []
    for k in range(10):
        rig.set(x=Float64(1.0))
        due.append(bool(function.calls_due(k * 20_000_000)))
        if due[-1]:
            rig.run()
    assert [k for k in range(10) if due[k]] == [0, 5]


@pytest.mark.parametrize("result", ["3.0", "'fast'", "geometry_msgs.msg.Vector3()"])
def test_a_return_value_of_another_type_is_refused_by_function_topic_and_type(
    load: Load, result: str, golden: Golden
) -> None:
    (function,) = load(
        f"@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))\ndef drive(t): return {result}"
    )
    rig = Rig(function)
    with golden.raises(TopicError, match="'drive': /husky/cmd_vel.*geometry_msgs") as caught:
        rig.run()
    assert str(caught.value).startswith(f"{function.place}: ")
    assert rig.sent("/husky/cmd_vel") == []


def test_a_message_with_a_number_that_is_none_is_refused(load: Load, golden: Golden) -> None:
    (function,) = load(
        "@nrp.Neuron2Robot(Topic('/cmd', 'geometry_msgs/Twist'))\n"
        "def drive(t): return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(float('nan'), 0, 0))"
    )
    with golden.raises(TopicError, match="geometry_msgs/msg/Twist, linear.x"):
        Rig(function).run()


def test_none_is_not_sent_and_without_a_topic_nothing_is(load: Load) -> None:
    functions = load(
        """
        @nrp.Neuron2Robot(Topic("/cmd", geometry_msgs.msg.Twist))
        def nothing(t): return None
        @nrp.Neuron2Robot()
        def unused(t): return 5
        """
    )
    rig = Rig(functions[0])
    assert rig.run() is None
    assert rig.sent("/cmd") == []
    assert Rig(functions[1]).run() == 5


def test_a_publisher_sends_at_its_declared_rate(load: Load) -> None:
    (function,) = load(
        """
        @nrp.MapRobotPublisher("arm", Topic("/arm", std_msgs.msg.Float64), queue_size=1)
        @nrp.Neuron2Robot()
        def f(t, arm):
            arm.send_message(std_msgs.msg.Float64(1))
            arm.send_message(std_msgs.msg.Float64(2))
        """
    )
    rig = Rig(function)
    rig.run()
    assert rig.sent("/arm") == [Float64(1), Float64(2)]


def foreign(**attributes: Any) -> type:
    return type("Twist", (), attributes)


@pytest.mark.parametrize(
    "given",
    [
        Twist,
        "geometry_msgs/Twist",
        "geometry_msgs/msg/Twist",
        "geometry_msgs.msg.Twist",
        foreign(_type="geometry_msgs/Twist"),
        foreign(__msgtype__="geometry_msgs/msg/Twist"),
        foreign(get_fields_and_field_types=dict, __module__="geometry_msgs.msg._twist"),
    ],
)
def test_a_message_type_is_ours_however_it_is_named(given: object) -> None:
    assert message_type(given) is Twist
    assert Topic("/cmd", given).topic_type is Twist


def test_any_other_class_is_a_message_type_of_its_own() -> None:
    assert message_type(SimpleNamespace) is SimpleNamespace


def test_every_message_class_is_found_under_its_ros_name() -> None:
    for package, module in message_packages().items():
        names = [name for name in dir(module.msg) if not name.startswith("_")]
        types = [kind for kind in (getattr(module.msg, name) for name in names) if isinstance(kind, type)]
        assert types, package
        for type_ in types:
            assert message_type(f"{package}/{type_.__name__}") is type_


def test_reports_show_arrays_by_shape(load: Load) -> None:
    (function,) = load(
        "@nrp.MapRobotSubscriber('camera', Topic('/c', 'sensor_msgs/Image'))\ndef f(t, camera): pass"
    )
    rig = Rig(function)
    pixels = np.zeros((240, 320, 3), np.uint8)
    rig.set(camera=message_type("sensor_msgs/Image")(height=240, width=320, data=pixels))
    rig.run()
    assert "data=uint8 array of shape (240, 320, 3)" in function.inputs()["camera"]


def test_a_preprocessed_topic_changes_each_incoming_message_once() -> None:
    seen: list[float] = []

    def doubled(message: Float64) -> float:
        seen.append(message.data)
        return 2 * message.data

    world = MockWorld({"/x": Float64})
    topic = SubscribedTopic(world, PreprocessedTopic("/x", Float64, doubled))
    world.put("/x", Float64(4.0))
    for _ in range(3):
        topic.refresh(0)
    assert (topic.value, seen) == (8.0, [4.0])


def test_a_preprocessed_topic_changes_what_is_sent() -> None:
    world = MockWorld({"/x": Float64})
    PublishedTopic(world, PreprocessedTopic("/x", Float64, abs)).send_message(-3.0)
    assert world.sent("/x") == [Float64(3.0)]


def test_a_preprocessing_that_is_not_callable_is_refused(golden: Golden) -> None:
    with golden.raises(TransferFunctionError, match="pre_processing"):
        PreprocessedTopic("/x", Float64, 3)  # type: ignore[arg-type]


def test_a_part_of_the_message_that_is_taken_of_its_reader_is_found_in_value(golden: Golden) -> None:
    world, topic = subscribed()
    with golden.raises(AttributeError, match="'/x'.*'data'"):
        _ = topic.data
    world.put("/x", Float64(1.0))
    topic.refresh(0)
    with golden.raises(AttributeError, match=r"'data'.*'\.value\.data'$"):
        _ = topic.data
    assert topic.value.data == 1.0
    assert not hasattr(SubscribedTopic.__new__(SubscribedTopic), "value")
