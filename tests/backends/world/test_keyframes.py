"""Robots start at a keyframe of their file, and on the ground, in both engines."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model
from nrp_core.world.robot_setup import RobotSetup, set_up_robot

WALKER = """<mujoco><compiler angle="radian"/><worldbody><body name="trunk" pos="0 0 1">
  <freejoint/><geom type="box" size="0.2 0.1 0.05" mass="2"/>
  <body name="leg" pos="0 0 -0.05"><joint name="hip" axis="0 1 0" ref="0.1" range="-2 2" damping="1"/>
    <geom type="box" size="0.05 0.1 0.1" pos="0 0 -0.1" mass="0.5"/></body></body></worldbody>
  <actuator><position joint="hip" kp="50" kv="1" gear="2"/></actuator>
  <keyframe><key name="home" qpos="0 0 0.6 1 0 0 0 0.4" ctrl="{ctrl}"/>
    <key name="lying" qpos="1 2 0.3 0.7071068 0.7071068 0 0 0.1"/></keyframe></mujoco>"""


@pytest.fixture
def walker(tmp_path: Path) -> Model:
    (tmp_path / "walker.xml").write_text(WALKER.format(ctrl="0.6"))
    return read_model(tmp_path / "walker.xml")


def test_a_robot_starts_at_a_keyframe_and_moves_as_in_mujoco_alone(open_world, walker, tmp_path):
    native = mujoco.MjModel.from_xml_path(str(tmp_path / "walker.xml"))
    native.opt.timestep, native.opt.integrator = 0.002, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(native)
    mujoco.mj_resetDataKeyframe(native, data, 0)
    world = open_world(Scene((set_up_robot(walker, RobotSetup(keyframe="home")),)))
    for steps in (0, 50):
        world.run_until(world.now_ns + steps * 2_000_000)
        mujoco.mj_step(native, data, steps)
        mujoco.mj_forward(native, data)
        (hip,) = world.joint_states("trunk").positions
        assert hip + 0.1 == pytest.approx(data.qpos[7], abs=5e-3)
        assert world.model_motion("trunk").pose.position == pytest.approx(data.qpos[:3].tolist(), abs=5e-3)


def test_controllers_of_a_keyframe_without_controls_hold_its_joints(walker):
    lying = set_up_robot(walker, RobotSetup(keyframe="lying"))
    assert lying.pose.position == (1, 2, 0.3)
    assert dict(lying.starts) == {"hip": pytest.approx(0)}
    assert lying.controllers[0].initial == pytest.approx(0)
    assert set_up_robot(walker, RobotSetup(keyframe="home")).controllers[0].initial == pytest.approx(0.2)


def test_the_pose_and_joints_of_an_experiment_come_before_those_of_the_keyframe(walker):
    setup = RobotSetup(keyframe="home", placed=True, starts=(("hip", 0.5),))
    placed = set_up_robot(walker, setup)
    assert placed.pose == walker.pose
    assert dict(placed.starts) == {"hip": 0.5}


def test_an_unknown_keyframe_is_an_error(walker, golden: Golden):
    with golden.raises(SceneError, match="'home'"):
        set_up_robot(walker, RobotSetup(keyframe="hone"))


@pytest.mark.parametrize(("placed", "height"), [(False, 0.25), (True, 1.25)])
def test_a_robot_on_the_ground_touches_it_with_its_lowest_collision(walker, placed, height):
    model = set_up_robot(walker, RobotSetup(on_ground=True, placed=placed))
    assert model.pose.position == pytest.approx((0, 0, height))


def test_a_robot_lies_on_the_ground_as_its_keyframe_turns_it(walker):
    model = set_up_robot(walker, RobotSetup(keyframe="lying", on_ground=True))
    assert model.pose.position == pytest.approx((1, 2, 0.1), abs=1e-6)
    assert model.pose.orientation == pytest.approx(
        Pose.from_rpy((0, 0, 0), 1.570796, 0, 0).orientation, abs=1e-6
    )
