"""A participant of DDS that knows nothing of the platform: types written by hand, the encoding of Cyclone.

python ros2_peer.py DOMAIN echo      what comes on /there goes back on /back, as a line and on the topic
python ros2_peer.py DOMAIN driver    /scan is published as drivers do: with their best effort only
python ros2_peer.py DOMAIN other_machine    /from_afar is published on the network, as another machine does
python ros2_peer.py DOMAIN call N       /switch is called three times as rmw_cyclonedds does, with N letters
python ros2_peer.py DOMAIN drive     /husky/cmd_vel says 1 m/s until /husky/odom is half a metre further
"""

import ctypes
import sys
import time
from dataclasses import dataclass
from typing import Any

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int32, int64, sequence, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

LOOPBACK = """<CycloneDDS><Domain Id="any"><General>
<Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""

DEFAULTS = ""


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3
    angular: Vector3


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@dataclass
class LaserScan(IdlStruct, typename="sensor_msgs::msg::dds_::LaserScan_"):
    header: Header
    angle_min: float32
    angle_max: float32
    angle_increment: float32
    time_increment: float32
    scan_time: float32
    range_min: float32
    range_max: float32
    ranges: sequence[float32]
    intensities: sequence[float32]


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point
    orientation: Quaternion


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: Pose
    covariance: array[float64, 36]


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist
    covariance: array[float64, 36]


@dataclass
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
class Call(IdlStruct, typename="test::srv::dds_::Echo_Request_"):
    client: uint64
    number: int64
    letters: str


@dataclass
class Reply(IdlStruct, typename="test::srv::dds_::Echo_Response_"):
    client: uint64
    number: int64
    letters: str


RELIABLE = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(10))
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))


def be_deaf(domain: Domain, deaf: bool) -> None:
    """Hear of no other participant: one that comes while types are described can end this process."""
    number, switch = ctypes.c_int32, ctypes.c_bool
    change = domain._dll_handle.dds_domain_set_deafmute
    change.argtypes = [number, switch, switch, ctypes.c_int64]
    change(domain._ref, deaf, False, (1 << 63) - 1 if deaf else 0)


class Peer:
    """A participant that is deaf until its topics exist."""

    def __init__(self, domain: int, network: str = LOOPBACK) -> None:
        self.domain = Domain(domain, network)
        be_deaf(self.domain, True)
        self.participant = DomainParticipant(domain)

    def begin(self) -> None:
        """Meet the others."""
        be_deaf(self.domain, False)

    def writer(self, topic: str, cls: type, qos: Qos = RELIABLE, kind: str = "rt") -> DataWriter[Any]:
        return DataWriter(self.participant, Topic(self.participant, kind + topic, cls), qos=qos)

    def reader(self, topic: str, cls: type, qos: Qos = RELIABLE, kind: str = "rt") -> DataReader[Any]:
        return DataReader(self.participant, Topic(self.participant, kind + topic, cls), qos=qos)


def echo(peer: Peer) -> None:
    reader, writer = peer.reader("/there", JointState), peer.writer("/back", JointState)
    peer.begin()
    print("ready", flush=True)
    for state in reader.take_iter(timeout=20 * 10**9):
        print(state.name, state.position, state.header.frame_id, flush=True)
        writer.write(state)


def driver(peer: Peer) -> None:
    writer = peer.writer("/scan", LaserScan, BEST_EFFORT)
    peer.begin()
    print("ready", flush=True)
    stamp = Header(Time(1, 2), "laser")
    while True:
        writer.write(LaserScan(stamp, -1.0, 1.0, 0.5, 0.0, 0.1, 0.1, 10.0, [1.0, 2.0, 3.0], []))
        time.sleep(0.05)


def call(peer: Peer) -> None:
    replies, calls = peer.reader("/echoReply", Reply, kind="rr"), peer.writer("/echoRequest", Call, kind="rq")
    peer.begin()
    while not (
        calls.get_publication_matched_status().current_count
        and replies.get_subscription_matched_status().current_count
    ):
        time.sleep(0.01)
    for number in range(3):
        calls.write(Call(2**63 + 1, number, "abc"[number] * int(sys.argv[3])))
        reply = next(replies.take_iter(timeout=20 * 10**9))
        print(reply.client - 2**63, reply.number, len(reply.letters), reply.letters[:1], flush=True)


def other_machine(peer: Peer) -> None:
    writer = peer.writer("/from_afar", JointState)
    assert writer
    peer.begin()
    time.sleep(200)


def drive(peer: Peer) -> None:
    odometry, commands = (
        peer.reader("/husky/odom", Odometry, BEST_EFFORT),
        peer.writer("/husky/cmd_vel", Twist),
    )
    peer.begin()
    began = None
    for seen in odometry.take_iter(timeout=20 * 10**9):
        x = seen.pose.pose.position.x
        began = x if began is None else began
        if x > began + 0.5:
            print("went half a metre", seen.child_frame_id, flush=True)
            return
        commands.write(Twist(Vector3(1.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.0)))


if __name__ == "__main__":
    known = (echo, driver, drive, other_machine, call)
    what = {each.__name__: each for each in known}[sys.argv[2]]
    what(Peer(int(sys.argv[1]), DEFAULTS if what is other_machine else LOOPBACK))
