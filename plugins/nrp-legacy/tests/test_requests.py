"""Requests and messages take what ROS 1 could write as a number; answers have the platform's fields."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.experiment.running.run import Run

FUNCTIONS = """
import decimal, fractions, rospy
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import GetModelState, GetModelStateRequest, SetModelState
from std_msgs.msg import Float64
get_state = rospy.ServiceProxy("gazebo/get_model_state", GetModelState)
set_state = rospy.ServiceProxy("gazebo/set_model_state", SetModelState)
half = rospy.Publisher("/half", Float64, queue_size=1)

@nrp.MapRobotSubscriber("heard", Topic("/half", Float64))
@nrp.MapVariable("seen", initial_value=[])
@nrp.Robot2Neuron()
def place(t, heard, seen):
    state = ModelState()
    state.model_name = "left_vr_screen"
    state.pose = get_state("left_vr_screen", "world").pose
    state.scale = get_state(GetModelStateRequest("left_vr_screen", "world")).scale
    state.pose.position.x = decimal.Decimal(205) / 100
    state.pose.position.y = np.float32(0.5)
    state.pose.position.z = np.array([0.25])
    assert set_state(state).success
    half.publish(fractions.Fraction(1, 2))
    seen.value.append((state.scale.x, heard.value and heard.value.data))
"""


def test_decimals_fractions_and_arrays_of_one_number_are_numbers(
    opened: Callable[..., Run], corpus: Path
) -> None:
    folder = corpus / "requests"
    folder.mkdir()
    (folder / "tf.py").write_text(FUNCTIONS)
    (folder / "x.bibi").write_text('<bibi><transferFunction src="tf.py"/></bibi>')
    room = '<environmentModel src="arena/arena.sdf"/>'
    (folder / "x.exc").write_text(f'<ExD><timeout>1.0</timeout>{room}<bibiConf src="x.bibi"/></ExD>')
    run = opened("requests/x.exc")
    run.run_until(0.1)
    assert not run.result().failures
    assert run.world.model_motion("left_vr_screen").pose.position == pytest.approx((2.05, 0.5, 0.25))
    (function,) = run.loop.functions
    assert function.adapters["seen"].value[-1] == (1.0, 0.5)  # type: ignore[attr-defined]


LISTS = """
import numpy as np, rospy
from gazebo_msgs.srv import SetModelConfiguration
configure = rospy.ServiceProxy("gazebo/set_model_configuration", SetModelConfiguration)

@nrp.MapVariable("answers", initial_value=[])
@nrp.Robot2Neuron()
def move(t, answers):
    joints, angles = ["arm_1_joint"], np.array([0.5])
    answers.value.append(configure("robot", "", joints, angles).success)
    named = {"joint_names": joints, "joint_positions": angles}
    answers.value.append(configure(model_name="robot", **named).success)
"""


def test_a_list_of_one_number_in_a_request_stays_a_list(opened: Callable[..., Run], corpus: Path) -> None:
    folder = corpus / "lists"
    folder.mkdir()
    (folder / "tf.py").write_text(LISTS)
    body = "<bodyModel>arm_robot/arm.sdf</bodyModel>"
    (folder / "x.bibi").write_text(f'<bibi>{body}<transferFunction src="tf.py"/></bibi>')
    (folder / "x.exc").write_text('<ExD><timeout>1.0</timeout><bibiConf src="x.bibi"/></ExD>')
    run = opened("lists/x.exc")
    run.run_until(0.02)
    assert not run.result().failures
    (function,) = run.loop.functions
    assert function.adapters["answers"].value == [True, True]  # type: ignore[attr-defined]
    states = run.world.joint_states("robot")
    assert states.positions[states.names.index("arm_1_joint")] == pytest.approx(0.5, abs=0.05)
