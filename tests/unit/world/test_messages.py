from __future__ import annotations

import re
from dataclasses import dataclass, field
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.messages import Time, message, type_name, type_of
from nrp_core.messages.base import invalid_field
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.gazebo_srvs import GetModelStateRequest, SetModelConfigurationRequest
from nrp_core.messages.geometry_msgs import Point, Pose, Quaternion, Twist, Vector3
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Bool, ColorRGBA, Float64, Header, Int32, String


def test_messages_are_made_without_arguments_by_position_and_by_name() -> None:
    assert Vector3() == Vector3(0, 0, 0) == Vector3(x=0, z=0)
    assert Twist(Vector3(1, 2, 3)) == Twist(linear=Vector3(z=3, y=2, x=1), angular=Vector3())
    assert Pose().orientation == Quaternion(0, 0, 0, 1)


def test_a_message_shares_nothing_with_the_next_one() -> None:
    first = Twist()
    first.linear.x = 5.0
    assert Twist().linear.x == 0


@pytest.mark.parametrize("name", ["lenear", "X", "data"])
def test_a_misspelt_field_is_an_error_at_once(name: str) -> None:
    with pytest.raises(AttributeError):
        setattr(Twist(), name, 1.0)


def test_messages_are_known_by_their_ros_names() -> None:
    assert type_name(Twist) == "geometry_msgs/msg/Twist"
    assert type_of("geometry_msgs/msg/Twist") is type_of("geometry_msgs/Twist") is Twist
    assert type_of("geometry_msgs/Twits") is None


def test_any_dataclass_can_be_a_message() -> None:
    @message("my_msgs/msg/Whisker")
    @dataclass(slots=True)
    class Whisker:
        angle: float = 0.0

    @dataclass
    class Plain:
        angle: float = 0.0

    assert type_of("my_msgs/Whisker") is Whisker
    assert type_name(Plain) == "Plain"
    assert invalid_field(Plain(nan)) == "angle is nan"


@given(st.integers(0, 10**15))
def test_a_stamp_keeps_every_nanosecond(t_ns: int) -> None:
    stamp = Time.from_ns(t_ns)
    assert stamp.to_ns() == t_ns
    assert 0 <= stamp.nanosec < 10**9


# -- what is wrong with a message


@pytest.mark.parametrize(
    "right",
    [
        Twist(Vector3(1, 2, 3), Vector3(np.float32(1), np.int64(2), 3.5)),
        Int32(np.int32(7)),
        Bool(np.bool_(True)),
        String("text"),
        Image(Header(Time(1, 2), "eye"), 2, 3, "rgb8", 0, 9, np.zeros((2, 3, 3), np.uint8)),
        ModelStates(["husky"], [Pose()], [Twist()]),
    ],
    ids=lambda right: type(right).__name__,
)
def test_a_value_of_the_declared_type_is_valid(right: object) -> None:
    assert invalid_field(right) is None


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        (Vector3(x=nan), "x is nan"),
        (Twist(angular=Vector3(z=inf)), "angular.z is inf"),
        (Float64(-inf), "data is -inf"),
        (Twist(Vector3(y="fast")), "linear.y must be a number, not 'fast'"),  # type: ignore[arg-type]
        (Twist(linear=5), "linear must be a geometry_msgs/msg/Vector3, not 5"),  # type: ignore[arg-type]
        (Twist(linear=Vector3), "linear must be a geometry_msgs/msg/Vector3"),  # type: ignore[arg-type]
        (Pose(position=Vector3()), "position must be a geometry_msgs/msg/Point"),  # type: ignore[arg-type]
        (Int32(1.5), "data must be a whole number, not 1.5"),  # type: ignore[arg-type]
        (String(3), "data must be a text, not 3"),  # type: ignore[arg-type]
        (ColorRGBA(r=None), "r must be a number, not None"),  # type: ignore[arg-type]
        (ModelStates(["a", "b"], [Pose(), Pose(Point(z=nan))], []), "pose[1].position.z is nan"),
    ],
)
def test_a_field_that_cannot_be_sent_is_named(wrong: object, reason: str) -> None:
    assert str(invalid_field(wrong)).startswith(reason)


@dataclass
class Chain:
    """A message that may hold another of its kind."""

    next: Chain
    length: float = 0.0


def test_messages_of_floats_that_are_huge_or_hold_their_like_are_looked_into_as_others() -> None:
    assert invalid_field(Vector3(1e308, 1e308)) is None  # each is finite, their sum is not
    end = Chain(None, 1.0)  # type: ignore[arg-type]
    assert invalid_field(Chain(end, nan)) == "next.next must be a Chain, not None"


def test_arrays_are_not_looked_into() -> None:
    @dataclass
    class Scan:
        ranges: np.ndarray = field(default_factory=lambda: np.array([inf]))

    assert invalid_field(Scan()) is None


@pytest.mark.parametrize(
    ("wanting", "wrong"),
    [
        (Float64([1.0]), r"data must be a number, not \[1.0\]"),
        (GetModelStateRequest(["arm"]), r"model_name must be a text, not \['arm'\]"),
        (SetModelConfigurationRequest("arm", joint_names=5), "joint_names must be a list, not 5"),
        (Float64(10**400), "data is 1000"),
    ],
)
def test_lists_for_values_values_for_lists_and_huge_numbers_are_reported(wanting: object, wrong: str) -> None:
    assert re.match(wrong, invalid_field(wanting) or "")
