"""Muscles that wrap around shapes move joints in Drake as in MuJoCo alone, which reads the same file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from nrp_world_drake import DrakeBackend, damping

from nrp_core.errors import CapabilityError
from nrp_core.findings import Code
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.world import World, read_scene

LEG = """<mujoco><option integrator="implicitfast" tolerance="1e-14"/>
  <worldbody><body name="base" pos="0 0 1">{root}<inertial mass="2" pos="0 0 0" diaginertia=".02 .02 .02"/>
    <site name="a" pos="0.03 0 -0.02"/><site name="b" pos="-0.03 0 -0.02"/>
    <body name="upper" pos="0 0 -0.05"><inertial mass="1.5" pos="0 0 -0.15" diaginertia="0.02 0.02 0.004"/>
      <joint name="hip" axis="0 1 0" range="-1 1" limited="true" armature="0.01" ref="0.1"/>
      <geom name="roll" type="cylinder" size="0.02 0.05" euler="90 0 0" mass="0"
        contype="0" conaffinity="0"/>
      <site name="c" pos="0.02 0 -0.2"/><site name="side" pos="0.04 0 0"/>
      <body name="lower" pos="0 0 -0.3"><inertial mass="1" pos="0 0 -0.12" diaginertia="0.01 0.01 0.002"/>
        <joint name="knee" axis="0 1 0" range="-2 0" limited="true" damping="0.1"/>
        <geom name="ball" type="sphere" size="0.025" mass="0" contype="0" conaffinity="0"/>
        <site name="d" pos="0.02 0 -0.05"/><site name="e" pos="-0.02 0 -0.05"/></body></body></body>
  </worldbody>
  <tendon><spatial name="front"><site site="a"/><geom geom="roll" sidesite="side"/><site site="c"/>
      <geom geom="ball"/><site site="d"/></spatial>
    <spatial name="back"><site site="{back}"/><geom geom="ball"/><site site="e"/></spatial>
    <spatial name="straight"><site site="b"/><site site="c"/></spatial></tendon>
  <actuator><muscle name="front" tendon="front" lengthrange="0.2 0.5" force="300" gear="2"/>
    <muscle name="back" tendon="back" lengthrange="0.2 0.5" force="300"/>
    <muscle name="straight" tendon="straight" lengthrange="0.1 0.3" force="100"/>
    <muscle name="joint" joint="knee" lengthrange="-2 0.2" force="5"/></actuator></mujoco>"""
CHAIN = """<mujoco><option integrator="implicitfast" tolerance="1e-14" iterations="500"/>
  <worldbody><body name="base" pos="0 0 1"><inertial mass="1" pos="0 0 0" diaginertia=".01 .01 .01"/>
    <site name="a" pos=".03 0 -.01"/><site name="b" pos="-.03 .01 -.01"/>
    <body name="upper" pos="0 0 -.05"><inertial mass=".3" pos="0 .01 -.08" diaginertia="1e-3 1e-3 2e-4"/>
      <joint name="first" axis="0 1 0" damping=".02" limited="true" range="-8 8" solreflimit=".01 1"/>
      <geom name="roll" type="cylinder" size=".015 .04" euler="90 0 0" mass="0" contype="0" conaffinity="0"/>
      <site name="c" pos=".02 0 -.1"/><site name="side" pos=".04 0 0"/>
      <body name="middle" pos="0 0 -.15"><inertial mass=".1" pos="0 0 -.05" diaginertia="2e-4 2e-4 4e-5"/>
        <joint name="second" axis=".2 1 0" damping=".01" armature="1e-4" limited="true" range="-10 10"
          solreflimit=".02 1" frictionloss=".02" solreffriction=".02 1"/>
        <geom name="ball" type="sphere" size=".02" mass="0" contype="0" conaffinity="0"/>
        <site name="d" pos="-.015 0 -.03"/>
        <body name="last" pos="0 0 -.1"><inertial mass=".03" pos="0 0 -.03" diaginertia="3e-5 3e-5 6e-6"/>
          <joint name="third" axis="0 1 .1" damping=".002"/>
          <geom name="bead" type="sphere" size=".012" mass="0" contype="0" conaffinity="0"/>
          <site name="e" pos=".01 0 -.02"/><site name="f" pos="-.01 0 -.02"/></body></body></body></body>
  </worldbody>
  <tendon><spatial name="front"><site site="a"/><geom geom="roll" sidesite="side"/><site site="c"/>
      <geom geom="bead"/><site site="e"/></spatial>
    <spatial name="back"><site site="b"/><geom geom="ball"/><site site="f"/></spatial>
    <spatial name="upper"><site site="b"/><geom geom="ball"/><site site="d"/></spatial>
    <spatial name="lower"><site site="c"/><geom geom="ball"/><site site="d"/><geom geom="bead"/>
      <site site="f"/></spatial></tendon>
  <equality><joint joint1="third" joint2="second" polycoef=".02 .6 .2 0 0" solref=".01 1"/></equality>
  <actuator><muscle name="front" tendon="front" lengthrange=".1 .5" force="15"/>
    <muscle name="back" tendon="back" lengthrange=".1 .5" force="15"/>
    <muscle name="upper" tendon="upper" lengthrange=".1 .4" force="20"/>
    <muscle name="lower" tendon="lower" lengthrange=".05 .3" force="8"/></actuator></mujoco>"""


def opened(folder: Path, text: str) -> World:
    (folder / "leg.xml").write_text(text)
    backend = DrakeBackend()
    return backend.open(read_scene(folder / "leg.xml"), seed=1, options=backend.options())


@pytest.mark.parametrize("root", ["", "<freejoint/>"])
def test_a_leg_whose_muscles_wrap_moves_as_in_mujoco_alone(root: str, tmp_path: Path) -> None:
    text = LEG.format(root=root, back="b")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    moved = 0.0
    with opened(tmp_path, text) as world:
        command = world.advertise("/base/muscles/cmd")
        for k, row in enumerate(np.random.default_rng(3).uniform(0.0, 1.0, (50, 4))):
            data.ctrl[:] = row
            mujoco.mj_step(model, data, 5)
            command.publish(Float64MultiArray(data=row))
            world.run_until((k + 1) * 10_000_000)
            mujoco.mj_forward(model, data)
            joints, state = world.joint_states("base"), world.subscribe("/base/muscles/state").latest
            assert state is not None
            moved = max(moved, np.abs(joints.positions).max())
            np.testing.assert_allclose(joints.positions, data.qpos[-2:] - model.qpos0[-2:], atol=1e-9)
            gears = model.actuator_gear[:, 0]
            np.testing.assert_allclose(state.message.length, data.actuator_length / gears, atol=1e-9)
            np.testing.assert_allclose(state.message.activation, data.act, atol=1e-9)
    assert moved > 0.05


def test_a_chain_with_limits_friction_and_a_coupling_moves_as_in_mujoco_alone(tmp_path: Path) -> None:
    """And goes on from a snapshot as it went on before."""
    model = mujoco.MjModel.from_xml_string(CHAIN)
    data = mujoco.MjData(model)
    rows = np.random.default_rng(3).uniform(0.0, 1.0, (40, 4))
    positions, wraps, saved = [], np.zeros(4), None
    with opened(tmp_path, CHAIN) as world:
        assert not world.warnings
        command = world.advertise("/base/muscles/cmd")

        def run(k: int) -> list[float]:
            command.publish(Float64MultiArray(data=rows[k]))
            world.run_until((k + 1) * 10_000_000)
            joints = world.joint_states("base")
            return [*joints.positions, *joints.velocities, *joints.efforts]

        for k, row in enumerate(rows):
            if k == len(rows) // 2:
                saved = world.snapshot()
            data.ctrl[:] = row
            mujoco.mj_step(model, data, 5)
            positions.append(run(k))
            wraps = np.maximum(wraps, data.ten_wrapnum)
            np.testing.assert_allclose(positions[-1][:3], data.qpos, atol=1e-11)
        assert saved is not None
        world.restore(saved)
        assert [run(k) for k in range(len(rows) // 2, len(rows))] == positions[len(rows) // 2 :]
    assert (wraps >= model.tendon_num).all()
    assert (np.max(positions, axis=0)[:2] > model.jnt_range[:2, 1]).all()


WALL = CHAIN.replace("<worldbody>", '<worldbody><geom type="box" size=".01 .1 .1" pos="-.04 0 .65"/>')
WALL = WALL.replace('<site name="e"', '<geom size=".01" pos="0 0 -.05" mass="0"/><site name="e"')
"""The chain beside a wall, against which its muscles press it."""


def test_the_load_of_a_contact_is_known_in_the_next_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that most steps need one trial; without it, they would need 2.7."""
    trial, taken = damping.Running.trial, []
    monkeypatch.setattr(damping.Running, "trial", lambda self: taken.append(1) or trial(self))
    with opened(tmp_path, WALL) as world:
        world.advertise("/base/muscles/cmd").publish(Float64MultiArray(data=[0.2, 1.0, 1.0, 0.6]))
        world.run_until(500_000_000)
    assert len(taken) < 1.5 * 250


