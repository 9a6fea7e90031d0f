"""ROS 2: what another participant of DDS, with types and an encoding of its own, says and hears."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_core.errors import BackendLoadError, SimulationError, TopicError
from nrp_core.world.messages import geometry_msgs, sensor_msgs
from nrp_core.world.messages.base import Time
from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.generated import PACKAGES, names
from nrp_core.world.messages.std_msgs import Header

from conftest import Ros2, needs_ros2
from nrp_world_ros.joining import join
from nrp_world_ros.node import Node
from nrp_world_ros.options import Ros
from nrp_world_ros.ros2.network import configuration, domain_number, on_this_machine_only
from nrp_world_ros.ros2.types import DdsTypes, dds_name, dds_topic

PEER = Path(__file__).with_name("ros2_peer.py")
RUN = (sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--json")
SOON = ("-s", "events.left_red.at=1 s", "--until", "4 s")


@pytest.fixture
def node(ros2: Ros2) -> Iterator[Node]:
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        yield node


def peer(ros2: Ros2, what: str) -> subprocess.Popen[str]:
    process = ros2.start(sys.executable, str(PEER), str(ros2.domain), what)
    assert process.stdout is not None
    assert process.stdout.readline().strip() == "ready"
    return process


def heard(node: Node, topic: str, timeout_s: float = 60.0) -> Any:
    assert node.inbox.wait(lambda: node.inbox.last(topic) is not None, timeout_s, node.check)
    (*_, letter) = (each for each in node.inbox.take() if each.topic == topic)
    return letter.message


# -- names, types and bytes


def test_topics_and_types_have_the_names_that_ros_2_gives_them_in_dds() -> None:
    assert dds_topic("/husky/cmd_vel") == "rt/husky/cmd_vel"
    assert dds_name("geometry_msgs/msg/Twist") == "geometry_msgs::msg::dds_::Twist_"


def test_types_have_the_hashes_by_which_ros_2_knows_them() -> None:
    expected = "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"  # by ROS 2 Jazzy
    assert Codec().hash("geometry_msgs/msg/Twist") == expected


@needs_ros2
@pytest.mark.parametrize("package", PACKAGES)
def test_dds_takes_every_type_of_ros(package: str) -> None:
    types = DdsTypes(Codec())
    for name in names(package):
        struct = types.type(f"{package}/msg/{name}")
        struct.__idl__.fill_type_data()
        assert struct.__idl__.keyless


@needs_ros2
@given(
    st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9), max_size=5),
    st.lists(st.floats(allow_nan=False), max_size=7),
    st.integers(0, 10**18),
)
def test_our_bytes_are_those_of_another_encoder(words: list[str], numbers: list[float], t_ns: int) -> None:
    import ros2_peer as theirs

    stamp = Time.from_ns(t_ns)
    ours = sensor_msgs.JointState(Header(stamp, "f"), words, np.array(numbers, float))
    same = theirs.JointState(
        theirs.Header(theirs.Time(stamp.sec, stamp.nanosec), "f"), words, numbers, [], []
    )
    assert bytes(Codec().encode(ours)) == same.serialize(use_version_2=False)


# -- with another participant


@needs_ros2
def test_a_message_sent_to_another_program_comes_back_from_it(ros2: Ros2, node: Node) -> None:
    other = peer(ros2, "echo")
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
def test_a_sensor_that_only_promises_its_best_effort_is_heard(ros2: Ros2, node: Node) -> None:
    peer(ros2, "driver")
    node.listen("/scan", sensor_msgs.LaserScan)
    ros2.until(lambda: node.settle(10) == set())
    scan = heard(node, "/scan")
    assert scan.ranges.tolist() == [1.0, 2.0, 3.0]
    assert scan.header.frame_id == "laser"


@needs_ros2
def test_a_node_that_leaves_is_reported_at_once(ros2: Ros2, node: Node) -> None:
    node.listen("/x", geometry_msgs.Twist)
    with join(Ros.TWO, "another", domain=ros2.domain) as another:
        another.publisher("/x", geometry_msgs.Twist)
        ros2.until(lambda: node.settle(10) == set())
        assert node.met() == ["/x"]
    ros2.until(lambda: node.peers("/x") == 0, timeout_s=8.0)  # before the lease of 10 s ends
    with pytest.raises(SimulationError, match="has left"):
        another.publisher("/y", geometry_msgs.Twist)


@needs_ros2
def test_a_listener_that_is_killed_holds_up_nobody_who_does_not_wait_for_it(ros2: Ros2) -> None:
    other = peer(ros2, "echo")
    large = sensor_msgs.JointState(position=np.zeros(100_000))
    with join(Ros.TWO, "under_test", queue=10, domain=ros2.domain) as node:
        there = node.publisher("/there", sensor_msgs.JointState)
        ros2.until(lambda: node.settle(10) == set())
        other.kill()
        other.wait()
        began_s = time.monotonic()
        for _ in range(50):
            there.publish(large)
        assert time.monotonic() - began_s < 30.0  # without a queue each waits for 10 s
        assert there.peers() == 1  # DDS does not know yet


@needs_ros2
def test_a_node_that_cannot_be_announced_leaves_no_thread(
    ros2: Ros2, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_arguments: object) -> None:
        raise RuntimeError("DDS is full")

    monkeypatch.setattr("nrp_world_ros.ros2.node.announce", fail)
    with pytest.raises(RuntimeError, match="DDS is full"):
        join(Ros.TWO, "under_test", domain=ros2.domain)
    assert "ros2" not in {thread.name for thread in threading.enumerate()}


@needs_ros2
def test_domains_do_not_hear_each_other(ros2: Ros2, node: Node) -> None:
    node.listen("/x", geometry_msgs.Twist)
    with join(Ros.TWO, "elsewhere", domain=ros2.domain - 100) as elsewhere:
        elsewhere.publisher("/x", geometry_msgs.Twist)
        assert node.settle(10) == {"/x"}
        assert elsewhere.settle(10) == {"/x"}


@needs_ros2
def test_a_message_that_dds_cannot_carry_is_refused_with_its_field(ros2: Ros2, node: Node) -> None:
    publisher = node.publisher("/x", geometry_msgs.Twist)
    with pytest.raises(TopicError, match=r"geometry_msgs/msg/Twist cannot be encoded"):
        publisher.publish(geometry_msgs.Twist("fast"))  # type: ignore[arg-type]
    with pytest.raises(TopicError, match="cannot be a topic of ROS 2"):
        node.publisher("/no good", geometry_msgs.Twist)


# -- the network


def test_ros_2s_variables_say_who_is_reached() -> None:
    assert domain_number(None, {}) == 0
    assert domain_number(None, {"ROS_DOMAIN_ID": "42"}) == 42
    assert domain_number(7, {"ROS_DOMAIN_ID": "42"}) == 7
    assert on_this_machine_only({})
    assert "127.0.0.1" in configuration({})
    wide = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": "10.0.0.1;robot"}
    assert not on_this_machine_only(wide)
    assert '<Peer address="10.0.0.1"/><Peer address="robot"/>' in configuration(wide)
    assert "127.0.0.1" not in configuration(wide)
    assert configuration({"CYCLONEDDS_URI": "file://mine.xml"}).endswith(",file://mine.xml")


@pytest.mark.parametrize("text", ["one", "233", "-1"])
def test_a_domain_that_dds_does_not_have_is_refused(text: str) -> None:
    with pytest.raises(BackendLoadError, match=f"from 0 to 232, not '{text}'"):
        domain_number(None, {"ROS_DOMAIN_ID": text})


def test_a_range_that_ros_2_does_not_have_is_refused_with_those_it_has() -> None:
    with pytest.raises(BackendLoadError, match=r"SUBNET.*did you mean"):
        on_this_machine_only({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNETS"})


# -- whole experiments


@needs_ros2
@pytest.mark.slow
def test_in_lockstep_a_run_through_ros_2_is_bit_for_bit_the_run_in_one_process(ros2: Ros2) -> None:
    ros2.body("--lockstep")
    apart, together = (
        json.loads(ros2.run(*RUN, *arguments, timeout_s=300))
        for arguments in (
            (*SOON, "--world", "ros", "-s", "world.options={ros: 2, time: lockstep}"),
            (*SOON, "-s", "world.options.image_scale=0.25"),
        )
    )
    assert apart["events"]  # a screen has turned red
    assert apart["trajectory_digest"] == together["trajectory_digest"]
    assert apart["spikes"] == together["spikes"]
    assert apart["events"] == together["events"]


@needs_ros2
@pytest.mark.slow
def test_by_the_clock_of_a_simulator_in_ros_2_the_robot_turns(ros2: Ros2) -> None:
    ros2.body("--pace", "realtime")
    found = json.loads(ros2.run(*RUN, "--world", "ros", "-s", "world.options.ros=2", "--until", "3s"))
    assert abs(found["final_pose"]["husky"]["yaw"] - math.pi) > 0.1


@needs_ros2
@pytest.mark.slow
def test_another_program_of_ros_2_sees_the_robot_and_drives_it(ros2: Ros2) -> None:
    ros2.body()
    said = ros2.run(sys.executable, str(PEER), str(ros2.domain), "drive")
    assert said.startswith("went half a metre")


def refused(ros2: Ros2) -> str:
    options = "world.options={ros: 2, time: lockstep, patience: 2 s}"
    process = ros2.nrp("run", "braitenberg_husky", "--world", "ros", "-s", options)
    said, _ = process.communicate(timeout=60)
    assert "Traceback" not in said
    assert process.returncode == 1
    (error,) = [line for line in said.splitlines() if line.startswith("error:")]
    return error


@needs_ros2
@pytest.mark.slow
def test_without_a_body_the_error_names_the_topics_and_the_tool_of_ros_2(ros2: Ros2) -> None:
    error = refused(ros2)
    assert "/husky/camera" in error
    assert "ros2 topic list" in error


@needs_ros2
@pytest.mark.slow
def test_a_body_that_goes_away_ends_the_loop_with_one_error(ros2: Ros2) -> None:
    body = ros2.body("--lockstep", "--until", "1s")
    error = refused(ros2)
    assert "the body has not answered on /nrp/done" in error
    assert body.wait(timeout=60) == 0
