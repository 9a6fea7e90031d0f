"""Which programs of DDS a node finds by default, and which it does not: other vendors, other machines."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from nrp_core.world.messages import geometry_msgs
from nrp_core.world.messages.cdr import Codec

from conftest import Ros2, needs_fast_dds, needs_networks, needs_ros2
from nrp_world_ros.audience import Audience
from nrp_world_ros.joining import join
from nrp_world_ros.node import Node
from nrp_world_ros.options import Ros
from nrp_world_ros.ros2.network import reach

PEER = Path(__file__).with_name("ros2_peer.py")
TWIST = "geometry_msgs::msg::dds_::Twist_"
FAST = geometry_msgs.Twist(geometry_msgs.Vector3(1.5, 0.0, -2.0))


@pytest.fixture
def node(ros2: Ros2) -> Iterator[Node]:
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        yield node


def data() -> str:
    return bytes(Codec().encode(FAST)).hex()


@needs_ros2
@needs_fast_dds
def test_a_program_with_the_defaults_of_fast_dds_hears_a_node(ros2: Ros2, node: Node, fast_dds: str) -> None:
    there = node.publisher("/there", geometry_msgs.Twist)
    other = ros2.start(fast_dds, str(ros2.domain), "hear", "rt/there", TWIST)
    ros2.until(lambda: there.peers() == 1, timeout_s=60.0)
    there.publish(FAST)
    said, _ = other.communicate(timeout=60)
    assert said.split() == ["ready", data()]


@needs_ros2
@needs_fast_dds
def test_a_node_hears_a_program_with_the_defaults_of_fast_dds(ros2: Ros2, node: Node, fast_dds: str) -> None:
    node.listen("/here", geometry_msgs.Twist)
    ros2.start(fast_dds, str(ros2.domain), "say", "rt/here", TWIST, data())
    assert node.inbox.wait(lambda: node.inbox.last("/here") is not None, 60.0, node.check)
    (letter,) = node.inbox.take()
    assert letter.message == FAST


@needs_ros2
@needs_fast_dds
def test_who_comes_late_gets_what_is_latched_and_nothing_else(ros2: Ros2, node: Node, fast_dds: str) -> None:
    for topic, latched in (("/kept", True), ("/gone", False)):
        node.publisher(topic, geometry_msgs.Twist, latched=latched).publish(FAST)
    late = {
        topic: ros2.start(fast_dds, str(ros2.domain), what, f"rt{topic}", TWIST)
        for topic, what in (("/kept", "latched"), ("/gone", "hear"))
    }
    assert late["/kept"].communicate(timeout=60)[0].split() == ["ready", data()]
    assert late["/gone"].communicate(timeout=60)[0].split() == ["ready", "nothing"]


TWO_MACHINES = """set -e
ip link set lo up
unshare -n sleep 200 & other=$!
trap 'kill $other' EXIT
until [ "$(readlink /proc/$other/ns/net)" != "$(readlink /proc/$$/ns/net)" ]; do sleep 0.05; done
ip link add here type veth peer name there
ip link set there netns $other
ip addr add 10.9.9.1/24 dev here; ip link set here up
nsenter -t $other -n sh -c 'ip link set lo up; ip addr add 10.9.9.2/24 dev there; ip link set there up'
nsenter -t $other -n "$1" "$2" "$3" other_machine & peer=$!
"$1" "$4" "$3" "$5"
kill $peer; wait $peer || true
"""

LISTENER = """import sys, time
from nrp_core.world.messages import sensor_msgs
from nrp_world_ros.joining import join
from nrp_world_ros.options import Ros
with join(Ros.TWO, "under_test", domain=int(sys.argv[1])) as node:
    node.listen("/from_afar", sensor_msgs.JointState)
    end_s = time.monotonic() + float(sys.argv[2])
    while time.monotonic() < end_s and not node.peers("/from_afar"):
        time.sleep(0.05)
    print("peers:", node.peers("/from_afar"))
"""


@needs_ros2
@needs_networks
@pytest.mark.slow
@pytest.mark.parametrize(("reached", "peers"), [("LOCALHOST", 0), ("SUBNET", 1)])
def test_another_machine_is_heard_only_if_the_user_says_so(ros2: Ros2, reached: str, peers: int) -> None:
    listener = ros2.folder / "listener.py"
    listener.write_text(LISTENER)
    if reached == "SUBNET":  # the other case is the default
        ros2.env["ROS_AUTOMATIC_DISCOVERY_RANGE"] = reached
    program = ("bash", "-c", TWO_MACHINES, "test", sys.executable, str(PEER), str(ros2.domain), str(listener))
    patience_s = "60" if peers else "5"
    said = ros2.run("unshare", "-rn", *program, patience_s, timeout_s=150.0)
    assert f"peers: {peers}" in said


# -- reports that nobody is there


class Alone:
    """A node with or without company."""

    reach = "where it is"

    def __init__(self, *topics: str) -> None:
        self._topics = list(topics)

    def met(self) -> list[str]:
        return self._topics


@pytest.mark.parametrize(("node", "reports"), [(Alone(), 1), (Alone("/x"), 0)])
def test_a_node_that_nobody_finds_says_so_once(
    node: Node, reports: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    audience = Audience(node, said.append)
    audience.look()
    assert said == []
    now_s = time.monotonic() + 5.1
    monkeypatch.setattr("time.monotonic", lambda: now_s)
    audience.look()
    audience.look()
    assert said == ["no other node listens or publishes here after 5 s; where it is"] * reports


def test_the_report_says_what_would_reach_further() -> None:
    assert "domain 7, on this machine" in reach(7, {})
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET" in reach(7, {})
    assert "ROS_STATIC_PEERS" in reach(7, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"})
    assert "networks of CYCLONEDDS_URI" in reach(7, {"CYCLONEDDS_URI": "file://mine.xml"})


@needs_ros2
@pytest.mark.slow
def test_a_bridge_that_nobody_finds_says_so_while_it_runs(ros2: Ros2) -> None:
    body = ros2.body()
    assert body.stdout is not None
    (line,) = [line for line in (body.stdout.readline(),) if line.startswith("warning:")]
    assert "no other node listens" in line
    assert f"domain {ros2.domain}" in line
