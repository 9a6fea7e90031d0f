"""A robot that falls over, flies away or is thrown makes a run incomplete, and its first line says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

# a column on a small foot, which a push tips over
_COLUMN = """<sdf version="1.6"><model name="column"><link name="body"><pose>0 0 0.5 0 0 0</pose>
<inertial><mass>10</mass><inertia><ixx>0.85</ixx><iyy>0.85</iyy><izz>0.03</izz></inertia></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 1.0</size></box></geometry></collision></link>
</model></sdf>"""
_PUSH = """
from gazebo_msgs.srv import SetModelState
from gazebo_msgs.msg import ModelState
done = []
@nrp.Robot2Neuron()
def push(t):
    if t >= 0.6 and not done:
        done.append(t)
        state = ModelState()
        state.model_name = "column"
        {change}
        rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)(state)
"""
_TIPS, _FLIES = "state.twist.angular.x = 3.0", "state.twist.linear.z = 8.0"
_LIES = "state.pose.position.x, state.pose.orientation.x, state.pose.orientation.w = 3.0, 0.7071, 0.7071"

ENGINES = [pytest.param("mujoco"), pytest.param("pybullet", marks=pytest.mark.heavy)]


def _run(folder: Path, engine: str, change: str = "", z: float = 0.0) -> Run:
    (folder / "column.sdf").write_text(_COLUMN)
    (folder / "tf.py").write_text("import rospy" + _PUSH.format(change=change) if change else "")
    function = '<transferFunction src="tf.py"/>' if change else ""
    (folder / "x.bibi").write_text(
        f'<bibi><bodyModel robotId="column">column.sdf</bodyModel>{function}</bibi>'
    )
    (folder / "x.exc").write_text(
        '<ExD><timeout>1.6</timeout><environmentModel src="empty.sdf">'
        f'<robotPose robotId="column" x="0" y="0" z="{z}"/></environmentModel><bibiConf src="x.bibi"/></ExD>'
    )
    (folder / "empty.sdf").write_text(
        '<sdf version="1.6"><world name="w"><model name="floor"><static>1</static><link name="l">'
        '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>'
        "</link></model></world></sdf>"
    )
    return Run(read_exc(folder / "x.exc", [f"world.backend={engine}"]))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_that_stands_makes_a_complete_run(tmp_path: Path, engine: str) -> None:
    with _run(tmp_path, engine) as run:
        run.run_until(0.3)
        assert run.result().complete


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("change", "z", "what"), [(_TIPS, 0.0, "fell over"), (_FLIES, 0.0, "flew"), ("", -0.9, "was thrown")]
)
def test_a_robot_that_is_lost_makes_the_run_incomplete(
    tmp_path: Path, engine: str, change: str, z: float, what: str
) -> None:
    with _run(tmp_path, engine, change, z) as run:
        run.run()
        result = run.result()
        (lost,) = [one for one in result.problems if one.code is Code.NRP382]
        assert lost.message.startswith(f"the robot 'column' {what}")
        assert not result.complete
        assert f"not complete: {lost.message}" in result.judgement.headline
        run.loop.reset()
        assert Code.NRP382 not in {one.code for one in run.problems}


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_that_is_placed_elsewhere_starts_anew(tmp_path: Path, engine: str) -> None:
    with _run(tmp_path, engine, _LIES + "\n        state.pose.position.z = 0.1") as run:
        run.run_until(0.8)
        assert abs(run.world.model_motion("column").pose.rpy[0]) > 1.4
        assert Code.NRP382 not in {one.code for one in run.problems}
