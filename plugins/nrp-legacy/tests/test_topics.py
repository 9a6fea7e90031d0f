"""Topics as ROS has them: under the names of all years, each way, whether somebody serves them or not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_legacy.framework import topic
from nrp_legacy.shims.modules import as_in_ros1
from nrp_legacy.topics import find_alias

from nrp_core.checks.validate import validate_file
from nrp_core.dsl.testing import MockWorld
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.sensor_msgs import Image, LaserScan

Opened = Callable[..., Run]

SERVED = {"/robot/husky/camera": Image, "/robot/husky/cmd_vel": Twist}


@pytest.mark.parametrize("name", ["/husky/camera", "/husky/husky/camera", "/other/husky/camera"])
def test_a_name_that_differs_by_its_prefix_means_the_topic_that_is_served(name: str) -> None:
    assert find_alias(name, Image, MockWorld(SERVED)) == "/robot/husky/camera"


@pytest.mark.parametrize(
    ("name", "kind"), [("/husky/camera", Twist), ("/left/camera", Image), ("/robot/husky/camera", Image)]
)
def test_another_type_another_name_and_a_served_topic_need_no_further_name(name: str, kind: type) -> None:
    assert find_alias(name, kind, MockWorld(SERVED)) is None


def test_a_name_that_could_mean_two_topics_means_none() -> None:
    world = MockWorld({"/one/cmd_vel": Twist, "/two/cmd_vel": Twist})
    assert find_alias("/cmd_vel", Twist, world) is None


FUNCTIONS = """
@nrp.MapSpikeSink("cells", nrp.brain.circuit, nrp.spike_recorder)
@nrp.Neuron2Robot(Topic('/gazebo/model_states', gazebo_msgs.msg.ModelStates))
def against_the_direction(t, cells):
    return gazebo_msgs.msg.ModelStates()

@nrp.MapRobotPublisher("states", Topic('/gazebo/model_states', gazebo_msgs.msg.ModelStates))
@nrp.MapVariable("proxy", initial_value=rospy.ServiceProxy('/gazebo/get_world_properties', None))
@nrp.Robot2Neuron()
def against_it_too(t, states, proxy):
    states.send_message(gazebo_msgs.msg.ModelStates())
    assert 'robot' in proxy.value().model_names

@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))
def drive(t):
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=0.25))

@nrp.MapRobotSubscriber("sent", Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))
@nrp.MapRobotSubscriber("pose", Topic('/gazebo/model_states', gazebo_msgs.msg.ModelStates))
@nrp.MapCSVRecorder("rows", filename="rows.csv", headers=["sent", "models"])
@nrp.Robot2Neuron()
def eavesdrop(t, sent, pose, rows):
    rows.record_entry(sent.value and sent.value.linear.x, 'robot' in pose.value.name)

@nrp.MapRobotPublisher("plain", Topic('number', std_msgs.msg.Float64))
@nrp.MapRobotSubscriber("heard", Topic('/number', std_msgs.msg.Float64))
@nrp.MapRobotSubscriber("open", Topic('/trajectory', trajectory_msgs.msg.JointTrajectory))
@nrp.MapSpikeSource("refused", nrp.brain.circuit, nrp.poisson)
@nrp.Robot2Neuron()
def plain_values(t, plain, heard, open, refused):
    plain.send_message(t)
    assert open.value is None
    assert t == 0 or heard.value.data == t - 0.02 or abs(heard.value.data - t + 0.02) < 1e-9
"""
REFUSED = """
@nrp.MapSpikeSource("cells", nrp.brain.circuit, nrp.raw_signal)
@nrp.Robot2Neuron()
def injects(t, cells):
    pass
