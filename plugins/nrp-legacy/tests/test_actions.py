"""Trajectories that are sent as goals of actions, and the physics that Gazebo tells of."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from nrp_legacy.convert.folder import write_folder
from nrp_legacy.reader import read_exc

from nrp_core.experiment.reading.reader import read_yaml
from nrp_core.experiment.running.run import Run

Opened = Callable[..., Run]

GOAL = """
import actionlib, rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

def goal_for(joint, *points):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = [joint]
    for seconds, position in points:
        point = JointTrajectoryPoint()
        point.positions = [position]
        point.time_from_start = rospy.Duration(seconds)
        goal.trajectory.points.append(point)
    return goal
"""
FUNCTION = (
    GOAL
    + """
heard = []

@nrp.MapVariable("client", initial_value=None)
@nrp.MapCSVRecorder("rows", filename="rows.csv", headers=["t", "state", "error"])
@nrp.Robot2Neuron()
def send(t, client, rows):
    if client.value is None:
        client.value = actionlib.SimpleActionClient("/arm/follow", FollowJointTrajectoryAction)
        assert client.value.wait_for_server(rospy.Duration(1.0))
        done = lambda status, result: heard.append((status, result.error_code))
        client.value.send_goal(goal_for("JOINT", (0.2, 0.0), (0.4, 0.5)), done_cb=done)
    result = client.value.get_result()
    rows.record_entry(t, client.value.get_state(), "" if result is None else result.error_code)
    assert (heard == [(3, 0)]) == (client.value.get_state() == actionlib.GoalStatus.SUCCEEDED)
"""
)
PHYSICS = """
import rospy
from gazebo_msgs.srv import GetPhysicsProperties, SetPhysicsProperties

@nrp.Robot2Neuron()
def physics(t):
    p = rospy.ServiceProxy("/gazebo/get_physics_properties", GetPhysicsProperties)()
    set_physics = rospy.ServiceProxy("/gazebo/set_physics_properties", SetPhysicsProperties)
    assert p.success and p.gravity.z in (-9.8, -1.62)
    assert 0 < p.time_step <= 0.02 and p.ode_config.sor_pgs_iters == 50
    assert set_physics(p.time_step, p.max_update_rate, p.gravity, p.ode_config).success
    assert not set_physics(p.time_step / 2, p.max_update_rate, p.gravity, p.ode_config).success
    p.gravity.z = -1.62
    assert set_physics(p.time_step, p.max_update_rate, p.gravity, p.ode_config).success
"""
MACHINE = (
    GOAL
    + """
import smach
from smach_ros import SimpleActionState
from smach import StateMachine

sm = StateMachine(outcomes=["succeeded", "aborted", "preempted"])
with sm:
    move = SimpleActionState("/arm/follow_joint_trajectory", FollowJointTrajectoryAction,
                             goal=goal_for("arm_1_joint", (0.2, 0.4)))
    StateMachine.add("move", move, {"succeeded": "back"})
    back = SimpleActionState("/arm/follow_joint_trajectory", FollowJointTrajectoryAction,
                             goal=goal_for("arm_1_joint", (0.2, -0.3)))
    StateMachine.add("back", back)
