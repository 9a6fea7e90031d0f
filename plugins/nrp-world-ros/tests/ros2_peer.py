"""A participant of DDS that knows nothing of the platform: types written by hand, the encoding of Cyclone.

python ros2_peer.py DOMAIN echo      what comes on /there goes back on /back, as a line and on the topic
python ros2_peer.py DOMAIN driver    /scan is published as drivers do: with their best effort only
python ros2_peer.py DOMAIN drive     /husky/cmd_vel says 1 m/s until /husky/odom is half a metre further
"""

import sys
import time
from dataclasses import dataclass
from typing import Any

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

LOOPBACK = """<CycloneDDS><Domain Id="any"><General>
<Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""


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


RELIABLE = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(10))
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))


class Peer:
    def __init__(self, domain: int) -> None:
        self.domain = Domain(domain, LOOPBACK)
        self.participant = DomainParticipant(domain)

    def writer(self, topic: str, cls: type, qos: Qos = RELIABLE) -> DataWriter[Any]:
        return DataWriter(self.participant, Topic(self.participant, "rt" + topic, cls), qos=qos)

    def reader(self, topic: str, cls: type, qos: Qos = RELIABLE) -> DataReader[Any]:
        return DataReader(self.participant, Topic(self.participant, "rt" + topic, cls), qos=qos)


def echo(peer: Peer) -> None:
    reader, writer = peer.reader("/there", JointState), peer.writer("/back", JointState)
    print("ready", flush=True)
    for state in reader.take_iter(timeout=20 * 10**9):
        print(state.name, state.position, state.header.frame_id, flush=True)
        writer.write(state)


def driver(peer: Peer) -> None:
    writer = peer.writer("/scan", LaserScan, BEST_EFFORT)
    print("ready", flush=True)
    stamp = Header(Time(1, 2), "laser")
    while True:
        writer.write(LaserScan(stamp, -1.0, 1.0, 0.5, 0.0, 0.1, 0.1, 10.0, [1.0, 2.0, 3.0], []))
        time.sleep(0.05)


def drive(peer: Peer) -> None:
    odometry, commands = (
        peer.reader("/husky/odom", Odometry, BEST_EFFORT),
        peer.writer("/husky/cmd_vel", Twist),
    )
    began = None
    for seen in odometry.take_iter(timeout=20 * 10**9):
        x = seen.pose.pose.position.x
        began = x if began is None else began
        if x > began + 0.5:
            print("went half a metre", seen.child_frame_id, flush=True)
            return
        commands.write(Twist(Vector3(1.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.0)))


if __name__ == "__main__":
    {"echo": echo, "driver": driver, "drive": drive}[sys.argv[2]](Peer(int(sys.argv[1])))
