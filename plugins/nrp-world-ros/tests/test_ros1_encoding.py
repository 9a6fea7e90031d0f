"""The encoding of ROS 1: its check sums are those that ROS publishes, its bytes those of a ROS library."""

from __future__ import annotations

from hashlib import md5
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_core.errors import TopicError
from nrp_core.messages import geometry_msgs, nav_msgs, sensor_msgs, std_msgs
from nrp_core.messages.base import Time, type_name
from nrp_core.messages.cdr import Codec
from nrp_core.messages.cle_ros_msgs import SpikeRate
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.generated import made
from rosbags.typesys import Stores, get_typestore

from nrp_world_ros.ros1_encoding import Ros1Codec

HEADER = std_msgs.Header(Time(12, 34), "husky/base_link")

# from the headers of ROS's own message packages
MD5 = [
    (geometry_msgs.Twist, "9f195f881246fdfa2798d1d3eebca84a"),
    (std_msgs.Header, "2176decaecbce78abc3b96ef049fabed"),
    (sensor_msgs.Image, "060021388200f6f0f447d0fcd9c64743"),
    (sensor_msgs.CameraInfo, "c9a58c1b0b154e0e6da7578cb991d214"),
    (sensor_msgs.Range, "c005c34273dc426c67a020a87bc24148"),
    (sensor_msgs.JointState, "3066dcd76a6cfaef579bd0f34173e9fd"),
    (nav_msgs.Odometry, "cd5e73d190d741a2f92e81eda573aca7"),
    (std_msgs.Empty, "d41d8cd98f00b204e9800998ecf8427e"),
    (ModelStates, "48c080191eb15c41858319b4d8a609c2"),
]


@pytest.mark.parametrize(("cls", "checksum"), MD5, ids=lambda value: getattr(value, "__name__", ""))
def test_the_check_sum_of_a_type_is_that_of_ros(cls: type, checksum: str) -> None:
    codec = Ros1Codec()
    assert codec.md5(codec.name(cls)) == checksum


def test_monitors_keep_the_names_and_the_check_sum_of_ros_1() -> None:
    codec, rate = Ros1Codec(), SpikeRate(0.5, 20.0, "rates")
    name = codec.name(SpikeRate)
    text = "float64 simulationTime\nfloat64 rate\nstring monitorName"
    assert codec.md5(name) == md5(text.encode()).hexdigest()
    assert codec.decode(codec.encode(rate), name) == rate


MESSAGES: list[Any] = [
    geometry_msgs.Twist(geometry_msgs.Vector3(1, 2, 3), geometry_msgs.Vector3(0, 0, -1)),
    std_msgs.String("Gazebo/RedGlow"),
    std_msgs.Empty(),
    HEADER,
    nav_msgs.Odometry(HEADER, "husky/base_link"),
    sensor_msgs.JointState(HEADER, ["a", "b"], [1.0, 2.0], [0.5, 0.25], []),
    sensor_msgs.Image(HEADER, 2, 3, "rgb8", 0, 9, np.arange(18, dtype=np.uint8).reshape(2, 3, 3)),
    ModelStates(["husky"], [geometry_msgs.Pose()], [geometry_msgs.Twist()]),
]


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_encoding_and_decoding_a_message_gives_an_equal_one_of_the_same_class(message: Any) -> None:
    codec = Ros1Codec()
    data = codec.encode(message)
    decoded = codec.decode(data, codec.name(type(message)))
    assert isinstance(decoded, type(message))
    assert codec.encode(decoded) == data
    assert Codec().encode(decoded) == Codec().encode(message)


def test_the_optics_of_a_camera_keep_their_values_under_the_names_of_ros_1() -> None:
    codec = Ros1Codec()
    info = sensor_msgs.CameraInfo(HEADER, 240, 320, k=np.arange(9.0), p=np.arange(12.0))
    theirs: Any = get_typestore(Stores.ROS1_NOETIC).deserialize_ros1(
        codec.encode(info), type_name(type(info))
    )
    assert theirs.header.frame_id == "husky/base_link"
    assert theirs.K.tolist() == list(range(9))
    assert theirs.P.tolist() == list(range(12))
    decoded = codec.decode(codec.encode(info), type_name(type(info)))
    assert isinstance(decoded, sensor_msgs.CameraInfo)
    assert decoded.k.tolist() == list(range(9))


def test_a_range_has_no_variance_in_ros_1() -> None:
    codec = Ros1Codec()
    sent = sensor_msgs.Range(HEADER, 1, 0.5, 0.125, 2.0, 0.75, variance=3.0)
    received = codec.decode(codec.encode(sent), type_name(sensor_msgs.Range))
    assert received == sensor_msgs.Range(HEADER, 1, 0.5, 0.125, 2.0, 0.75)


def test_a_type_that_ros_1_has_otherwise_is_refused(golden: Golden) -> None:
    marker = made("visualization_msgs/msg/Marker")
    assert marker is not None
    with golden.raises(TopicError):
        Ros1Codec().encode(marker())
