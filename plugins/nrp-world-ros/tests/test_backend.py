"""What can be told without ROS."""

from __future__ import annotations

import sys
from math import pi

import pytest
from nrp_core.errors import BackendLoadError
from nrp_core.experiment.find import load_experiment
from nrp_core.experiment.making import Maker
from nrp_core.world.messages import geometry_msgs as geo
from nrp_core.world.messages.gazebo_msgs import ModelStates
from nrp_core.world.messages.nav_msgs import Odometry
from nrp_core.world.scene.model import Scene

from nrp_world_ros import RosBackend, RosOptions
from nrp_world_ros.backend import Ros, TimeSource
from nrp_world_ros.inbox import DEPTH, Inbox, Letter
from nrp_world_ros.ros1.wire import CODEC
from nrp_world_ros.whereabouts import Whereabouts

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


def test_without_either_ros_it_is_said_what_to_install(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rospy", None)
    monkeypatch.setitem(sys.modules, "cyclonedds.domain", None)
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


def test_before_anything_is_told_models_are_where_the_files_have_them(scene: Scene) -> None:
    assert Whereabouts(scene).motion("husky").pose == scene.model("husky").pose


def test_odometry_begins_where_the_robot_did_and_its_speed_is_the_bodys(scene: Scene) -> None:
    where = Whereabouts(scene)
    moved = geo.Pose(geo.Point(2.0, 0.5, 0.0), HALF_TURN)
    twist = geo.Twist(geo.Vector3(1.0, 0.0, 0.0), geo.Vector3(0.0, 0.0, 0.5))
    message = Odometry(pose=geo.PoseWithCovariance(moved), twist=geo.TwistWithCovariance(twist))
    where.take("/husky/odom", message)
    motion, home = where.motion("husky"), scene.model("husky").pose  # which faces the other way
    assert motion.pose.position[:2] == pytest.approx((-2.0, -0.5), abs=1e-6)
    assert motion.linear == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)
    assert motion.angular[2] == pytest.approx(0.5)
    assert home.position[:2] == (0.0, 0.0)


def test_what_a_simulator_tells_counts_more_than_odometry(scene: Scene) -> None:
    where = Whereabouts(scene)
    told = ModelStates(
        ["husky", "stranger"], [geo.Pose(geo.Point(1, 2, 3)), geo.Pose()], [geo.Twist(), geo.Twist()]
    )
    where.take("/gazebo/model_states", told)
    where.take("/husky/odom", Odometry())
    assert where.motion("husky").pose.position == (1, 2, 3)
    with pytest.raises(KeyError):
        where.motion("stranger")


def letter(topic: str, value: float, sender: str = "/a") -> Letter:
    twist = geo.Twist(geo.Vector3(value, 0, pi))
    return Letter(topic, CODEC.name(geo.Twist), bytes(CODEC.encode(twist)), sender, CODEC)


def test_what_waits_is_taken_once_in_its_order() -> None:
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