"""
BIBI = """<bibi><brainModel>brain_model/two_cells.py</brainModel>
<bodyModel>husky_model/model.sdf</bodyModel>
<transferFunction src="topics.py"/><transferFunction src="injects.py"/></bibi>"""
EXC = (
    '<ExD><environmentModel src="arena/arena.sdf"/><bibiConf src="topics.bibi"/><timeout>0.1</timeout></ExD>'
)


@pytest.fixture
def run(opened: Opened, corpus: Path) -> Run:
    folder = corpus / "topics"
    folder.mkdir()
    files = {
        "topics.py": "import rospy\n" + FUNCTIONS,
        "injects.py": REFUSED,
        "topics.bibi": BIBI,
        "t.exc": EXC,
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    made = opened("topics/t.exc")
    made.run()
    return made


def test_functions_communicate_in_both_directions_of_a_topic(run: Run) -> None:
    assert run.result().failures == []
    adapters: dict[str, Any] = {function.name: function.adapters for function in run.loop.functions}
    rows = adapters["eavesdrop"]["rows"].rows
    assert rows[0][1] == "True"
    assert rows[-1] == ["0.25", "True"]


def test_a_device_of_another_simulator_is_refused_alone(run: Run) -> None:
    assert "injects" not in [function.name for function in run.loop.functions]
    assert any("raw_signal does not drive neurons" in warning for warning in map(str, run.result().problems))


def test_functions_send_arrays_of_one_number_and_send_0_for_anything_but_numbers(
    caplog: pytest.LogCaptureFixture,
) -> None:
    sent = topic("/cmd_vel", Twist).process
    message = Twist(Vector3(np.array([2.0]), np.float32(1.0), float("nan")))
    assert sent(message).linear == Vector3(2.0, 1.0, 0.0)
    assert np.isnan(message.linear.z)
    assert sent(np.array([0.5])) == 0.5
    assert sent(unchanged := Twist()) is unchanged
    sent(message)
    assert caplog.text.count("a message for /cmd_vel contains nan: 0 is sent instead") == 1


def test_functions_read_tuples_and_leave_what_others_read() -> None:
    original = LaserScan(ranges=np.array([2.0, 1.0]))
    heard = as_in_ros1(original)
    assert heard.ranges.index(min(heard.ranges)) == 1
    assert isinstance(original.ranges, np.ndarray)
    image = Image(data=np.zeros((1, 1, 3), np.uint8))
    assert as_in_ros1(image).data == b"\x00\x00\x00"
    assert image.data.shape == (1, 1, 3)
    assert as_in_ros1(message := Twist()) is message


def test_messages_of_another_type_than_that_of_a_topic_are_reported_by_their_types(
    opened: Opened, corpus: Path
) -> None:
    bibi = corpus / "husky_wheels_2016" / "wheels.bibi"
    text = bibi.read_text("utf-8").replace("gazebo_msgs.msg.WheelSpeeds", "std_msgs.msg.Float64")
    text = text.replace("import gazebo_msgs.msg", "import std_msgs.msg")
    bibi.write_text(text.replace("(left, right, left, right)", "(left)"), "utf-8")
    run = opened("husky_wheels_2016/wheels.exc", "duration=100 ms")
    run.run()
    (message,) = [one.message for one in run.problems if "wheel_speeds" in one.message]
    assert message.endswith("wheel_speeds' takes gazebo_msgs/msg/WheelSpeeds, not std_msgs/msg/Float64")


@pytest.mark.parametrize(("name", "is_said"), [("/p3dx/husky/cmd_vel", True), ("/husky/cmd_vel", False)])
def test_the_use_of_a_topic_under_the_name_of_another_robot_is_reported(
    opened: Opened, corpus: Path, name: str, is_said: bool
) -> None:
    (corpus / "topics").mkdir()
    function = (
        f"@nrp.Neuron2Robot(Topic('{name}', geometry_msgs.msg.Twist))\n"
        "def drive(t):\n    return geometry_msgs.msg.Twist()\n"
    )
    bibi = BIBI.replace('<transferFunction src="injects.py"/>', "")
    for file, text in {"topics.py": function, "topics.bibi": bibi, "t.exc": EXC}.items():
        (corpus / "topics" / file).write_text(text)
    run = opened("topics/t.exc")
    run.run()
    said = f"no topic '{name}': '/robot/husky/cmd_vel' is used, the only one like it"
    assert (said in [problem.message for problem in run.result().problems]) == is_said


CLOCKED = """
from rosgraph_msgs.msg import Clock
import rospy
heard = []
rospy.Subscriber("/clock", Clock, lambda message: heard.append(message.clock.to_sec()))
@nrp.MapVariable("told", initial_value=rospy.Publisher("/told", std_msgs.msg.Float64, queue_size=1))
@nrp.MapVariable("times", initial_value=[])
@nrp.MapRobotSubscriber("clock", Topic("/clock", Clock))
@nrp.Neuron2Robot(triggers="clock", throttling_rate=1000)
def on_clock(t, told, times, clock):
    times.value.append((round(clock.value.clock.to_sec(), 3), [round(one, 3) for one in heard[-1:]]))
    told.value.publish(t)

