"""The middleware calls functions of types that are made in Python while it holds its locks."""

from __future__ import annotations

import sys

import pytest

from conftest import Ros2, needs_ros2

SERVE = """
import faulthandler, os, sys, threading, time
import rclpy
import nrp_world_ros.ros2.packages
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import GetModelState
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor

faulthandler.dump_traceback_later(120, exit=True)  # in a deadlock this thread keeps the interpreter
rclpy.init(args=[])
node, answered, ended = rclpy.create_node("served"), [], threading.Event()
silent = (PublisherEventCallbacks(use_default_callbacks=False),
          SubscriptionEventCallbacks(use_default_callbacks=False))

def answer(request, response):
    answered.append(request.model_name)
    response.status_message = 3 * request.model_name
    return response

def spin():
    while not ended.is_set():
        executor.spin_once(0.1)

def count():
    while not ended.is_set():
        sum(range(1000))

for number in range(4):
    node.create_service(GetModelState, f"/served_{number}", answer)
executor = SingleThreadedExecutor()
executor.add_node(node)
for run in (spin, count):
    threading.Thread(target=run, daemon=True).start()
sys.setswitchinterval(1e-6)
print("ready", flush=True)
end_s, made = time.monotonic() + 30, 0
while time.monotonic() < end_s or len(answered) < 20:
    topic = f"/made_{made % 7}"
    publisher = node.create_publisher(ModelState, topic, 10, event_callbacks=silent[0])
    subscription = node.create_subscription(ModelState, topic, print, 10, event_callbacks=silent[1])
    node.get_publishers_info_by_topic(topic)
    node.destroy_publisher(publisher)
    node.destroy_subscription(subscription)
    made += 1
print(f"answered {len(answered)} calls, made {made} endpoints", flush=True)
os._exit(0)
"""

ASK = """
import rclpy
import nrp_world_ros.ros2.packages
from gazebo_msgs.srv import GetModelState

rclpy.init(args=[])
node, number = rclpy.create_node("asks"), 0
while True:
    client = node.create_client(GetModelState, f"/served_{number % 4}")
    if client.wait_for_service(2.0):
        for _ in range(20):
            asked = client.call_async(GetModelState.Request(model_name="x" * 20))
        rclpy.spin_until_future_complete(node, asked, timeout_sec=1.0)
    node.destroy_client(client)
    number += 1
"""


@pytest.mark.heavy
@needs_ros2
def test_calls_are_answered_while_another_thread_makes_publishers_and_callers_come_and_go(ros2: Ros2) -> None:
    served = ros2.start(sys.executable, "-c", SERVE)
    assert served.stdout is not None
    assert served.stdout.readline().strip() == "ready"
    for _ in range(2):
        ros2.start(sys.executable, "-c", ASK)
    said, _ = served.communicate(timeout=180)
    assert served.returncode == 0, said
    assert said.startswith("answered"), said


@needs_ros2
def test_functions_that_run_under_a_lock_are_no_functions_of_python() -> None:
    from nrp_core.messages.cdr import Codec

    from nrp_world_ros.ros2.types import RosTypes, _support

    RosTypes(Codec()).make("gazebo_msgs/msg/ModelState")
    support = _support()
    places = range(support._code._start, support._code._start + support._code._memory.tell())
    assert all(address in places for address in support._functions if address is not None)
