"""Robots that share topics, joints that only code tells of, and machines that talk with functions."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from nrp_legacy.convert.folder import write_folder
from nrp_legacy.reader import read_exc
from nrp_legacy.topics import with_commanded_joints

from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.reader import read_yaml
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Finding, Level
from nrp_core.scene.model import Joint, Model

Made = Callable[..., Experiment]
Opened = Callable[[Experiment], Run]

TWIST = "geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=0.5))"
CART = "husky_model/model.sdf"


@pytest.fixture
def made(corpus: Path) -> Made:
    """Writes an experiment in an empty room: functions, robots by their ids, and a state machine."""

    def write(functions: str, robots: dict[str, str], machine: str = "") -> Experiment:
        folder = corpus / "own"
        folder.mkdir(exist_ok=True)
        poses = (f'<robotPose robotId="{name}" y="{2 * i}" z="0.1"/>' for i, name in enumerate(robots))
        control = '<experimentControl><stateMachine src="sm.exd"/></experimentControl>' if machine else ""
        (folder / "own.exc").write_text(
            f'<ExD><timeout>0.5</timeout><environmentModel src="arena/arena.sdf">{"".join(poses)}'
            f'</environmentModel><bibiConf src="own.bibi"/>{control}</ExD>'
        )
        bodies = (f'<bodyModel robotId="{name}">{model}</bodyModel>' for name, model in robots.items())
        (folder / "own.bibi").write_text(
            f'<bibi>{"".join(bodies)}<transferFunction type="PythonTransferFunction" src="tf.py"/></bibi>'
        )
        (folder / "tf.py").write_text(functions)
        (folder / "sm.exd").write_text(machine)
        return read_exc(folder / "own.exc", [f"models=[{corpus / 'models'}]"])

    return write


@pytest.fixture
def opened() -> Iterator[Opened]:
    """Opens and runs an experiment."""
    with ExitStack() as stack:

        def play(experiment: Experiment) -> Run:
            run = stack.enter_context(Run(experiment))
            run.run()
            return run

        yield play


@pytest.fixture
def absolute(corpus: Path) -> str:
    """A cart whose topics are the same for each robot of its model."""
    folder = corpus / "models" / "absolute"
    shutil.copytree(corpus / "models" / "husky_model", folder)
    text = (folder / "model.sdf").read_text()
    text = text.replace("<imageTopicName>camera", "<imageTopicName>/eye").replace(
        "<torque>", "<commandTopic>/drive</commandTopic><torque>"
    )
    (folder / "model.sdf").write_text(text)
    return "absolute/model.sdf"


DRIVE = f"@nrp.Neuron2Robot(Topic('/drive', geometry_msgs.msg.Twist))\ndef drive(t):\n    return {TWIST}\n"


def test_robots_of_one_model_obey_one_topic_and_see_on_two(made: Made, opened: Opened, absolute: str) -> None:
    result = opened(made(DRIVE, {"one": absolute, "two": absolute})).result()
    assert result.final_pose["one"]["x"] == pytest.approx(0.25, abs=0.05)
    assert result.final_pose["two"]["x"] == pytest.approx(result.final_pose["one"]["x"], abs=0.01)
    told = "\n".join(map(str, result.problems))
    assert "'/eye' is already in use: 'two' publishes on '/two/eye'" in told
    assert "/drive" not in told


def test_robots_that_share_a_topic_are_imported(
    made: Made, opened: Opened, absolute: str, tmp_path: Path
) -> None:
    experiment = made(DRIVE, {"one": absolute, "two": absolute})
    report = write_folder(experiment, tmp_path / "new")
    assert "/drive: shared by several parts of the scene" in report.kept
    again = opened(read_yaml(tmp_path / "new" / "experiment.yaml")).result()
    assert again.final_pose == opened(experiment).result().final_pose


ARM = Model("arm", (), (Joint("j1", "revolute", "a", "b"), Joint("fixed", "fixed", "a", "b")))


@pytest.mark.parametrize(
    ("code", "topic", "kind"),
    [
        ("'/robot/j1/cmd_pos'", "/robot/j1/cmd_pos", "position"),
        ("'robot/j1/vel'", "/robot/j1/vel", "velocity"),
        ("'/robot/j1/torque'", "/robot/j1/torque", "effort"),
        ("'/nao/j1_position_controller/command'", "/nao/j1_position_controller/command", "position"),
        ("'/nao/j1_velocity_controller/command'", "/nao/j1_velocity_controller/command", "velocity"),
        ("'/nao/j1_controller/command'", "/nao/j1_controller/command", "position"),
        ("'/j1_pos_cntr/command'", "/j1_pos_cntr/command", "position"),
        ("'/nao/j1_vel_cntr/command'", "/nao/j1_vel_cntr/command", "velocity"),
        ("'/j{}_pos_cntr/command'.format(i)", "/j1_pos_cntr/command", "position"),
        ("'/robot/j' + str(i) + '/cmd_pos'", "/robot/j1/cmd_pos", "position"),
        ("'/robot/%s/cmd_pos' % name", "/robot/j1/cmd_pos", "position"),
        ("'/robot/{}/cmd_pos'.format(name)", "/robot/j1/cmd_pos", "position"),
        ("'/robot/' + name + '/cmd_vel'", "/robot/j1/cmd_vel", "velocity"),
        ("'/%s/j1/cmd_pos' % robot", "/arm/j1/cmd_pos", "position"),
        ("'/%s/%s/cmd_pos' % (robot, joint)", "/arm/j1/cmd_pos", "position"),
        ("'/' + robot + '/j1/cmd_pos'", "/arm/j1/cmd_pos", "position"),
    ],
)
def test_a_joint_is_commanded_by_any_name_that_code_has_for_it(code: str, topic: str, kind: str) -> None:
    (controller,) = with_commanded_joints(ARM, [f"pub = rospy.Publisher({code}, Float64)"]).controllers
    assert (controller.topic, controller.joint, controller.kind) == (topic, "j1", kind)


def test_names_of_another_robot_or_of_no_joint_command_nothing() -> None:
    codes = ["'/other/j1/cmd_pos'", "'/robot/fixed/cmd_pos'", "'/husky/cmd_vel'"]
    assert with_commanded_joints(ARM, codes, {"other"}).controllers == ()


def test_a_plugin_that_ran_controllers_is_reported_only_where_joints_ignore_commands() -> None:
    told, another = (
        Finding(Code.NRP260, f"the plugin '{name}' is unknown and has no effect", Level.WARNING, subject=name)
        for name in ("gazebo_ros_control", "another")
    )
    arm = replace(ARM, warnings=(told, another))
    assert with_commanded_joints(arm, ["'/nao/j1_controller/command'"]).warnings == (another,)
    assert with_commanded_joints(arm, ["'/husky/cmd_vel'"]).warnings == (told, another)


def test_joints_that_a_trajectory_names_hold_where_it_puts_them() -> None:
    code = "point = JointTrajectory(joint_names=['j1', 'fixed'])"
    (controller,) = with_commanded_joints(ARM, [code]).controllers
    assert (controller.topic, controller.kind, controller.initial) == ("/arm/j1/cmd_pos", "position", None)


def test_a_controller_of_the_file_stays_the_only_one_in_an_import(
    made: Made, corpus: Path, opened: Opened, tmp_path: Path
) -> None:
    path = corpus / "models" / "arm_robot" / "arm.sdf"
    path.write_text(re.sub("<pid>.*?</pid>", "", path.read_text()))
    functions = (
        "@nrp.Neuron2Robot(Topic('/robot/arm_2_joint/cmd_pos', std_msgs.msg.Float64))\n"
        "def aim(t):\n    return std_msgs.msg.Float64(0.2)\n"
    )
    write_folder(made(functions, {"robot": "arm_robot/arm.sdf"}), tmp_path / "new")
    assert opened(read_yaml(tmp_path / "new" / "experiment.yaml")).result().failures == []


HEARING = """
@nrp.MapRobotSubscriber("said", Topic('/said', std_msgs.msg.String))
@nrp.MapCSVRecorder("rows", filename="said.csv", headers=["t", "said"])
@nrp.Robot2Neuron()
def hear(t, said, rows):
    rows.record_entry(t, said.value.data if said.value else '')
    if t == 0.1:
        clientLogger.info("GO", "now")