"""
)


def run_of(opened: Opened, corpus: Path, code: str, machine: str = "") -> Run:
    folder = corpus / "arm_2017"
    (folder / "tf.py").write_text(code)
    (folder / "machine.py").write_text(machine)
    (folder / "a.bibi").write_text(
        "<bibi><brainModel>brain_model/idle_brain.py</brainModel><bodyModel>arm_robot/arm.sdf</bodyModel>"
        '<transferFunction src="tf.py"/></bibi>'
    )
    control = (
        '<experimentControl><stateMachine id="m" src="machine.py"/></experimentControl>' if machine else ""
    )
    (folder / "a.exc").write_text(
        '<ExD><environmentModel src="arena/arena.sdf"/><bibiConf src="a.bibi"/>'
        f"<timeout>2</timeout>{control}</ExD>"
    )
    return opened("arm_2017/a.exc")


def position(run: Run, joint: str = "arm_1_joint") -> float:
    joints = run.world.joint_states("robot")
    return float(joints.positions[joints.names.index(joint)])


UNSEEN = FUNCTION.replace('"JOINT"', '"arm_1" + "_joint"')
"""Code in whose text the name of the joint does not stand."""


def without_controllers(corpus: Path) -> None:
    path = corpus / "models" / "arm_robot" / "arm.sdf"
    path.write_text(path.read_text().replace("libgeneric_controller_plugin.so", "libno_such.so"))


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("of_file", "code"),
    [(True, UNSEEN), (False, FUNCTION.replace("JOINT", "arm_1_joint")), (False, UNSEEN)],
    ids=["controller of the file", "controller for the code", "no controller"],
)
def test_a_joint_follows_the_points_at_their_times_and_the_goal_succeeds(
    opened: Opened, corpus: Path, of_file: bool, code: str
) -> None:
    if not of_file:
        without_controllers(corpus)
    run = run_of(opened, corpus, code)
    run.run_until(0.2)
    assert position(run) == pytest.approx(0.0, abs=0.01)
    run.run_until(0.4)
    assert 0.1 < position(run) < 0.46
    run.run_until(1.0)
    assert position(run) == pytest.approx(0.5, abs=0.05)
    assert run.result().failures == []
    rows = run.loop.functions[0].adapters["rows"].rows
    assert rows[0][1:] == ["1", ""]
    assert next(row for row in rows if row[1] == "3")[2] == "0"
    assert rows[-1][1] == "3"


def test_joints_that_no_model_has_are_reported_once_and_the_goal_is_aborted(
    opened: Opened, corpus: Path
) -> None:
    run = run_of(opened, corpus, FUNCTION.replace("JOINT", "elbow").replace("heard ==", "heard != heard and"))
    run.run_until(0.1)
    told = [text for text in map(str, run.result().problems) if "elbow" in text]
    assert len(told) == 1
    assert "moves joints that do not exist: elbow" in told[0]
    assert run.loop.functions[0].adapters["rows"].rows[-1][1] == "4"


def test_a_goal_whose_model_is_taken_out_is_aborted_and_the_run_goes_on(opened: Opened, corpus: Path) -> None:
    without_controllers(corpus)
    run = run_of(opened, corpus, UNSEEN.replace("heard ==", "heard != heard and"))
    run.run_until(0.1)
    run.world.delete("robot")
    run.run_until(0.3)
    assert run.loop.functions[0].adapters["rows"].rows[-1][1] == "4"
    assert any("the action '/arm/follow' is aborted" in text for text in map(str, run.result().problems))


def test_a_state_machine_waits_until_its_goal_is_reached(opened: Opened, corpus: Path) -> None:
    run = run_of(opened, corpus, "", MACHINE)
    run.run_until(0.22)
    assert position(run) > 0.15
    run.run_until(1.0)
    assert position(run) == pytest.approx(-0.3, abs=0.05)


def test_physics_are_reported_and_gravity_can_be_set(opened: Opened, corpus: Path) -> None:
    run = run_of(opened, corpus, PHYSICS)
    run.run_until(0.04)
    assert run.result().failures == []
    assert run.world.scene.gravity == (0.0, 0.0, -1.62)


TOPIC = """
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

@nrp.MapRobotPublisher("arm", Topic("/arm_controller/command", JointTrajectory))
@nrp.Robot2Neuron()
def move(t, arm):
    if t < 0.03:
        message, point = JointTrajectory(), JointTrajectoryPoint()
        message.header.stamp = rospy.Time.now()
        message.joint_names = ["arm_1_joint"]
        point.positions, point.velocities, point.time_from_start = [0.5], [0.0], rospy.Duration(0.3)
        message.points.append(point)
        arm.send_message(message)
"""


def test_a_trajectory_on_a_topic_leads_the_joints_that_it_names(opened: Opened, corpus: Path) -> None:
    run = run_of(opened, corpus, TOPIC)
    run.run_until(0.18)
    assert position(run) == pytest.approx(0.27, abs=0.05)
    run.run_until(1.0)
    assert run.result().failures == []
    assert position(run) == pytest.approx(0.5, abs=0.02)


def test_an_imported_robot_follows_trajectories_too(opened: Opened, corpus: Path, tmp_path: Path) -> None:
    run_of(opened, corpus, TOPIC).close()
    write_folder(read_exc(corpus / "arm_2017/a.exc", [f"models=[{corpus / 'models'}]"]), tmp_path / "new")
    with Run(read_yaml(tmp_path / "new" / "experiment.yaml")) as run:
        run.run_until(1.0)
        assert run.result().failures == []
        assert position(run) == pytest.approx(0.5, abs=0.02)
