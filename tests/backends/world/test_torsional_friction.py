"""Friction about the normal of a contact, and against rolling, on both engines."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest
from jointed import push

from nrp_core.findings import Code
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose, Twist, Vector3
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_scene

RADIUS, MASS, INERTIA, PATCH, G = 0.1, 1.0, 0.004, 0.01, 9.81
ROOM = f"""<sdf version="1.9"><world name="w"><gravity>0 0 -{G}</gravity>
  <model name="floor"><static>1</static><link name="l"><collision name="c"><geometry><plane/></geometry>
    </collision></link></model>
  <model name="robot"><pose>0 0 {RADIUS} 0 0 0</pose><link name="bob"><inertial><mass>{MASS}</mass><inertia>
    <ixx>{INERTIA}</ixx><iyy>{INERTIA}</iyy><izz>{INERTIA}</izz></inertia></inertial><collision name="c">
    <geometry><sphere><radius>{RADIUS}</radius></sphere></geometry><surface><friction><ode><mu>{{mu}}</mu></ode>
    <torsional>{{torsional}}</torsional></friction></surface></collision></link></model></world></sdf>"""
PATCHED = f"<coefficient>{{}}</coefficient><patch_radius>{PATCH}</patch_radius>"


def room(folder: Path, torsional: str, mu: float = 1.0) -> Scene:
    path = folder / "room.sdf"
    path.write_text(ROOM.format(torsional=torsional, mu=mu))
    return read_scene(path)


@pytest.mark.parametrize(("coefficient", "mu"), [(1.0, 1.0), (0.5, 1.0), (1.0, 0.4), (0.0, 1.0)])
def test_a_spinning_ball_slows_down_as_the_formula_of_gazebo_says(
    open_world, advance, tmp_path, coefficient, mu
):
    """The torque is ``3 pi / 16`` times the coefficient, the patch radius and the weight."""
    world = open_world(room(tmp_path, PATCHED.format(coefficient), mu))
    advance(world, 0.1)
    push(world, "bob", torque=(0.0, 0.0, 20 * INERTIA / 0.002), lasts_ns=2_000_000)
    advance(world, 0.3)  # it hops
    before = world.model_motion("robot").angular[2]
    advance(world, 0.5)
    after = world.model_motion("robot").angular[2]
    rate = 3 * pi / 16 * coefficient * PATCH * MASS * G / INERTIA
    assert before - after == pytest.approx(0.5 * rate, rel=0.02, abs=0.02)
    assert before > 10


def test_a_patch_that_grows_with_depth_is_a_finding(tmp_path):
    grows = "<use_patch_radius>0</use_patch_radius><surface_radius>0.1</surface_radius>"
    for torsional, subjects in ((grows, ["surface_radius"]), (PATCHED.format(0.5), [])):
        warnings = room(tmp_path, torsional).warnings
        assert [each.subject for each in warnings if each.code == Code.NRP383] == subjects


BALL = """<mujoco><option cone="elliptic"/><worldbody>
  <geom type="plane" size="9 9 1" condim="{floor}" friction="1 0 0"/>
  <body name="ball" pos="0 0 0.1"><freejoint/>
    <geom size="0.1" mass="1" condim="{ball}" friction="1 0.005 {rolling}"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("floor", "ball", "rolling"), [(3, 6, 0.002), (6, 6, 0.002), (3, 4, 0.002), (1, 1, 0.0), (3, 1, 0.0)]
)
def test_a_ball_of_mjcf_rolls_as_its_condim_says(open_world, tmp_path, floor, ball, rolling):
    """With a torque of ``rolling`` times the weight it slows down by ``rolling g / (1.4 r)``."""
    path = tmp_path / "ball.xml"
    path.write_text(BALL.format(floor=floor, ball=ball, rolling=rolling))
    scene = read_scene(path)
    name = next(model.name for model in scene.models if not model.static)
    world = open_world(scene)
    world.run_until(100_000_000)
    pose = Pose(Point(*world.model_motion(name).pose.position))
    turn = 0.0 if floor == ball == 1 else 10.0
    world.call("/gazebo/set_model_state", ModelState(name, pose, Twist(Vector3(1.0), Vector3(0.0, turn))))
    world.run_until(200_000_000)
    before = world.model_motion(name)
    world.run_until(700_000_000)
    after = world.model_motion(name)
    slower = rolling * G / (1.4 * RADIUS) if ball == 6 else 0.0
    assert before.linear[0] - after.linear[0] == pytest.approx(0.5 * slower, rel=0.01, abs=1e-3)
    assert after.angular[1] == pytest.approx(after.linear[0] / RADIUS if turn else 0.0, rel=0.01, abs=0.01)
