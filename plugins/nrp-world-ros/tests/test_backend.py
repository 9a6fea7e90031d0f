"""Tests of the backend without ROS."""

from __future__ import annotations

import sys
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_core import load_experiment
from nrp_core.errors import BackendLoadError
from nrp_core.experiment.making.maker import Maker
from nrp_core.messages import geometry_msgs as geo
from nrp_core.messages.cdr import Codec
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.sensor_msgs import Image
from nrp_core.world import Scene
from pydantic import ValidationError

from nrp_world_ros import RosBackend, RosOptions
from nrp_world_ros.engine import ModelPoses, shaped
from nrp_world_ros.node import DEPTH, Inbox, Letter
from nrp_world_ros.options import Ros, TimeSource
from nrp_world_ros.ros1 import CODEC
from nrp_world_ros.timekeeping import Sent, Turn

HALF_TURN = geo.Quaternion(0, 0, 1, 0)


@pytest.fixture(scope="module")
def scene() -> Scene:
    experiment = load_experiment("braitenberg_husky")
    robot = Maker().robot(experiment, "husky")
    return Maker().room(experiment).with_model(robot)


@pytest.mark.parametrize("time", list(TimeSource))
def test_a_body_that_does_not_wait_is_declared_as_real_time(time: TimeSource) -> None:
    declared = RosBackend().capabilities(RosOptions(time=time))
    assert declared.real_time == (time is not TimeSource.LOCKSTEP)
    assert declared.step_ns == 1_000_000


def test_without_any_ros_the_packages_to_install_are_named(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rospy", None)
    monkeypatch.setitem(sys.modules, "rclpy", None)
    one, two = RosBackend().diagnose()
    assert (one.present, two.present) == (False, False)
    assert (one.needed, two.needed) == (True, True)
    assert "apt-get install" in one.remedy
    assert "nrp-world-ros[ros2]" in two.remedy
    with pytest.raises(BackendLoadError, match="apt-get install"):
        RosBackend().open(scene, seed=1, options=RosOptions())
    with pytest.raises(BackendLoadError, match=r"nrp-world-ros\[ros2\]"):
        RosBackend().open(scene, seed=1, options=RosOptions(ros=Ros.TWO))


def test_only_ros_2_has_domains() -> None:
    with pytest.raises(ValueError, match="ros: 2"):
        RosOptions(domain=7)
    assert RosOptions(ros=Ros.TWO, domain=7).domain == 7


@pytest.mark.parametrize(
    ("options", "wrong"),
    [
        ({"body": "mujocco"}, "'mujoco'"),
        ({"body": "mujoco", "body_options": {"image_skale": 1}}, "'image_skale'.*'mujoco'"),
        ({"body": "mujoco", "time": "clock"}, "ROS 2 in lockstep"),
        ({"body": "mujoco", "ros": 1}, "ROS 2 in lockstep"),
        ({"body": "mujoco", "timestep": "1 ms"}, "'body_options'"),
        ({"body": "ros"}, "runs in real time"),
        ({"body_options": {"image_scale": 1}}, "add 'body'"),
    ],
)
def test_a_body_that_cannot_be_is_refused_before_anything_is_started(
    options: dict[str, Any], wrong: str
) -> None:
    with pytest.raises(ValidationError, match=wrong):
        RosOptions.model_validate(options)


def test_a_simulated_body_is_declared_as_its_simulator_declares_it() -> None:
    options = RosOptions(body="mujoco", body_options={"timestep": "1 ms"})
    declared = RosBackend().capabilities(options)
    assert (options.ros, options.time) == (Ros.TWO, TimeSource.LOCKSTEP)
    assert declared.step_ns == 1_000_000
    assert declared.snapshot
    assert declared.dynamics
    assert not declared.real_time


def test_before_any_command_models_are_where_the_files_have_them(scene: Scene) -> None:
    assert ModelPoses(scene).motion("husky").pose == scene.model("husky").pose


def test_odometry_begins_where_the_robot_did_and_its_speed_is_the_bodys(scene: Scene) -> None:
    where = ModelPoses(scene)
    moved = geo.Pose(geo.Point(2.0, 0.5, 0.0), HALF_TURN)
    twist = geo.Twist(geo.Vector3(1.0, 0.0, 0.0), geo.Vector3(0.0, 0.0, 0.5))
    message = Odometry(pose=geo.PoseWithCovariance(moved), twist=geo.TwistWithCovariance(twist))
    where.take("/husky/odom", message)
    motion, home = where.motion("husky"), scene.model("husky").pose  # which faces the other way
    assert motion.pose.position[:2] == pytest.approx((-2.0, -0.5), abs=1e-6)
    assert motion.linear == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)
    assert motion.angular[2] == pytest.approx(0.5)
    assert home.position[:2] == (0.0, 0.0)


