"""What experiments import behaves as they know it."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st
from nrp_legacy.code import ignore_note
from nrp_legacy.files import Library
from nrp_legacy.namespace import Namespace
from nrp_legacy.shims import model_states, transformations
from nrp_legacy.shims.modules import CvBridge, CvBridgeError
from nrp_legacy.shims.smach import CBState, Concurrence, InvalidTransitionError, Sequence, State, StateMachine
from nrp_legacy.shims.steps import Task
from nrp_legacy.shims.times import Duration, Time

from nrp_core.dsl.loading import load_transfer_functions
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Findings
from nrp_core.messages.base import Duration as BareDuration
from nrp_core.messages.base import Time as BareTime
from nrp_core.messages.geometry_msgs import Point, Quaternion, Vector3
from nrp_core.messages.std_msgs import Header
from nrp_core.world.model_states import pose_of
from tests.shared.profiled import is_profilable

ANGLES = st.floats(-1.5, 1.5)


# -- times


def test_times_and_durations_add_up_as_in_ros() -> None:
    assert Time(1.5) + Duration(0, 500_000_000) == Time(2)
    assert isinstance(Time(3) - Time(1), Duration)
    assert not isinstance(Time(3) - Time(1), Time)
    assert (Time(2.25).secs, Time(2.25).nsecs, Time(2.25).to_sec()) == (2, 250_000_000, 2.25)
    assert Time(1) < 2 < Time(3)


def test_parts_of_times_and_durations_can_be_set() -> None:
    spans = Time(2.25), Duration(2.25), BareTime(2, 250_000_000), BareDuration(2, 250_000_000)
    for span in spans:
        span.secs, span.nsecs = 1, 500_000_000
        assert (span.sec, span.nanosec, span.secs, span.nsecs) == (1, 500_000_000, 1, 500_000_000)
    assert spans[0] == 1.5
    assert Header().stamp.secs == 0  # no message shares its time with another


# -- tf.transformations


@given(ANGLES, ANGLES, ANGLES)
def test_angles_come_back_from_their_quaternion(roll: float, pitch: float, yaw: float) -> None:
    quaternion = transformations.quaternion_from_euler(roll, pitch, yaw)
    assert transformations.euler_from_quaternion(quaternion) == pytest.approx((roll, pitch, yaw), abs=1e-9)


@given(ANGLES, ANGLES)
def test_quaternions_multiply_as_their_matrices_do(one: float, two: float) -> None:
    p = transformations.quaternion_from_euler(one, two, 0.3)
    q = transformations.quaternion_from_euler(two, 0.1, one)
    product = transformations.quaternion_matrix(transformations.quaternion_multiply(p, q))
    assert product == pytest.approx(
        transformations.quaternion_matrix(p) @ transformations.quaternion_matrix(q)
    )
    one_turn = transformations.quaternion_multiply(p, transformations.quaternion_inverse(p))
    assert one_turn == pytest.approx([0, 0, 0, 1])


def test_a_matrix_rotates_about_an_axis_through_a_point() -> None:
    turn = transformations.rotation_matrix(0.5, (0, 0, 2), (1, 1, 0))
    assert turn @ (1, 1, 7, 1) == pytest.approx((1, 1, 7, 1))
    assert turn @ (2, 1, 0, 1) == pytest.approx((1 + np.cos(0.5), 1 + np.sin(0.5), 0, 1))
    assert transformations.unit_vector([[3, 4], [0, 2]], axis=1) == pytest.approx(
        np.array([[0.6, 0.8], [0, 1]])
    )


def test_a_matrix_is_composed_of_its_parts() -> None:
    moved = transformations.compose_matrix(None, None, [0, 0, np.pi / 2], np.array([1, 2, 3]), None)
    assert moved @ (1, 0, 0, 1) == pytest.approx((1, 3, 3, 1))
    whole = transformations.compose_matrix((2, 1, 1), (0.5, 0, 0), (0, 0, 0), (0, 0, 1), (0, 0, 0, 2))
    assert whole @ (1, 1, 0, 1) == pytest.approx((2.5 / 2, 1 / 2, 1 / 2, 1))


# -- cv_bridge

IMAGE = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8"])
def test_an_image_survives_its_message(encoding: str) -> None:
    message = CvBridge().cv2_to_imgmsg(IMAGE, encoding)
    assert (CvBridge().imgmsg_to_cv2(message, encoding) == IMAGE).all()
    assert (CvBridge().imgmsg_to_cv2(message) == IMAGE).all()


def test_channels_are_swapped_between_orders() -> None:
    message = CvBridge().cv2_to_imgmsg(IMAGE, "rgb8")
    assert (CvBridge().imgmsg_to_cv2(message, "bgr8") == IMAGE[..., ::-1]).all()


def test_grey_images_have_no_axis_of_channels() -> None:
    message = CvBridge().cv2_to_imgmsg(IMAGE[..., 0], "mono8")
    assert (CvBridge().imgmsg_to_cv2(message, "mono8") == IMAGE[..., 0]).all()
    assert CvBridge().imgmsg_to_cv2(message, "rgb8").shape == (2, 3, 3)


def test_an_encoding_that_is_not_known_is_refused(golden: Golden) -> None:
    with golden.raises(CvBridgeError, match="'yuv'.*mono8"):
        CvBridge().cv2_to_imgmsg(IMAGE, "yuv")


# -- smach


def machine(**states: tuple[Any, dict[str, str]]) -> StateMachine:
    made = StateMachine(outcomes=["end", "error"])
    with made:
        for label, (callback, transitions) in states.items():
            StateMachine.add(label, CBState(callback, outcomes=list(transitions)), transitions)
    return made


def test_a_machine_goes_from_state_to_state_and_shares_data() -> None:
    def count(userdata: Any) -> str:
        userdata.n = getattr(userdata, "n", 0) + 1
        return "again" if userdata.n < 3 else "enough"

    made = machine(
        count=(count, {"again": "count", "enough": "last"}), last=(lambda _data: "yes", {"yes": "end"})
    )
    assert made.execute() == "end"
    assert made.userdata["n"] == 3


def test_states_find_data_under_names_of_their_own() -> None:
    class Count(State):
        def execute(self, userdata: Any) -> str:
            userdata.out = userdata.number + 1
            return "done" if userdata.out > 2 else "again"

    machine = StateMachine(outcomes=["done"])
    machine.userdata.total = 0
    names = {"number": "total", "out": "total"}
    with machine:
        StateMachine.add("count", Count(["again", "done"]), {"again": "count"}, remapping=names)
    assert machine.execute() == "done"
    assert machine.userdata.total == 3
    assert "number" not in machine.userdata


def test_an_outcome_that_leads_nowhere_is_an_error_that_names_it(golden: Golden) -> None:
    with golden.raises(InvalidTransitionError, match="'one'.*'yess'"):
        machine(one=(lambda _data: "yess", {"yes": "end"})).execute()


def test_a_sequence_leads_each_state_to_the_next() -> None:
    order: list[str] = []
    sequence = Sequence(outcomes=["succeeded"], connector_outcome="succeeded")
    with sequence:
        for name in "abc":
            Sequence.add(name, CBState(lambda _data, name: order.append(name) or "succeeded", cb_args=[name]))
    assert sequence.execute() == "succeeded"
    assert order == ["a", "b", "c"]


def test_states_side_by_side_end_as_their_map_says() -> None:
    both = Concurrence(
        outcomes=["yes", "no"], default_outcome="no", outcome_map={"yes": {"a": "done", "b": "done"}}
    )
    with both:
        Concurrence.add("a", CBState(lambda _data: "done"))
        Concurrence.add("b", CBState(lambda _data: "done"))
    assert both.execute(None) == "yes"


# -- tasks


def test_a_task_goes_on_when_its_time_has_come_and_ends_when_it_is_stopped() -> None:
    now, seen = [0], []

    def work() -> None:
        while True:
            seen.append(now[0])
            here = Task.here()
            assert here is not None
            here.wait_until(now[0] + 2)

    task = Task(work, lambda: now[0])
    for now[0] in range(6):
        task.advance()
    assert seen == [0, 2, 4]
    task.stop()
    assert task.is_over
    assert task.error is None


def test_a_task_that_catches_everything_is_stopped_too() -> None:
    waited = []

    def work() -> None:
        here = Task.here()
        assert here is not None
        while True:
            with suppress(BaseException):
                waited.append(0)
                here.wait_until(0)

    task = Task(work, lambda: 0)
    task.advance()
    task.stop()
    assert task.is_over
    tries = len(waited)
    task.advance()
    task.stop()
    assert len(waited) == tries > 1


@pytest.mark.parametrize("caught", [BaseException, Exception])
def test_a_task_that_does_not_wait_is_ended_after_its_limit(caught: type[BaseException]) -> None:
    seen = set()

    def work() -> None:
        while not seen:
            with suppress(caught):
                while not seen:
                    pass

    task = Task(work, lambda: 0, limit_s=0.5)
    task.advance()
    seen.add("the end")  # code that catches everything goes on until here
    assert task.is_over
    assert str(task.error) == "it did not wait within 0.5 s, the function_time_limit"
    assert is_profilable()


def test_a_task_that_was_left_while_it_ran_is_stopped() -> None:
    rounds = [0]

    def work() -> None:
        while True:
            rounds[0] += 1
            if rounds[0] == 1000:
                os.kill(os.getpid(), signal.SIGUSR1)  # as an interrupt of the user

    def leave(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGUSR1, leave)
    task = Task(work, lambda: 0)
    with pytest.raises(KeyboardInterrupt):
        task.advance()
    signal.signal(signal.SIGUSR1, before)
    task.stop()
    assert task.is_over
    assert task.error is None


def test_an_exception_in_a_task_ends_it_and_is_kept() -> None:
    task = Task(lambda: 1 / 0, lambda: 0)
    task.advance()
    assert isinstance(task.error, ZeroDivisionError)


# -- the names and imports of transfer functions

IMPORTS = """
import hbp_nrp_cle.tf_framework as nrp
import hbp_nrp_cle
import python_cle.tf_framework
from hbp_nrp_cle.tf_framework import tf_lib
from hbp_nrp_cle.robotsim.RobotInterface import Topic
from hbp_nrp_excontrol.logs import clientLogger
from hbp_nrp_excontrol import nrp_states
import rospy, smach, smach_ros, cv_bridge, tf
from rospy.numpy_msg import numpy_msg
from rospy import ServiceProxy, wait_for_service
from tf import transformations
from cv_bridge import CvBridge
from std_msgs.msg import String, Float64
import std_msgs.msg
from dynamic_reconfigure.msg import Config
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from gazebo_msgs.srv import SetModelState, SpawnModel
import gazebo_msgs.msg
import numpy, cv2
import actionlib, dynamic_reconfigure.client
import cv2.cv as cv
from gazebo_msgs.srv import *
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from smach_ros import SimpleActionState, ConditionState
import scipy, scipy.integrate, scipy.misc, scipy.signal

