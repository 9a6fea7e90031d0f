"""What state machines wait for, ask for and call is doubted where it is probably not meant."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from nrp_legacy.machine_doubts import doubts_of

from nrp_core.clock import NS_PER_S
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

_DURATION_S = 60
_STATES = """import time
import rospy
import smach
import smach_ros
from gazebo_msgs.srv import GetModelState, GetModelStateRequest
from hbp_nrp_excontrol import nrp_states as states
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool, String

LIMIT_S = 5


def is_near(ud, pose):
    return pose.position.x < 0.1 and pose.orientation.z > -0.5


@smach.cb_interface(outcomes=["done"])
def tell(userdata):
    rospy.sleep(0.05)
    return "done"


class Ask(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["done"])

    def execute(self, userdata):
        rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)("robot", "")
        return "done"


sm = smach.StateMachine(outcomes=["DONE", "ERROR", "preempted"])
with sm:
    smach.StateMachine.add("clock", states.WaitToClockState(0.04), {"invalid": "delay"})
    smach.StateMachine.add("delay", states.ClockDelayState(0.04), {"invalid": "limit"})
    smach.StateMachine.add("limit", states.ClockMonitorState(
        lambda ud, t: t.secs > LIMIT_S
    ), {"invalid": "pose"})
    smach.StateMachine.add("pose", states.RobotPoseMonitorState(is_near), {"invalid": "tell"})
    smach.StateMachine.add("tell", smach.CBState(tell), {"done": "ask"})
    smach.StateMachine.add("ask", Ask(), {"done": "serve"})
    smach.StateMachine.add("serve", smach_ros.ServiceState(
        "/gazebo/get_model_state", GetModelState, request=GetModelStateRequest("robot", "")
    ), {"succeeded": "hear", "aborted": "ERROR"})
    smach.StateMachine.add("hear", smach_ros.MonitorState(
        "/robot/odom", Odometry, lambda ud, m: m.pose.pose.position.x < 0.2
    ), {"invalid": "DONE"})