def test_the_pose_from_a_simulator_has_priority_over_odometry(scene: Scene) -> None:
    where = ModelPoses(scene)
    message = ModelStates(
        ["husky", "stranger"], [geo.Pose(geo.Point(1, 2, 3)), geo.Pose()], [geo.Twist(), geo.Twist()]
    )
    where.take("/gazebo/model_states", message)
    where.take("/husky/odom", Odometry())
    assert where.motion("husky").pose.position == (1, 2, 3)
    with pytest.raises(KeyError):
        where.motion("stranger")


def test_an_image_of_ros_has_its_shape_without_what_fills_up_its_rows() -> None:
    row = [1, 2, 3, 4, 5, 6, 0, 0]
    padded = Image(height=2, width=2, encoding="rgb8", step=8, data=np.array(row * 2, np.uint8))
    image = shaped(padded)
    assert image.data.tolist() == [[[1, 2, 3], [4, 5, 6]]] * 2
    assert image.step == 6
    with pytest.raises(ValueError, match="read-only"):
        image.data[0, 0, 0] = 7
    depth = np.array([[0.5, 1.5]], np.float32)
    bits = Image(height=1, width=2, encoding="32FC1", step=8, data=depth.view(np.uint8).reshape(-1))
    assert shaped(bits).data.tolist() == depth.tolist()


@pytest.mark.parametrize(
    "message",
    [
        Image(height=1, width=1, encoding="yuv422", step=2, data=np.zeros(2, np.uint8)),
        Image(height=9, width=9, encoding="rgb8", step=27, data=np.zeros(2, np.uint8)),
        geo.Twist(),
    ],
)
def test_an_unknown_image_stays_unchanged(message: object) -> None:
    assert shaped(message) is message


@pytest.mark.parametrize("codec", [CODEC, Codec()], ids=["ros1", "ros2"])
@given(
    st.dictionaries(st.sampled_from(["/a", "/b", "/c"]), st.lists(st.integers(0, 2**62), max_size=5)),
    st.binary(max_size=9),
)
def test_the_record_of_a_turn_holds_the_messages_sent_in_it(codec: Codec, sent: Sent, note: bytes) -> None:
    message = codec.encode(Turn.ended(7, dict(sent), ["/a"], note))
    turn = codec.decode(message, "nrp_ros_msgs/msg/Turn")
    assert (turn.sent, turn.note.tobytes(), turn.time.to_ns()) == (sent, note, 7)


def letter(topic: str, value: float, sender: str = "/a") -> Letter:
    twist = geo.Twist(geo.Vector3(value, 0, pi))
    return Letter(topic, CODEC.name(geo.Twist), bytes(CODEC.encode(twist)), sender, CODEC)


def test_waiting_messages_are_taken_once_in_their_order() -> None:
    inbox = Inbox()
    for value in (1.0, 2.0, 3.0):
        inbox.add(letter("/a", value))
    assert [one.message.linear.x for one in inbox.take()] == [1.0, 2.0, 3.0]
    assert inbox.take() == []


def test_of_too_many_that_wait_the_oldest_are_lost() -> None:
    inbox = Inbox()
    for value in range(DEPTH + 3):
        inbox.add(letter("/a", value))
    taken = inbox.take()
    assert len(taken) == DEPTH
    assert taken[0].message.linear.x == 3.0


def test_only_what_the_other_side_sent_counts_as_come() -> None:
    inbox = Inbox()
    inbox.add(letter("/a", 1.0, sender="/stranger"))
    inbox.add(letter("/a", 2.0, sender="/body"))
    assert inbox.has("/body", {"/a": 1})
    assert not inbox.has("/body", {"/a": 2})
    assert not inbox.wait(lambda: inbox.has("/body", {"/a": 2}), 0.05, lambda: None)
