"""ROS 2: what a node of its own client library, which knows nothing of the platform, says and hears."""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_core import load_experiment, open_world
from nrp_core.errors import BackendLoadError, SimulationError, TopicError
from nrp_core.messages import geometry_msgs, sensor_msgs
from nrp_core.messages.base import Time
from nrp_core.messages.cdr import Codec
from nrp_core.messages.generated import PACKAGES, names
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.std_msgs import Header
from nrp_core.world import Direction

from conftest import PEER, Ros2, needs_ros2
from nrp_world_ros.joining import join
from nrp_world_ros.node import Node, ros_type
from nrp_world_ros.options import Ros
from nrp_world_ros.ros2.node import discovery_range, domain_number
from nrp_world_ros.ros2.types import RosTypes

RUN = (sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--json")
SOON = ("-s", "events.left_red.at=1 s", "--until", "4 s")
FAST = geometry_msgs.Twist(geometry_msgs.Vector3(1.5, 0.0, -2.0))


@pytest.fixture
def node(ros2: Ros2) -> Iterator[Node]:
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        yield node


def heard(node: Node, topic: str, timeout_s: float = 60.0) -> Any:
    assert node.inbox.wait(lambda: node.inbox.last(topic) is not None, timeout_s, node.check)
    (*_, letter) = (each for each in node.inbox.take() if each.topic == topic)
    return letter.message


# -- types and bytes


def test_types_have_the_hashes_by_which_ros_2_knows_them() -> None:
    expected = "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"  # by ROS 2 Jazzy
    assert Codec().hash("geometry_msgs/msg/Twist") == expected


@pytest.mark.one_of(6)
@needs_ros2
@pytest.mark.parametrize("package", PACKAGES)
def test_types_of_the_platform_have_the_fields_of_ros(package: str) -> None:
    if find_spec(package) is None:
        pytest.skip(f"{package} is not in this ROS")
    types = RosTypes(Codec())
    for name in names(package):
        assert types.message(f"{package}/msg/{name}").__name__ == name


@needs_ros2
@given(
    st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9), max_size=5),
    st.lists(st.floats(allow_nan=False), max_size=7),
    st.integers(0, 10**18),
)
def test_our_bytes_are_those_of_ros(words: list[str], numbers: list[float], t_ns: int) -> None:
    from rclpy.serialization import deserialize_message, serialize_message

    codec, name = Codec(), "sensor_msgs/msg/JointState"
    ours = sensor_msgs.JointState(Header(Time.from_ns(t_ns), "f"), words, np.array(numbers, float))
    theirs = deserialize_message(bytes(codec.encode(ours)), RosTypes(codec).message(name))
    assert (theirs.name, list(theirs.position)) == (words, numbers)
    assert (theirs.header.stamp.sec, theirs.header.stamp.nanosec) == divmod(t_ns, 10**9)
    back = codec.decode(serialize_message(theirs), name)
    assert bytes(codec.encode(back)) == bytes(codec.encode(ours))


# -- with another node


@needs_ros2
def test_a_message_sent_to_another_program_comes_back_from_it(ros2: Ros2, node: Node) -> None:
    other = ros2.ready_peer("echo")
    there = node.publisher("/there", sensor_msgs.JointState)
    node.listen("/back", sensor_msgs.JointState)
    ros2.until(lambda: node.settle(10) == set())
    state = sensor_msgs.JointState(Header(Time(3, 4), "arm"), ["a", "bb"], np.array([0.5, -math.pi]))
    there.publish(state)
    back = heard(node, "/back")
    assert back.name == ["a", "bb"]
    assert back.position.tolist() == [0.5, -math.pi]
    assert back.header == state.header
    assert other.stdout is not None
    assert other.stdout.readline().strip() == f"['a', 'bb'] [0.5, {-math.pi}] arm"


@needs_ros2
def test_the_messages_of_a_best_effort_sensor_are_received(ros2: Ros2, node: Node) -> None:
    ros2.ready_peer("driver")
    node.listen("/scan", sensor_msgs.LaserScan)
    ros2.until(lambda: node.settle(10) == set())
    scan = heard(node, "/scan")
    assert scan.ranges.tolist() == [1.0, 2.0, 3.0]
    assert scan.header.frame_id == "laser"


@needs_ros2
def test_a_late_subscriber_receives_only_latched_messages(ros2: Ros2, node: Node) -> None:
    for topic, latched in (("/kept", True), ("/gone", False)):
        node.publisher(topic, geometry_msgs.Twist, latched=latched).publish(FAST)
    said, _ = ros2.peer("latched").communicate(timeout=60)
    assert said.split() == ["/kept", "1.5"]