"""


@pytest.mark.parametrize(
    ("right", "wrong", "code", "words"),
    [
        ("", "", None, ""),
        ("ClockState(0.04)", "ClockState(70)", Code.NRP248, "waits until 70 s, and the run ends at 60 s"),
        ("DelayState(0.04)", "DelayState(waitfor=60)", Code.NRP248, "waits for 60 s, and the run ends"),
        ("DelayState(0.04)", "DelayState(waittime=60)", Code.NRP248, "waits for 60 s, and the run ends"),
        ("ClockState(0.04)", 'ClockState("0.04")', Code.NRP248, "waits for a text, '0.04': the platform"),
        ("DelayState(0.04)", 'DelayState(float("0.04"))', None, ""),
        ("DelayState(0.04)", "DelayState(-1)", Code.NRP248, "waits for -1 s, which is negative: it ends at"),
        ("LIMIT_S = 5", "LIMIT_S = 65", Code.NRP327, "'t.secs > 65' is never true: the run is from 0 s to 6"),
        ("t.secs > LIMIT_S", "not t.nsecs < 2e9", Code.NRP327, "is always true: nsecs are the nanoseconds s"),
        ("z > -0.5", "z > -1.5", Code.NRP327, "'pose.orientation.z > -1.5' is always true: a part of a quat"),
        ("return pose", "pose", Code.NRP237, "'is_near' returns nothing: the state ends with its first"),
        ("return pose.position", "return True or pose.position", None, ""),  # computed, so not judged
        ("m: m.pose.pose.position.x < 0.2", "m: True", Code.NRP327, "the condition is always true: the stat"),
        ("m: m.pose.pose.position.x < 0.2", "m: True, 5", None, ""),
        ("m: m.pose.pose.position.x < 0.2", "m: True, max_checks=5", None, ""),
        ("pose.position.x < 0.1 and pose.orientation.z > -0.5", "True", Code.NRP327, "is always true: the"),
        ("return pose.position.x < 0.1 and pose.orientation.z > -0.5",
         "if pose.position.x < 3:\n        return True", None, ""),
        ("Odometry, lambda ud, m: m.pose.pose.position.x < 0.2", "Bool, lambda ud, m: m.data == 'on'",
         Code.NRP327, "compares a bool with a text: they are never equal"),
        ("Odometry, lambda ud, m: m.pose.pose.position.x < 0.2", "String, lambda ud, m: m.data != 1",
         Code.NRP327, "compares a text with a number: they are never equal"),
        ("sleep(0.05)", "sleep(500)", Code.NRP248, "'rospy.sleep(500)' ends after the run of 60 s"),
        ("sleep(0.05)", "sleep(rospy.Duration(60))", Code.NRP248, "ends after the run of 60 s"),
        ("rospy.sleep", "time.sleep", Code.NRP255, "'time.sleep(0.05)' waits in simulated time here"),
        ("rospy.sleep(0.05)", "userdata.t = time.time()", Code.NRP243, "'time.time' reads the clock on the"),
        ("PoseMonitorState(is_near)", "PoseMonitorState(lambda ud, p: p.position.x < 0.1)", Code.NRP327,
         "the callback 'is_near' is given to no state"),
        ('add("ask", Ask()', 'add("ask", smach.CBState(tell)', Code.NRP327, "the state 'Ask' is in no machi"),
        ("LIMIT_S = 5", "LIMIT_S = 5; rospy.Subscriber('/said', String)", Code.NRP327,
         "the subscriber of '/said' does not have a callback"),
        ("LIMIT_S = 5", "LIMIT_S = 5; rospy.Subscriber('/said', String, callback=print)", None, ""),
    ],
)  # fmt: skip
def test_a_doubtful_state_is_reported_before_a_run(
    tmp_path: Path, right: str, wrong: str, code: Code | None, words: str
) -> None:
    assert right in _STATES
    path = tmp_path / "machine.exd"
    path.write_text(_STATES.replace(right, wrong, 1))
    found = list(doubts_of(path, _DURATION_S * NS_PER_S))
    assert [one.code for one in found] == ([] if code is None else [code])
    assert all(words in one.message for one in found)


@pytest.mark.parametrize(
    ("right", "wrong", "code", "words"),
    [
        ("", "", None, ""),
        ('get_model_state", GetModelState, req', 'get_model_state", GetModelStateRequest, req', Code.NRP280,
         "service /gazebo/get_model_state is of type GetModelState, not GetModelStateRequest"),
        ('get_model_state", GetModelState)', 'get_model_state", String)', Code.NRP273,
         "service /gazebo/get_model_state is of type GetModelState, not String"),
        ('Request("robot"', 'Request("robto"', Code.NRP280, "the scene has no model 'robto'"),
        ("x < 0.1 and", "x < 900 and", Code.NRP248, "'pose.position.x < 900': 900 m is outside the scene, 1"),
        ("/robot/odom", "/robot/odmo", Code.NRP268, "no message came on '/robot/odmo', to which the code "
         "of the experiment listens; did you mean '/robot/odom'?"),
        ('odom", Odometry', 'odom", Bool', Code.NRP228, "'/robot/odom' carries nav_msgs/msg/Odometry, and"),
        ("rospy.sleep(0.05)", "1 / 0", Code.NRP273, "gate.exd:19 stopped by ZeroDivisionError: division by"),
        ("DelayState(0.04)", "DelayState(1.98)", Code.NRP248, "the wait of the state 'delay' ends at 2.02 s"),
        ('@smach.cb_interface(outcomes=["done"])\n', "", Code.NRP327, "'tell' does not name its outcomes, a"),
        ('self, outcomes=["done"]', "self", Code.NRP327, "the state 'ask' does not name its outcomes, and S"),
        ('smach.State.__init__(self, outcomes=["done"])', "pass", Code.NRP273, "Ask.__init__ does not call"),
        ('(outcomes=["done"])\n', "\n", Code.NRP273, "write @cb_interface(outcomes=['succeeded'])"),
        ('    smach.StateMachine.add("hear"', 'smach.StateMachine.add("hear"', Code.NRP273,
         "a state is added outside of a machine"),
    ],
)  # fmt: skip
def test_a_machine_that_cannot_do_what_it_asks_is_reported_by_its_run(
    opened: Callable[..., Run], corpus: Path, right: str, wrong: str, code: Code | None, words: str
) -> None:
    assert right in _STATES
    near = _STATES.replace("t.secs > LIMIT_S", "False").replace(right, wrong, 1)
    (corpus / "poses_2017" / "gate.exd").write_text(near)
    run = opened("poses_2017/poses.exc")
    run.run()
    found = [one for one in run.problems if one.code not in (Code.NRP258, Code.NRP274)]
    assert (code in {one.code for one in found}) == bool(code)
    assert code or not found
    assert words in "\n".join(map(str, found))


def test_the_machines_of_the_corpus_are_not_doubted() -> None:
    machines = list((Path(__file__).parent / "corpus").rglob("*.exd"))
    assert len(machines) > 3
    assert [str(one) for path in machines for one in doubts_of(path, 600 * NS_PER_S)] == []


@pytest.mark.parametrize(("joint", "is_reported"), [("back_left_joint", False), ("back_left_jont", True)])
def test_a_request_of_a_function_that_is_refused_is_reported(
    opened: Callable[..., Run], corpus: Path, joint: str, is_reported: bool
) -> None:
    path = corpus / "screens_2016/screen.py"
    path.write_text(path.read_text().replace("husky::back_left_joint", joint))
    run = opened("screens_2016/ExDBraitenbergHuskyScreens.exc")
    run.run_until(0.1)
    refused = [one.message for one in run.problems if one.code is Code.NRP280]
    expected = "service /gazebo/apply_joint_effort: no model has joint 'back_left_jont'"
    assert [one.startswith(expected) for one in refused] == [True] * is_reported