@nrp.MapRobotSubscriber("told", Topic("/told", std_msgs.msg.Float64))
@nrp.Robot2Neuron(triggers="told")
def listen(t, told):
    clientLogger.info(told.value.data)
"""


def test_the_clock_triggers_functions_as_with_ros(opened: Opened, corpus: Path) -> None:
    folder = corpus / "clocked"
    folder.mkdir()
    (folder / "tf.py").write_text(CLOCKED)
    (folder / "x.bibi").write_text('<bibi><transferFunction src="tf.py"/></bibi>')
    (folder / "x.exc").write_text('<ExD><timeout>1.0</timeout><bibiConf src="x.bibi"/></ExD>')
    run = opened("clocked/x.exc")
    run.run_until(0.1)
    assert not run.result().failures
    (function,) = (one for one in run.loop.functions if one.name == "on_clock")
    times, heard = zip(*function.adapters["times"].value, strict=True)  # type: ignore[attr-defined]
    assert times == (0.02, 0.04, 0.06, 0.08, 0.1)  # the ends of the steps
    assert heard == ([], [0.04], [0.06], [0.08], [0.1])  # a subscriber of rospy hears from its first step on
    assert not [one for one in validate_file(folder / "x.exc") if one.code is Code.NRP212]


STRINGS = """
import rospy
from std_msgs.msg import String
from smach import StateMachine, CBState
rospy.Publisher("/ros_cle_simulation/logs", String, latch=True, queue_size=10).publish("begin")
sm = StateMachine(outcomes=["DONE"])
with sm:
    StateMachine.add("a", CBState(lambda userdata: "done", outcomes=["done"]), transitions={"done": "DONE"})
"""


def test_a_function_logs_while_a_machine_takes_the_logs_for_strings(opened: Opened, corpus: Path) -> None:
    folder = corpus / "logs"
    folder.mkdir()
    (folder / "tf.py").write_text('@nrp.Robot2Neuron()\ndef f(t):\n    clientLogger.info("at", t)\n')
    (folder / "m.exd").write_text(STRINGS)
    (folder / "x.bibi").write_text('<bibi><transferFunction src="tf.py"/></bibi>')
    control = '<experimentControl><stateMachine src="m.exd"/></experimentControl>'
    (folder / "x.exc").write_text(f'<ExD><timeout>1.0</timeout><bibiConf src="x.bibi"/>{control}</ExD>')
    run = opened("logs/x.exc")
    shown = run.world.subscribe("/ros_cle_simulation/logs")
    run.run_until(0.1)
    assert not run.result().failures
    assert shown.latest is not None
    assert shown.latest.message.data == "at 0.08"


EACH = """
@nrp.MapRobotPublisher("tells", Topic("/told", std_msgs.msg.Float64))
@nrp.Robot2Neuron()
def tell(t, tells):
    for part in (0.25, 0.5):
        tells.send_message(std_msgs.msg.Float64(t + part))

@nrp.MapVariable("all", initial_value=[])
@nrp.MapRobotSubscriber("told", Topic("/told", std_msgs.msg.Float64))
@nrp.Robot2Neuron(["told"])
def listen(t, told, all):
    all.value.append((round(t, 3), round(told.value.data, 3)))
"""


def test_each_message_on_a_topic_calls_the_functions_that_it_triggers(opened: Opened, corpus: Path) -> None:
    folder = corpus / "each"
    folder.mkdir()
    (folder / "tf.py").write_text(EACH)
    (folder / "x.bibi").write_text('<bibi><transferFunction src="tf.py"/></bibi>')
    (folder / "x.exc").write_text('<ExD><timeout>1.0</timeout><bibiConf src="x.bibi"/></ExD>')
    run = opened("each/x.exc")
    run.run_until(0.06)
    assert not run.result().failures
    (function,) = (one for one in run.loop.functions if one.name == "listen")
    told = function.adapters["all"].value  # type: ignore[attr-defined]
    assert told == [(0.02, 0.25), (0.02, 0.5), (0.04, 0.27), (0.04, 0.52)]
