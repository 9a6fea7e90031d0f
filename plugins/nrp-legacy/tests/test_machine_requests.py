"""What state machines ask of the simulation is reported where it cannot be answered."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

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


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("right", "wrong", "code", "words"),
    [
        ("", "", None, ""),
        ('get_model_state", GetModelState, req', 'get_model_state", GetModelStateRequest, req', Code.NRP280,
         "service /gazebo/get_model_state is of type GetModelState, not GetModelStateRequest"),
        ('get_model_state", GetModelState)', 'get_model_state", String)', Code.NRP272,
         "service /gazebo/get_model_state is of type GetModelState, not String"),
        ('Request("robot"', 'Request("robto"', Code.NRP280, "the scene has no model 'robto'"),
        ("/robot/odom", "/robot/odmo", Code.NRP212, "no message came on '/robot/odmo', to which the code "
         "of the experiment listens; did you mean '/robot/odom'?"),
        ('odom", Odometry', 'odom", Bool', Code.NRP240, "'/robot/odom' carries nav_msgs/msg/Odometry, and"),
        ("rospy.sleep(0.05)", "1 / 0", Code.NRP272, "gate.exd:19 stopped by ZeroDivisionError: division by"),
        ('@smach.cb_interface(outcomes=["done"])\n', "", Code.NRP248, "'tell' does not name its outcomes, a"),
        ('self, outcomes=["done"]', "self", Code.NRP248, "the state 'ask' does not name its outcomes, and S"),
        ('smach.State.__init__(self, outcomes=["done"])', "pass", Code.NRP272, "Ask.__init__ does not call"),
        ('(outcomes=["done"])\n', "\n", Code.NRP272, "write @cb_interface(outcomes=['succeeded'])"),
        ('    smach.StateMachine.add("hear"', 'smach.StateMachine.add("hear"', Code.NRP272,
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
    found = [one for one in run.problems if one.code not in (Code.NRP204, Code.NRP258)]
    assert (code in {one.code for one in found}) == bool(code)
    assert code or not found
    assert words in "\n".join(map(str, found))


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