"""
SAYING = """
import rospy, smach
import hbp_nrp_excontrol.nrp_states as states
from smach_ros import SimpleActionState, ConditionState
from std_msgs.msg import String
publisher = rospy.Publisher('/said', String)
@smach.cb_interface(outcomes=['done'])
def say(_data):
    publisher.publish('went')
    return 'done'
sm = smach.StateMachine(outcomes=['done', 'preempted'])
with sm:
    wait = states.WaitForClientLogState(lambda ud, text: 'GO' not in text.message)
    smach.StateMachine.add('wait', wait, {'valid': 'wait', 'invalid': 'say'})
    smach.StateMachine.add('say', smach.CBState(say))
"""


def test_a_machine_waits_for_the_output_of_a_function_and_its_topics_are_not_reported_as_silent(
    made: Made, opened: Opened, tmp_path: Path
) -> None:
    experiment = made(HEARING, {"robot": CART}, SAYING)
    run = opened(experiment)
    assert "/said" not in "\n".join(map(str, run.result().problems))
    (hear,) = run.loop.functions
    said = [row[1] for row in hear.adapters["rows"].rows]
    assert said.index("went") in (6, 7)  # steps of 20 ms; the text is shown at 0.1 s
    report = write_folder(experiment, tmp_path / "new")
    assert "hear: shows messages that state machines wait for" in report.kept


def test_modules_in_folders_that_code_adds_come_along(
    made: Made, opened: Opened, corpus: Path, tmp_path: Path
) -> None:
    (corpus / "own" / "lib").mkdir(parents=True)
    (corpus / "own" / "lib" / "speed_of.py").write_text("def speed(t):\n    return 0.5\n")
    code = (
        "import sys\nsys.path.append('/home/nobody/own/lib')\nfrom speed_of import speed\n"
        + DRIVE.replace("x=0.5", "x=speed(t)").replace("/drive", "/robot/husky/cmd_vel")
    )
    experiment = made(code, {"robot": CART})
    write_folder(experiment, tmp_path / "new")
    before = opened(experiment).result()
    (corpus / "own" / "lib" / "speed_of.py").unlink()
    again = opened(read_yaml(tmp_path / "new" / "experiment.yaml")).result()
    assert (again.failures, again.final_pose) == ([], before.final_pose)
    assert before.final_pose["robot"]["x"] > 0.2


def test_an_imported_function_that_cannot_be_loaded_is_left_out_as_in_the_original(
    made: Made, opened: Opened, tmp_path: Path
) -> None:
    code = DRIVE.replace("/drive", "/robot/husky/cmd_vel")
    experiment = made(f"import rospy\nx = rospy.Nowhere()\n{code}", {"robot": CART})
    write_folder(experiment, tmp_path / "new")
    assert opened(experiment).result().final_pose == (
        opened(read_yaml(tmp_path / "new" / "experiment.yaml")).result().final_pose
    )