@needs_ros2
@pytest.mark.slow
def test_images_and_fast_joints_reach_a_node_that_asks_as_for_sensors(ros2: Ros2) -> None:
    other = ros2.ready_peer("sensor")
    state = sensor_msgs.JointState(Header(), [f"joint_{i}" for i in range(12)], np.zeros(12))
    image = sensor_msgs.Image(Header(), 240, 320, "rgb8", False, 960, np.zeros((240, 320, 3), np.uint8))
    with join(Ros.TWO, "under_test", queue=10, domain=ros2.domain) as node:
        joints, camera = (
            node.publisher("/joints", sensor_msgs.JointState),
            node.publisher("/camera", sensor_msgs.Image),
        )
        ros2.until(lambda: node.settle(10) == set())
        began_s = time.monotonic()
        for step in range(3000):
            joints.publish(state)
            if step % 33 == 0:
                camera.publish(image)
            time.sleep(max(0.0, began_s + step * 1e-3 - time.monotonic()))
    said, _ = other.communicate(timeout=60)
    counts = json.loads(said)
    assert counts["/camera"] >= 60  # of 91; a busy machine loses some
    assert counts["/joints"] >= 2000  # of 3000


@needs_ros2
def test_a_node_that_leaves_is_reported_at_once(ros2: Ros2, node: Node) -> None:
    node.listen("/x", geometry_msgs.Twist)
    with join(Ros.TWO, "another", domain=ros2.domain) as another:
        another.publisher("/x", geometry_msgs.Twist)
        ros2.until(lambda: node.settle(10) == set())
        assert node.met() == ["/x"]
    ros2.until(lambda: node.peers("/x") == 0, timeout_s=8.0)  # before a dead one would be missed
    with pytest.raises(SimulationError, match="has left"):
        another.publisher("/y", geometry_msgs.Twist)
    with join(Ros.TWO, "another", domain=ros2.domain) as another:  # it is back
        again = another.publisher("/x", geometry_msgs.Twist)
        ros2.until(lambda: node.settle(10) == another.settle(10) == set())
        again.publish(FAST)
        assert heard(node, "/x") == FAST


@needs_ros2
def test_a_killed_listener_delays_no_program_that_does_not_wait_for_it(ros2: Ros2) -> None:
    other = ros2.ready_peer("echo")
    large = sensor_msgs.JointState(position=np.zeros(100_000))
    with join(Ros.TWO, "under_test", queue=10, domain=ros2.domain) as node:
        there = node.publisher("/there", sensor_msgs.JointState)
        ros2.until(lambda: node.settle(10) == set())
        other.kill()
        other.wait()
        for _ in range(50):
            there.publish(large)
        assert there.peers() == 1  # none waited until ROS noticed


@needs_ros2
def test_a_node_that_cannot_be_made_leaves_no_thread(ros2: Ros2) -> None:
    with pytest.raises(BackendLoadError, match="cannot join domain"):
        join(Ros.TWO, "no good name", domain=ros2.domain)
    assert "ros2" not in {thread.name for thread in threading.enumerate()}


@needs_ros2
def test_domains_do_not_hear_each_other(ros2: Ros2, node: Node) -> None:
    node.listen("/x", geometry_msgs.Twist)
    with join(Ros.TWO, "elsewhere", domain=ros2.domain + 101) as elsewhere:
        elsewhere.publisher("/x", geometry_msgs.Twist)
        assert node.settle(10) == {"/x"}
        assert elsewhere.settle(10) == {"/x"}


@needs_ros2
def test_a_message_that_ros_cannot_carry_is_refused_with_its_field(ros2: Ros2, node: Node) -> None:
    publisher = node.publisher("/x", geometry_msgs.Twist)
    with pytest.raises(TopicError, match="geometry_msgs/msg/Twist"):
        publisher.publish(geometry_msgs.Twist("fast"))  # type: ignore[arg-type]
    with pytest.raises(TopicError, match="topic of ROS 2"):
        node.publisher("/no good", geometry_msgs.Twist)


# -- the domain and its range


def test_the_number_of_the_domain_is_that_of_ros_2s_variable() -> None:
    assert domain_number(None, {}) == 0
    assert domain_number(None, {"ROS_DOMAIN_ID": "42"}) == 42
    assert domain_number(7, {"ROS_DOMAIN_ID": "42"}) == 7


@pytest.mark.parametrize("text", ["one", "233", "-1"])
def test_a_domain_that_ros_2_does_not_have_is_refused(text: str) -> None:
    with pytest.raises(BackendLoadError, match=f"232.*'{text}'"):
        domain_number(None, {"ROS_DOMAIN_ID": text})