assert cv.CV_RGB2GRAY == cv2.COLOR_RGB2GRAY and cv.BoxPoints is cv2.boxPoints and GetPhysicsProperties
assert np.int0(2) == 2 and np.asfarray([1]).dtype == float and np.math.pi == np.pi
assert scipy.zeros(2).shape == (2,) and abs(scipy.integrate.simps([0, 1, 2]) - 2) < 1e-9
assert len(scipy.signal.gaussian(5, 1.0)) == 5 and scipy.misc.factorial(3) == 6
client = actionlib.SimpleActionClient("/arm/follow", FollowJointTrajectoryAction)
goal = FollowJointTrajectoryGoal()
goal.trajectory.points.append(JointTrajectoryPoint(positions=[1.0]))
goal.trajectory.joint_names = ["a"]
client.send_goal(goal)
assert not client.wait_for_server(rospy.Duration(1)) and len(goal.trajectory.points) == 1
assert client.send_goal_and_wait(goal) == actionlib.GoalStatus.LOST
assert hbp_nrp_cle.tf_framework.tf_lib.detect_red is nrp.tf_lib.detect_red
assert tf.transformations.quaternion_from_euler is transformations.quaternion_from_euler
assert JointTrajectory(points=[JointTrajectoryPoint()]).points
assert repr(nrp.config.brain_root.sensors) == repr(nrp.brain.sensors)

