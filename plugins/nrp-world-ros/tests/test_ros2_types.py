"""Types that this ROS 2 lacks, against those that ROS's generators have made of the same definitions."""

from __future__ import annotations

import json
import subprocess
import sys
from array import array
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from nrp_core.errors import TopicError
from nrp_core.messages.base import array_field, message
from nrp_core.messages.cdr import Codec, MessageField

from conftest import Ros2, needs_ros2
from nrp_world_ros.ros2.types import RosTypes

MESSAGES = (
    "BasicTypes", "Constants", "Defaults", "Strings", "Arrays", "UnboundedSequences",
    "BoundedPlainSequences", "MultiNested", "Empty",
)  # fmt: skip


def installed(name: str) -> Path:
    """Return a file of ROS's package of test messages."""
    import rclpy

    return Path(rclpy.__file__).parents[4] / "share/test_msgs" / name


def hashes(name: str) -> dict[str, str]:
    """Return the hashes of a type and of what it consists of, as ROS's generators computed them."""
    listed = json.loads(installed(f"{name}.json").read_text())["type_hashes"]
    return {each["type_name"]: each["hash_string"] for each in listed}


@pytest.fixture(scope="module")
def codec() -> Codec:
    """Know the definitions, but not the classes."""
    codec = Codec()
    for name in ("BoundedSequences", *MESSAGES):
        codec._store.register(_definition(f"test_msgs/msg/{name}"))
    return codec


def _definition(name: str) -> Any:
    from nrp_core.messages.cdr import _parsed

    return _parsed(installed(name.removeprefix("test_msgs/") + ".msg").read_text(), name)


@message("test_msgs/msg/FibonacciGoal", "int32 order")
class FibonacciGoal:
    order: int = 0


@message("test_msgs/msg/FibonacciResult", "int32[] sequence")
class FibonacciResult:
    sequence: npt.NDArray[np.int32] = array_field(np.int32)


@message("test_msgs/msg/FibonacciFeedback", "int32[] sequence")
class FibonacciFeedback:
    sequence: npt.NDArray[np.int32] = array_field(np.int32)


@needs_ros2
@pytest.mark.parametrize("short", MESSAGES)
def test_a_message_made_here_has_the_fields_bytes_and_hash_of_ros(codec: Codec, short: str) -> None:
    import test_msgs.msg
    from rclpy.serialization import deserialize_message, serialize_message

    name = f"test_msgs/msg/{short}"
    cls, theirs = RosTypes(codec).make(name), getattr(test_msgs.msg, short)
    assert list(cls.get_fields_and_field_types()) == list(theirs.get_fields_and_field_types())
    assert codec.hash(name) == hashes(f"msg/{short}")[name]
    data = serialize_message(_filled(theirs()))
    mine = deserialize_message(data, cls)
    again = deserialize_message(serialize_message(mine), theirs)
    assert again == deserialize_message(data, theirs)
    assert cls() == cls()


def _filled(message: Any) -> Any:
    """Return a message with values other than its defaults."""
    for name, text in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if text == "string":
            setattr(message, name, "añ")
        elif isinstance(value, array):
            setattr(message, name, array(value.typecode, [1, 2, 3]))
        elif text == "sequence<string>":
            setattr(message, name, ["", "b", "long" * 50])
        elif isinstance(value, np.ndarray):
            setattr(message, name, value + 1)
        elif hasattr(value, "get_fields_and_field_types"):
            _filled(value)
    return message


def test_a_message_without_fields_inside_another_needs_no_attribute() -> None:
    codec = Codec()
    codec.compose("nrp_msgs/msg/Nothing", [MessageField("structure_needs_at_least_one_member", "uint8")])
    codec.compose(
        "nrp_msgs/msg/Holder", [MessageField("inner", "nrp_msgs/msg/Nothing"), MessageField("n", "int32")]
    )
    message = SimpleNamespace(inner=SimpleNamespace(), n=7)
    assert bytes(codec.encode_as(message, "nrp_msgs/msg/Holder")).hex() == "000100000000000007000000"


@needs_ros2
def test_services_and_actions_made_here_have_the_hashes_of_ros(codec: Codec) -> None:
    types = RosTypes(codec)
    types.make("test_msgs/action/Fibonacci")
    expected = hashes("action/Fibonacci")
    assert {name: codec.hash(name) for name in expected} == expected


SERVER_AND_CLIENT = """
import sys, threading
import rclpy
from nrp_core.messages.cdr import Codec, MessageField
from nrp_world_ros.ros2.types import RosTypes
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import MultiThreadedExecutor
from test_msgs.action import Fibonacci
import test_ros2_types

made = RosTypes(Codec()).make("test_msgs/action/Fibonacci")
serving, calling = (made, Fibonacci) if sys.argv[1] == "serve" else (Fibonacci, made)
rclpy.init(args=[])
server, client = rclpy.create_node("server"), rclpy.create_node("client")
told = []

def execute(goal):
    goal.publish_feedback(serving.Feedback(sequence=[0, 1]))
    goal.succeed()
    return serving.Result(sequence=[0, 1, 1, goal.request.order])

action = ActionServer(server, serving, "/count", execute)
caller = ActionClient(client, calling, "/count")
executor = MultiThreadedExecutor(2)
executor.add_node(server)
executor.add_node(client)
threading.Thread(target=executor.spin, daemon=True).start()
assert caller.wait_for_server(20)
hear = lambda each: told.append(list(each.feedback.sequence))
result = caller.send_goal(calling.Goal(order=7), feedback_callback=hear)
print(list(result.result.sequence), result.status, told)
"""


@needs_ros2
@pytest.mark.parametrize("side", ["serve", "call"])
def test_an_action_made_here_works_with_that_of_ros(ros2: Ros2, side: str) -> None:
    ros2.env["PYTHONPATH"] = str(Path(__file__).parent)
    said = ros2.run(sys.executable, "-c", SERVER_AND_CLIENT, side)
    assert said.strip() == "[0, 1, 1, 7] 4 [[0, 1]]"


@needs_ros2
def test_a_node_finds_messages_that_ros_lacks() -> None:
    program = (
        "import nrp_world_ros.ros2.packages\n"
        "from gazebo_msgs.srv import SetModelState\n"
        "from tf2_msgs.msg import TFMessage\n"
        "from std_msgs.msg import String\n"
        "print(SetModelState.Request().model_state.pose, TFMessage().transforms, String.__module__)\n"
        "try:\n    from gazebo_msgs.msg import Nothing\nexcept ImportError:\n    print('none')\n"
    )
    said = subprocess.run(
        [sys.executable, "-P", "-c", program], capture_output=True, text=True, check=True
    ).stdout
    assert "geometry_msgs.msg.Pose" in said
    assert said.split()[-3:] == ["[]", "std_msgs.msg._string", "none"]


@needs_ros2
def test_a_message_that_cannot_be_encoded_is_not_sent(capfd: pytest.CaptureFixture[str]) -> None:
    from rclpy.serialization import serialize_message

    cls = RosTypes(Codec()).make("gazebo_msgs/msg/ModelState")
    with pytest.raises((SystemError, RuntimeError)):
        serialize_message(cls(model_name=3))
    assert "gazebo_msgs/msg/ModelState" in capfd.readouterr().err


@needs_ros2
def test_an_unknown_type_is_refused() -> None:
    with pytest.raises(TopicError):
        RosTypes(Codec()).make("gazebo_msgs/srv/Nothing")
