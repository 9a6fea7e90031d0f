"""Which nodes of ROS 2 a node finds by default, and which it does not: other ranges, other machines."""

from __future__ import annotations

import sys
import time

import pytest
from nrp_core.messages import geometry_msgs, sensor_msgs

from conftest import PEER, Ros2, needs_networks, needs_ros2
from nrp_world_ros.bridge import Audience
from nrp_world_ros.joining import join
from nrp_world_ros.node import Node
from nrp_world_ros.options import Ros
from nrp_world_ros.ros2.node import reach

LONE_MACHINE = """set -e
ip link set lo up; ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo
unset ROS_AUTOMATIC_DISCOVERY_RANGE
"$1" "$2" say /from_afar & peer=$!
"$1" "$3" "$4"
kill $peer; wait $peer || true
"""

TWO_MACHINES = """set -e
ip link set lo up
unshare -n sleep 200 & other=$!
trap 'kill $other' EXIT
until [ "$(readlink /proc/$other/ns/net)" != "$(readlink /proc/$$/ns/net)" ]; do sleep 0.05; done
ip link add here type veth peer name there
ip link set there netns $other
ip addr add 10.9.9.1/24 dev here; ip link set here up; ip route add 224.0.0.0/4 dev here
nsenter -t $other -n sh -c 'ip link set lo up; ip addr add 10.9.9.2/24 dev there; ip link set there up
ip route add 224.0.0.0/4 dev there'
ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET nsenter -t $other -n "$1" "$2" say /from_afar & peer=$!
"$1" "$3" "$4"
kill $peer; wait $peer || true
"""

LISTENER = """import sys, time
from nrp_core.messages import geometry_msgs
from nrp_world_ros.joining import join
from nrp_world_ros.options import Ros
with join(Ros.TWO, "under_test") as node:
    node.listen("/from_afar", geometry_msgs.Twist)
    end_s = time.monotonic() + float(sys.argv[1])
    while time.monotonic() < end_s and not node.inbox.last("/from_afar"):
        time.sleep(0.05)
    print("peers:", node.peers("/from_afar"), "messages:", node.inbox.last("/from_afar") is not None)
"""


def listened(ros2: Ros2, machines: str, patience_s: str) -> str:
    """Return what a node hears of another in networks of their own, which lead nowhere."""
    listener = ros2.folder / "listener.py"
    listener.write_text(LISTENER)
    program = ("bash", "-c", machines, "test", sys.executable, str(PEER), str(listener), patience_s)
    return ros2.run("unshare", "-rn", *program, timeout_s=150.0)


@needs_ros2
@needs_networks
@pytest.mark.slow
def test_a_node_with_the_defaults_of_ros_2_is_found_on_this_machine(ros2: Ros2) -> None:
    del ros2.env["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    assert "peers: 1 messages: True" in listened(ros2, LONE_MACHINE, "60")


@pytest.mark.one_of(3)
@needs_ros2
@needs_networks
@pytest.mark.slow
@pytest.mark.parametrize(("reached", "peers"), [("LOCALHOST", 0), ("SUBNET", 1)])
def test_messages_of_another_machine_are_received_only_if_the_user_allows_it(
    ros2: Ros2, reached: str, peers: int
) -> None:
    if reached == "SUBNET":
        ros2.env["ROS_AUTOMATIC_DISCOVERY_RANGE"] = reached
    else:  # it is the default
        del ros2.env["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    assert f"peers: {peers} messages: {peers > 0}" in listened(ros2, TWO_MACHINES, "60" if peers else "5")


# -- reports that nobody is there


class Alone:
    """A node with or without company."""

    reach = "where it is"

    def __init__(self, *topics: str) -> None:
        self._topics = list(topics)

    def met(self) -> list[str]:
        return self._topics

    def unmatched(self) -> list[str]:
        return []


@pytest.mark.parametrize(("node", "reports"), [(Alone(), 1), (Alone("/x"), 0)])
def test_a_node_that_no_other_node_finds_warns_once(
    node: Node, reports: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    audience = Audience(node, said.append)
    audience.update()
    assert said == []
    now_s = time.monotonic() + 5.1
    monkeypatch.setattr("time.monotonic", lambda: now_s)
    audience.update()
    audience.update()
    assert said == ["no other node listens or publishes here after 5 s; where it is"] * reports


def test_the_report_says_what_would_reach_further() -> None:
    assert "domain 7, on this machine" in reach(7, {})
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET" in reach(7, {})
    assert "ROS_STATIC_PEERS" in reach(7, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"})
    assert "OFF" in reach(7, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"})


@needs_ros2
def test_a_node_with_other_messages_is_not_reported_as_absent(
    ros2: Ros2, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr("nrp_world_ros.bridge._PATIENCE_S", 0.0)
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        node.publisher("/heard", geometry_msgs.Twist)
        with join(Ros.TWO, "another", domain=ros2.domain) as another:
            another.listen("/heard", sensor_msgs.Image)
            ros2.until(node.unmatched)
            Audience(node, said.append).update()
        assert node.met() == []
        ros2.until(lambda: not node.unmatched())
    assert said[0].startswith("no node can be connected to /heard")


@pytest.mark.heavy
@needs_ros2
@pytest.mark.slow
def test_a_bridge_that_no_node_finds_warns_while_it_runs(ros2: Ros2) -> None:
    body = ros2.body()
    assert body.stdout is not None
    (line,) = [line for line in (body.stdout.readline(),) if line.startswith("warning:")]
    assert "no other node listens" in line
    assert f"domain {ros2.domain}" in line