def test_only_this_machine_is_reached_unless_ros_2s_variable_says_more() -> None:
    assert discovery_range({}) == "LOCALHOST"
    assert discovery_range({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}) == "SUBNET"
    with pytest.raises(BackendLoadError, match=r"SUBNET.*mean"):
        discovery_range({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNETS"})


# -- whole experiments


@needs_ros2
@pytest.mark.slow
def test_in_lockstep_a_run_through_ros_2_is_bit_for_bit_the_run_in_one_process(ros2: Ros2) -> None:
    ros2.body("--lockstep", "--stamped", "--bare-frames", "husky")
    apart, together = (
        json.loads(ros2.run(*RUN, *arguments, timeout_s=300))
        for arguments in (
            (*SOON, "--world", "ros", "-s", "world.options={ros: 2, time: lockstep, stamped: true}"),
            (*SOON, "-s", "world.options.image_scale=0.25"),
        )
    )
    assert apart["events"]  # a screen has turned red
    # the digest of the trajectory is also of joints, which do not pass through ROS here
    assert apart["final_pose"] == together["final_pose"]
    assert apart["spikes"] == together["spikes"]
    # this body stops at steps of the loop only, so an event has the time of the next one
    assert apart["events"] == pytest.approx(together["events"], abs=0.02)


@needs_ros2
def test_the_frames_of_one_robot_are_bare(ros2: Ros2) -> None:
    ros2.body("--bare-frames", "husky")
    with join(Ros.TWO, "listener", domain=ros2.domain) as node:
        node.listen("/tf", ros_type("tf2_msgs/msg/TFMessage"))
        node.listen("/husky/odom", Odometry)
        ros2.until(lambda: node.inbox.last("/tf") and node.inbox.last("/husky/odom"))
        odometry, tree = (node.inbox.last(topic).message for topic in ("/husky/odom", "/tf"))
    pairs = [(each.header.frame_id, each.child_frame_id) for each in tree.transforms]
    assert ("odom", "world") in pairs  # another program may say where odom is
    assert ("odom", odometry.child_frame_id) in pairs
    assert odometry.header.frame_id == "odom"
    assert not any("/" in name for pair in pairs for name in pair)
    said, _ = ros2.peer("description").communicate(timeout=60)
    assert '<link name="base_link"' in said


@pytest.mark.heavy
@needs_ros2
@pytest.mark.slow
def test_by_the_clock_of_a_simulator_in_ros_2_the_robot_turns(ros2: Ros2) -> None:
    ros2.body("--pace", "realtime")
    found = json.loads(ros2.run(*RUN, "--world", "ros", "-s", "world.options.ros=2", "--until", "3s"))
    assert abs(found["final_pose"]["husky"]["yaw"] - math.pi) > 0.1


COMMANDS = {
    "braitenberg_husky": 1,
    "reaching_arm": 2,
    "slalom_pioneer": 1,
    "following_head": 2,
    "walking_hexapod": 24,
    "fly": 43,
}
"""The number of drives and joints with commands."""


@pytest.mark.one_of(3)
@needs_ros2
@pytest.mark.slow
@pytest.mark.parametrize(
    "experiment",
    [
        *("braitenberg_husky", "reaching_arm"),
        *(pytest.param(name, marks=pytest.mark.heavy) for name in list(COMMANDS)[2:]),
    ],
)
def test_every_topic_of_a_robot_reaches_a_node_of_ros_2_and_every_command_moves_it(
    ros2: Ros2, experiment: str
) -> None:
    body = ros2.nrp("ros-bridge", experiment, "--without-brain", "--ros2")
    assert body.stdout is not None
    assert any(line.startswith("in ROS") for line in body.stdout)
    counts = json.loads(ros2.run(sys.executable, str(PEER), "topics", "6"))
    latched = {topic: n for topic, (_, n) in counts.items() if topic.endswith(("static", "description"))}
    assert len(latched) > 1
    assert set(latched.values()) == {1}
    with open_world(load_experiment(experiment)) as world:
        topics = {topic.name for topic in world.topics.values() if topic.direction is Direction.OUT}
    topics |= {"/clock", "/tf"}
    assert {topic for topic in topics if counts[topic][1] > 10} == topics
    moved = json.loads(ros2.run(sys.executable, str(PEER), "move", "8"))
    assert len(moved) == COMMANDS[experiment]
    assert {topic for topic, range_ in moved.items() if range_ < 0.05} == set()


@pytest.mark.heavy
@needs_ros2
@pytest.mark.slow
def test_a_node_can_take_its_time_from_the_simulation(ros2: Ros2) -> None:
    ros2.body("--pace", "realtime")
    said, _ = ros2.peer("times").communicate(timeout=90)
    first_ns, second_ns = map(int, said.split())
    assert first_ns < 60 * 10**9  # of the simulation, not of a calendar
    assert second_ns > first_ns + 10**8


def refused(ros2: Ros2, patience: str) -> str:
    options = f"world.options={{ros: 2, time: lockstep, patience: {patience}}}"
    process = ros2.nrp("run", "braitenberg_husky", "--world", "ros", "-s", options)
    said, _ = process.communicate(timeout=60)
    assert "Traceback" not in said
    assert process.returncode == 1
    (error,) = [line for line in said.splitlines() if line.startswith("error:")]
    return error


@needs_ros2
@pytest.mark.slow
def test_without_a_body_the_error_names_the_topics_and_the_tool_of_ros_2(ros2: Ros2) -> None:
    error = refused(ros2, "2 s")
    assert "/husky/camera" in error
    assert "ros2 topic list" in error


@needs_ros2
@pytest.mark.slow
def test_a_body_that_goes_away_ends_the_loop_with_one_error(ros2: Ros2) -> None:
    body = ros2.body("--lockstep", "--until", "1s")
    error = refused(ros2, "20 s")
    assert "the body has not answered on /nrp/done" in error
    assert body.wait(timeout=60) == 0