@MapVariable("x", initial_value=nrange(0, 2))
@nrp.Robot2Neuron()
def first(t, x):
    logger.info("hello")
    clientLogger.advertise("%s", t)
"""


def test_everything_that_experiments_import_is_there(tmp_path: Path) -> None:
    (tmp_path / "resources").mkdir()
    (tmp_path / "resources" / "helper.py").write_text("answer = 42\n")
    path = tmp_path / "tf.py"
    path.write_text(IMPORTS + "\nimport helper\nassert helper.answer == 42\n")
    names = Namespace(ignore_note, Library(tmp_path), [tmp_path / "resources"])
    (function,) = load_transfer_functions(path, module=names.module, scope=names.scope)
    function.function(0.0, None)


def test_a_missing_name_of_a_module_can_be_imported_and_is_named_where_it_is_used(
    tmp_path: Path, golden: Golden
) -> None:
    path = tmp_path / "tf.py"
    path.write_text(
        "from rospy import Nowhere\nimport keras.models, keras.layers\nfrom keras.models import Sequential\n"
    )
    told = Findings()
    names = Namespace(told.add, Library(tmp_path))
    module = names.scope.run(path)
    assert told.messages == ["module 'keras' is not installed: code that uses it fails"]
    with golden.raises(ImportError, match="'rospy'.*'Nowhere'"):
        module.Nowhere()
    with golden.raises(ImportError, match="'keras'"):
        module.Sequential()


Opened = Callable[..., Run]

NODE = """
import rospy
import smach
from gazebo_msgs.srv import GetModelState, SetModelState
from std_msgs.msg import Float64

