"""A robot of ROS 2 that is not simulated: it has no watchdog and a bad network.

python ros2_robot.py [stamped]    odometry at about 30 Hz with jitter, of which a tenth is lost; on SIGTERM,
                                  JSON with the wall time and the velocity of each command
"""

import json
import random
import signal
import sys
import time
from typing import Any

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

commands: list[tuple[float, float]] = []
draw = random.Random(1)


def hear(message: Any) -> None:
    twist = message.twist if isinstance(message, TwistStamped) else message
    if not commands:
        print("moving", flush=True)
    commands.append((time.time(), twist.linear.x))


def main(stamped: bool) -> None:
    rclpy.init(args=[])
    node, over = Node("robot"), []
    node.create_subscription(TwistStamped if stamped else Twist, "/cart/cmd_vel", hear, 10)
    out = node.create_publisher(Odometry, "/cart/odom", 10)
    signal.signal(signal.SIGTERM, lambda *_: over.append(True))
    began_s, x, due_s = time.time(), 0.0, time.time()
    print("ready", flush=True)
    while not over:
        rclpy.spin_once(node, timeout_sec=0.005)
        x += 0.005 * (commands[-1][1] if commands else 0.0)
        if time.time() > due_s:
            due_s = time.time() + 0.02 + draw.expovariate(1 / 0.01)
            if draw.random() > 0.1:
                odometry = Odometry()
                odometry.pose.pose.position.x = x
                out.publish(odometry)
    print(json.dumps({"began_s": began_s, "commands": commands, "x": x}), flush=True)


main("stamped" in sys.argv)
