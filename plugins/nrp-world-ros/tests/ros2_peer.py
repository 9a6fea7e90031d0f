"""A node of ROS 2 that uses nothing of the platform but its definitions of messages that ROS lacks.

python ros2_peer.py echo      what comes on /there goes back on /back, as a line and on the topic
python ros2_peer.py driver    /scan is published as drivers of sensors do: with their best effort only
python ros2_peer.py move SECONDS    JSON: how far each drive and joint went that it commanded
python ros2_peer.py latched   what is kept for late subscribers on /kept, and not kept on /gone
python ros2_peer.py sensor    JSON: the number of messages of /joints and /camera, with the QoS of sensors
python ros2_peer.py times     the time of a node with use_sim_time, twice
python ros2_peer.py topics SECONDS    JSON: the type and number of messages of each topic
python ros2_peer.py call SERVICE TYPE N FIELD=VALUE...    the answers to N calls at once, or: no server
python ros2_peer.py serve     the service /lamp
python ros2_peer.py description    the text of /robot_description
python ros2_peer.py stranger  twenty topics that come and go
python ros2_peer.py say TOPIC    Twist messages on a topic
"""

import json
import sys
import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import Image, JointState, LaserScan
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool

import nrp_world_ros.ros2.packages  # noqa: F401

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DONE: list[bool] = []


def tell(*words: object) -> None:
    print(*words, flush=True)


def spin(node: Node, end: Callable[[], bool] = lambda: bool(DONE), timeout_s: float = 60.0) -> None:
    end_s = time.monotonic() + timeout_s
    while not end() and time.monotonic() < end_s:
        rclpy.spin_once(node, timeout_sec=0.05)


def kind(name: str) -> Any:
    package, module, short = name.split("/")
    return getattr(import_module(f"{package}.{module}"), short)


def echo(node: Node) -> None:
    back = node.create_publisher(JointState, "/back", 10)

    def hear(state: JointState) -> None:
        tell(state.name, list(state.position), state.header.frame_id)
        back.publish(state)

    node.create_subscription(JointState, "/there", hear, 10)
    tell("ready")
    spin(node)


def driver(node: Node) -> None:
    out = node.create_publisher(LaserScan, "/scan", qos_profile_sensor_data)
    scan = LaserScan(ranges=[1.0, 2.0, 3.0])
    scan.header.frame_id = "laser"
    node.create_timer(0.05, lambda: out.publish(scan))
    tell("ready")
    spin(node)