def test_a_heavy_model_with_muscles_does_not_disturb_a_light_one(tmp_path: Path) -> None:
    """The forces of damping are as exact as those of their own model need."""
    heavy = LEG.format(root="<freejoint/>", back="b").replace('mass="2"', 'mass="2000"')
    for name, text in (("chain", WALL), ("heavy", heavy.replace('name="base"', 'name="heavy"'))):
        (tmp_path / f"{name}.xml").write_text(text)
    scene, other = (read_scene(tmp_path / f"{name}.xml") for name in ("chain", "heavy"))
    found, backend = [], DrakeBackend()
    for models in (scene.models, (*scene.models, *other.models)):
        with backend.open(replace(scene, models=models), seed=1, options=backend.options()) as world:
            world.advertise("/base/muscles/cmd").publish(Float64MultiArray(data=[0.2, 1.0, 1.0, 0.6]))
            world.run_until(300_000_000)
            found.append(world.joint_states("base").positions)
    np.testing.assert_allclose(*found, atol=1e-9)


def test_a_muscle_may_connect_links_that_cannot_move(tmp_path: Path) -> None:
    (tmp_path / "post.sdf").write_text("""<sdf version="1.9"><world name="w"><model name="post">
      <link name="a"/><joint name="j" type="fixed"><parent>world</parent><child>a</child></joint>
      <plugin name="m" filename="nrp_muscle"><point><link>world</link><xyz>0 0 1</xyz></point><point>
        <link>a</link><xyz>0 0 0</xyz></point><force>9</force><optimal_length>1</optimal_length></plugin>
      </model></world></sdf>""")
    backend = DrakeBackend()
    with backend.open(read_scene(tmp_path / "post.sdf"), seed=1, options=backend.options()) as world:
        world.run_until(10_000_000)


@pytest.mark.parametrize("trials", [1, 10])
def test_a_step_whose_damping_is_not_found_is_reported_once(
    trials: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A chain that muscles press against a wall needs a few trials in some steps."""
    monkeypatch.setattr(damping, "MOST_TRIALS", trials)
    with opened(tmp_path, WALL) as world:
        world.advertise("/base/muscles/cmd").publish(Float64MultiArray(data=[0.2, 1.0, 1.0, 0.6]))
        world.run_until(300_000_000)
        assert [each.code for each in world.warnings] == [Code.NRP277] * (trials == 1)


def test_a_muscle_from_a_free_base_to_the_world_is_refused_by_its_name(tmp_path: Path) -> None:
    text = LEG.format(root="<freejoint/>", back="o").replace(
        "<worldbody>", '<worldbody><site name="o" pos="0 0 2"/>'
    )
    with pytest.raises(CapabilityError, match="'back' of 'base'") as caught:
        opened(tmp_path, text)
    assert [*DrakeBackend().refusals(read_scene(tmp_path / "leg.xml"))] == [("base", str(caught.value))]