heard = []
rospy.Subscriber("/from_machine", Float64, lambda message: heard.append(message.data))
publisher = rospy.Publisher("/to_machine", Float64)

@nrp.MapCSVRecorder("rows", filename="heard.csv", headers=["t", "heard"])
@nrp.Robot2Neuron()
def node(t, rows):
    rows.record_entry(t, list(heard))
    publisher.publish(t)
    try:
        rospy.ServiceProxy("/gazebo/set_model_stat", SetModelState)(None)
    except rospy.ServiceException as error:
        assert "not available" in str(error)
"""
MACHINE = """
import rospy
import smach
from std_msgs.msg import Float64
from hbp_nrp_excontrol.nrp_states import ClockDelayState, ClockMonitorState, SpawnSphere, SpawnBox
from hbp_nrp_excontrol.nrp_states import DestroyModel, SetModelPose, TranslateModelState
from geometry_msgs.msg import Point, Vector3
from smach_ros import MonitorState

def talk(userdata):
    publisher = rospy.Publisher("/from_machine", Float64, queue_size=1)
    rate = rospy.Rate(25)
    while not rospy.is_shutdown() and rospy.get_time() < 0.3:
        publisher.publish(rospy.get_time())
        rate.sleep()
    message = rospy.wait_for_message("/to_machine", Float64)
    publisher.publish(100 + message.data)
    return "succeeded"

