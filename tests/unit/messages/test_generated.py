"""Message types that are made from ROS's definitions, and images as arrays."""

from __future__ import annotations

import pickle
from types import ModuleType

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from nrp_core.dsl.loading import file_scope
from nrp_core.dsl.messages import message_packages, message_type
from nrp_core.dsl.testing import MockWorld
from nrp_core.errors import TopicError
from nrp_core.messages.base import invalid_field
from nrp_core.messages.cdr import Codec
from nrp_core.messages.cv_bridge import CvBridge, CvBridgeError
from nrp_core.messages.generated import PACKAGES, names
from nrp_core.messages.std_msgs import Header

CODEC = Codec()
EVERY = [(package, name) for package in PACKAGES for name in names(package)]


def kind(package: str, name: str) -> type:
    return getattr(message_packages()[package].msg, name)


def test_the_message_packages_of_common_robots_are_included():
    assert len(EVERY) > 110
    for package, name in (
        ("sensor_msgs", "PointCloud2"), ("trajectory_msgs", "JointTrajectory"), ("tf2_msgs", "TFMessage"),
        ("geometry_msgs", "PoseStamped"), ("nav_msgs", "Path"), ("std_msgs", "UInt8MultiArray"),
        ("geometry_msgs", "TransformStamped"), ("sensor_msgs", "JointState"), ("nav_msgs", "OccupancyGrid"),
    ):  # fmt: skip
        assert (package, name) in EVERY


@pytest.mark.parametrize(("package", "name"), EVERY)
def test_every_type_is_made_of_nothing_is_valid_and_survives_encoding(package, name):
    message = kind(package, name)()
    assert invalid_field(message) is None
    codec = CODEC
    data = codec.encode(message)
    decoded = codec.decode(data, codec.name(type(message)))
    assert isinstance(decoded, type(message))
    assert codec.encode(decoded) == data


def test_types_are_made_once_and_hold_our_own():
    assert kind("sensor_msgs", "PointCloud2") is kind("sensor_msgs", "PointCloud2")
    assert isinstance(kind("sensor_msgs", "PointCloud2")().header, Header)
    assert message_type("sensor_msgs/PointCloud2") is kind("sensor_msgs", "PointCloud2")


def test_they_take_values_by_position_and_by_name_and_know_their_constants():
    point = kind("trajectory_msgs", "JointTrajectoryPoint")(np.ones(2), velocities=np.zeros(2))
    assert point.positions.tolist() == [1.0, 1.0]
    assert kind("sensor_msgs", "PointField").FLOAT32 == 7
    assert kind("geometry_msgs", "PoseWithCovarianceStamped")().pose.covariance == (0.0,) * 36
    assert kind("sensor_msgs", "MagneticField")().magnetic_field_covariance.shape == (9,)


def test_times_and_spans_have_the_package_of_ros_2():
    assert kind("builtin_interfaces", "Duration")(1, 500_000_000).nanosec == 500_000_000
    assert message_type("builtin_interfaces/Time") is type(Header().stamp)


def test_a_type_that_ros_does_not_have_is_refused_with_a_hint(golden: Golden):
    with golden.raises(AttributeError, match="'PointCloud2'"):
        kind("sensor_msgs", "PointClout2")
    with pytest.raises(TopicError, match="sensor_msgs/PointCloud3"):
        message_type("sensor_msgs/PointCloud3")


def test_files_import_messages_services_and_the_bridge(tmp_path):
    file = tmp_path / "file.py"
    file.write_text(
        "from sensor_msgs.msg import PointCloud2, Image\n"
        "import trajectory_msgs.msg\n"
        "from gazebo_msgs.srv import SetModelState, SetModelStateRequest\n"
        "from std_srvs.srv import Empty\n"
        "from cv_bridge import CvBridge\n"
        "made = PointCloud2(), trajectory_msgs.msg.JointTrajectory(), SetModelState.Request()\n"
        "more = Empty.Request(), CvBridge(), Image()\n"
        "same = SetModelState.Request is SetModelStateRequest\n"
    )
    assert file_scope(ModuleType("framework")).run(file).same is True


def test_they_are_topics_like_any_other():
    world = MockWorld()
    world.declare("/cloud", kind("sensor_msgs", "PointCloud2"))
    heard = world.subscribe("/cloud")
    world.advertise("/cloud").publish(kind("sensor_msgs", "PointCloud2")(width=3))
    assert heard.latest is not None
    assert heard.latest.message.width == 3


SHAPES = st.tuples(st.integers(1, 5), st.integers(1, 5))


@given(arrays.arrays(np.uint8, st.tuples(st.integers(1, 5), st.integers(1, 5), st.just(3))))
def test_colours_come_back_through_any_order_of_channels(image):
    bridge = CvBridge()
    message = bridge.cv2_to_imgmsg(image, "bgr8")
    assert np.array_equal(bridge.imgmsg_to_cv2(message), image)
    assert np.array_equal(bridge.imgmsg_to_cv2(message, "rgb8"), image[..., ::-1])


@given(SHAPES.flatmap(lambda shape: arrays.arrays(np.float32, shape, elements=st.floats(0, 9, width=32))))
def test_depth_comes_back(depth):
    message = CvBridge().cv2_to_imgmsg(depth)
    assert (message.encoding, message.step) == ("32FC1", 4 * depth.shape[1])
    assert np.array_equal(CvBridge().imgmsg_to_cv2(message, "32FC1"), depth)


def test_an_unknown_encoding_is_refused(golden: Golden):
    with golden.raises(CvBridgeError, match="'rgb9'"):
        CvBridge().cv2_to_imgmsg(np.zeros((2, 2, 3), np.uint8), "rgb9")
    with golden.raises(CvBridgeError, match="'32FC1'.*'bgr8'"):
        CvBridge().imgmsg_to_cv2(CvBridge().cv2_to_imgmsg(np.zeros((2, 2), np.float32)), "bgr8")


def test_images_travel_as_files():
    image = np.zeros((8, 8, 3), np.uint8)
    image[:, 4:] = (0, 0, 255)
    bridge = CvBridge()
    back = bridge.compressed_imgmsg_to_cv2(bridge.cv2_to_compressed_imgmsg(image, "png"))
    assert np.array_equal(back, image)


def test_messages_can_be_pickled_as_in_snapshots() -> None:
    fix = kind("sensor_msgs", "NavSatFix")(latitude=1.5)
    again = pickle.loads(pickle.dumps(fix))
    assert type(again) is type(fix)
    assert again.latitude == 1.5
    assert again.status == fix.status