class Mover:
    """Commands each drive and joint that it finds, forwards and back."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._subscriptions: dict[str, Any] = {}
        self.publishers: dict[str, Any] = {}
        self.seen: dict[str, tuple[float, float, float]] = {}
        """The first, least and greatest position by topic of commands, m and rad."""

    def note(self, topic: str, value: float) -> None:
        first, low, high = self.seen.get(topic, (value, value, value))
        self.seen[topic] = first, min(low, value), max(high, value)

    def joints(self, robot: str, state: JointState) -> None:
        for joint, position in zip(state.name, state.position, strict=True):
            self.note(f"{robot}/{joint}/cmd_pos", position)

    def odometry(self, robot: str, odom: Odometry) -> None:
        self.note(f"{robot}/cmd_vel", odom.pose.pose.position.x)

    def meet(self) -> None:
        hears = {"joint_states": self.joints, "odom": self.odometry}
        for topic, (name, *_) in self._node.get_topic_names_and_types():
            robot, _, last = topic.rpartition("/")
            if last in hears and topic not in self._subscriptions:
                hear = partial(hears[last], robot)
                self._subscriptions[topic] = self._node.create_subscription(kind(name), topic, hear, 10)
            elif last in ("cmd_vel", "cmd_pos") and topic not in self.publishers:
                self.publishers[topic] = self._node.create_publisher(kind(name), topic, 10)

    def command(self) -> None:
        self.meet()
        sign = 1.0 if time.monotonic() % 2.0 < 1.0 else -1.0
        for topic in self.publishers.keys() & self.seen.keys():
            twist = Twist()
            twist.linear.x = sign
            angle = Float64(data=self.seen[topic][0] + 0.2 * sign)
            self.publishers[topic].publish(twist if topic.endswith("cmd_vel") else angle)


def move(node: Node) -> None:
    mover = Mover(node)
    node.create_timer(0.1, mover.command)
    spin(node, timeout_s=float(sys.argv[2]))
    ranges = {topic: high - low for topic, (_, low, high) in mover.seen.items()}
    tell(json.dumps({topic: ranges[topic] for topic in mover.publishers}))


def latched(node: Node) -> None:
    heard: list[str] = []

    def hear(topic: str, twist: Twist) -> None:
        heard.append(topic)
        tell(topic, twist.linear.x)

    for topic, qos in (("/kept", LATCHED), ("/gone", 10)):
        node.create_subscription(Twist, topic, partial(hear, topic), qos)
    spin(node, lambda: "/kept" in heard, timeout_s=40.0)
    spin(node, timeout_s=1.0)


def sensor(node: Node) -> None:
    counts, last = {"/joints": 0, "/camera": 0}, [time.monotonic() + 60.0]

    def hear(topic: str) -> None:
        counts[topic] += 1
        last[0] = time.monotonic()

    # deep enough for all: a busy machine may not let it read for a while
    qos = QoSProfile(depth=4000, reliability=qos_profile_sensor_data.reliability)
    node.create_subscription(JointState, "/joints", lambda _: hear("/joints"), qos, raw=True)
    node.create_subscription(Image, "/camera", lambda _: hear("/camera"), qos, raw=True)
    tell("ready")
    spin(node, lambda: time.monotonic() > last[0] + 2.0)
    tell(json.dumps(counts))


def times(node: Node) -> None:
    node.set_parameters([Parameter("use_sim_time", value=True)])
    spin(node, lambda: node.get_clock().now().nanoseconds > 0)
    tell(node.get_clock().now().nanoseconds)
    spin(node, timeout_s=1.0)
    tell(node.get_clock().now().nanoseconds)


def topics(node: Node) -> None:
    found: dict[str, list[Any]] = {}

    def hear(topic: str) -> None:
        found[topic][1] += 1

    def look() -> bool:
        for topic, (name, *_) in node.get_topic_names_and_types():
            if topic not in found and node.count_publishers(topic):
                found[topic] = [name, 0]
                offered = node.get_publishers_info_by_topic(topic)[0].qos_profile
                kept = offered.durability is DurabilityPolicy.TRANSIENT_LOCAL
                qos = LATCHED if kept else QoSProfile(depth=10)
                node.create_subscription(kind(name), topic, lambda _, topic=topic: hear(topic), qos, raw=True)
        return False

    spin(node, look, float(sys.argv[2]))
    tell(json.dumps(found))


def call(node: Node) -> None:
    service, name, number, *given = sys.argv[2:]
    client = node.create_client(kind(name), service)
    if not client.wait_for_service(30.0):
        tell("no server")
        return
    request = client.srv_type.Request()
    for path, value in (each.split("=", 1) for each in given):
        *parts, last = path.split(".")
        target = request
        for part in parts:
            target = getattr(target, part)
        setattr(target, last, type(getattr(target, last))(json.loads(value)))
    coming = [client.call_async(request) for _ in range(int(number))]
    for _ in range(4):  # an answer is lost if the caller was not discovered within 0.1 s
        spin(node, lambda: all(each.done() for each in coming), 15.0)
        coming[:] = [each if each.done() else client.call_async(request) for each in coming]
    for each in coming:
        tell(each.result() if each.done() else "nothing")


def serve(node: Node) -> None:
    def switch(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success, response.message = request.data, "on" if request.data else "off"
        return response

    node.create_service(SetBool, "/lamp", switch)
    tell("ready")
    spin(node)


def description(node: Node) -> None:
    def hear(text: String) -> None:
        tell(text.data)
        DONE.append(True)

    node.create_subscription(String, "/robot_description", hear, LATCHED)
    spin(node)


def stranger(node: Node) -> None:
    tell("ready")
    while True:
        made = [
            node.create_publisher(kind, f"/stranger_{kind.__name__}{i}", 10)
            for i in range(10)
            for kind in (Twist, Image)
        ]
        time.sleep(0.02)
        for each in made:
            node.destroy_publisher(each)


def say(node: Node) -> None:
    out = node.create_publisher(Twist, sys.argv[2], 10)
    node.create_timer(0.05, lambda: out.publish(Twist()))
    spin(node, timeout_s=200.0)


if __name__ == "__main__":
    rclpy.init(args=[])
    globals()[sys.argv[1]](Node("visitor"))