add = smach.StateMachine.add
clock, late = ClockMonitorState(lambda ud, t: t < 0.2), lambda ud, m: m.data < 0.22
hear = MonitorState("/to_machine", Float64, late)
sm = smach.StateMachine(outcomes=["DONE", "ERROR", "preempted"])
with sm:
    add("delay", ClockDelayState(0.1), transitions={"valid": "delay", "invalid": "until"})
    add("until", clock, transitions={"valid": "until", "invalid": "hear"})
    add("hear", hear, transitions={"valid": "hear", "invalid": "ball", "preempted": "ERROR"})
    ball = SpawnSphere("ball", radius=0.2, position=Point(1, 2, 3), gravity_factor=0, color="Gazebo/Red")
    add("ball", ball, transitions={"succeeded": "box", "aborted": "ERROR"})
    box = SpawnBox(model_name="box", size=Vector3(1, 1, 1), position=Point(0, 5, 1), color="Gazebo/Black")
    add("box", box, transitions={"succeeded": "place", "aborted": "ERROR"})
    add("place", SetModelPose("box", Point(0, 6, 1)), transitions={"succeeded": "move", "aborted": "ERROR"})
    move = TranslateModelState("ball", 0, 0.5, 0)
    add("move", move, transitions={"succeeded": "destroy", "aborted": "ERROR"})
    add("destroy", DestroyModel("box"), transitions={"succeeded": "talk", "aborted": "ERROR"})
    add("talk", smach.CBState(talk, outcomes=["succeeded"]), transitions={"succeeded": "DONE"})
"""
BIBI = '<bibi><transferFunction src="node.py"/></bibi>'
EXC = """<ExD><bibiConf src="n.bibi"/><timeout>0.5</timeout>
<experimentControl><stateMachine src="n.exd"/></experimentControl></ExD>"""


def test_machines_and_functions_talk_in_simulated_time(opened: Opened, corpus: Path) -> None:
    folder = corpus / "node"
    folder.mkdir()
    for name, text in {"node.py": NODE, "n.exd": MACHINE, "n.bibi": BIBI, "n.exc": EXC}.items():
        (folder / name).write_text(text)
    run = opened("node/n.exc")
    run.run()
    result = run.result()
    assert not result.failures
    names = [model.name for model in run.world.scene.models]
    assert "ball" in names
    assert "box" not in names
    assert run.world.model_motion("ball").pose.position == pytest.approx((1.0, 2.5, 3.0))
    assert not [warning for warning in map(str, result.problems) if "box" in warning]
    last = run.loop.functions[0].adapters["rows"].rows[-1]
    # what is published at the end of a step is heard at the end of the next: 0.24 s at 0.28 s; the summed
    # steps of 0.22 s are 0.21999999999999997, which is still before 0.22
    assert [float(last[0]), last[1]] == [pytest.approx(0.48), "[0.28, 100.32]"]


@pytest.mark.parametrize(
    "rotation",
    [
        Vector3(0.0, 0.0, 1.5), {"x": 0.0, "y": 0.0, "z": 1.5}, (0.0, 0.0, 1.5),
        Quaternion(0.0, 0.0, sin(0.75), cos(0.75)), [0.0, 0.0, sin(0.75), cos(0.75)],
        {"x": 0.0, "y": 0.0, "z": sin(0.75), "w": cos(0.75)},
    ],
)  # fmt: skip
def test_a_machine_may_give_a_rotation_in_any_form(rotation: Any) -> None:
    for place in (Point(1.0, 2.0, 3.0), {"x": 1, "y": 2, "z": 3}, (1, 2, 3)):
        pose = pose_of(model_states.to_pose(place, rotation))
        assert pose.position == (1.0, 2.0, 3.0)
        assert pose.rpy == pytest.approx((0.0, 0.0, 1.5))


GONE = """
from hbp_nrp_excontrol.nrp_states import DestroyModel
from smach import StateMachine
sm = StateMachine(outcomes=["DONE"])
with sm:
    StateMachine.add("gone", DestroyModel("robot"), transitions={"succeeded": "DONE"})
"""


def test_a_robot_that_a_machine_removes_is_not_in_the_results(opened: Opened, corpus: Path) -> None:
    folder = corpus / "gone"
    folder.mkdir()
    bibi = "<bibi><bodyModel>husky_model/model.sdf</bodyModel></bibi>"
    for name, text in {"n.exd": GONE, "n.bibi": bibi, "n.exc": EXC}.items():
        (folder / name).write_text(text)
    run = opened("gone/n.exc")
    run.run_until(0.1)
    assert run.result().final_pose == {}
