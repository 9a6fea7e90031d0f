"""Messages as people write them."""

import math
from typing import Any

import numpy as np
import pytest

from nrp_core.errors import TopicError
from nrp_core.experiment.events.events import to_message
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose, Twist, Vector3
from nrp_core.messages.sensor_msgs import JointState
from nrp_core.messages.std_msgs import Bool, ColorRGBA, Float64, Int32, String
from nrp_core.world.topics import Direction, TopicInfo


def converted(kind: type, value: Any) -> Any:
    return to_message(TopicInfo("/topic", kind, Direction.IN), value)


@pytest.mark.parametrize(
    ("kind", "value", "message"),
    [
        (ColorRGBA, "red", ColorRGBA(1, 0, 0, 1)),
        (ColorRGBA, "Gazebo/BlueGlow", ColorRGBA(0, 0, 1, 1)),
        (ColorRGBA, [1, 0.5, 0], ColorRGBA(1, 0.5, 0, 1)),
        (ColorRGBA, [1, 0.5, 0, 0.5], ColorRGBA(1, 0.5, 0, 0.5)),
        (ColorRGBA, {"g": 1}, ColorRGBA(0, 1, 0, 1)),
        (ColorRGBA, ColorRGBA(1, 1, 1, 1), ColorRGBA(1, 1, 1, 1)),
        (Float64, 2, Float64(2.0)),
        (Float64, {"data": 2.5}, Float64(2.5)),
        (Int32, 3, Int32(3)),
        (Bool, True, Bool(True)),
        (String, "hello", String("hello")),
        (Twist, {"linear": {"x": 1}, "angular": [0, 0, 2]}, Twist(Vector3(1, 0, 0), Vector3(0, 0, 2))),
        (Twist, [[1, 0, 0]], Twist(Vector3(1, 0, 0))),
        (
            ModelState,
            {"model_name": "box", "pose": {"position": [1, 2, 3]}},
            ModelState("box", Pose(Point(1, 2, 3))),
        ),
    ],
)
def test_a_value_becomes_the_message_that_was_meant(kind: type, value: Any, message: Any) -> None:
    assert converted(kind, value) == message


def test_arrays_are_arrays_of_the_fields_type() -> None:
    message = converted(JointState, {"name": ["a", "b"], "position": [1, 2]})
    assert message.name == ["a", "b"]
    assert message.position.dtype == np.float64
    assert message.position.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("kind", "value", "reason"),
    [
        (ColorRGBA, "rde", "no material 'rde'; did you mean 'red'"),
        (ColorRGBA, [1, 0, 0, 1, 1], "5 values for the 4 fields r, g, b, a"),
        (ColorRGBA, [1, 0], "a colour is [r, g, b] or [r, g, b, a], not [1, 0]"),
        (ColorRGBA, 1.0, "1.0 is not a message; give its fields r, g, b, a"),
        (ColorRGBA, ["a", 0, 0], "'a' is not of type float"),
        (ColorRGBA, [math.nan, 0, 0], "r is nan"),
        (ColorRGBA, None, "None is not a message"),
        (Float64, "x", "'x' is not of type float"),
        (Float64, True, "True is not of type float"),
        (Int32, 1.5, "1.5 is not of type int"),
        (Bool, 1, "1 is not of type bool"),
        (String, 1, "1 is not of type str"),
        (Twist, {"liner": {}}, "no field 'liner'; did you mean 'linear'"),
        (Twist, {"linear": {"w": 1}}, "no field 'w'; valid: x, y, z"),
        (JointState, {"name": "a"}, "'a' is not a list"),
        (JointState, {"position": ["x"]}, "could not convert"),
        (Float64, String("x"), "String"),
    ],
)
def test_a_value_that_the_topic_cannot_carry_is_refused_with_the_reason(
    kind: type, value: Any, reason: str
) -> None:
    with pytest.raises(TopicError) as error:
        converted(kind, value)
    assert "/topic" in str(error.value)
    assert reason in str(error.value)
