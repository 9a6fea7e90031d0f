"""Muscles in Drake against MuJoCo alone."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from nrp_world_drake import DrakeBackend

from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.world import World, read_scene

ARM = """<mujoco>
  <worldbody><body name="base" pos="0.1 0.2 1"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
    <site name="a" pos="0.02 0 -0.02"/><site name="b" pos="-0.02 0 -0.02"/>
    <body name="upper">
      <inertial mass="1.5" pos="0 0.01 -0.15" quat="0.9 0.1 0.2 0.1" diaginertia="0.02 0.019 0.004"/>
      <joint name="shoulder" axis="0 1 0" damping="4"/>
      <site name="c" pos="0.03 0.01 -0.1"/><site name="d" pos="-0.03 0 -0.1"/>
      <body name="lower" pos="0 0 -0.3">
        <inertial mass="1" pos="0 0 -0.12" diaginertia="0.01 0.01 0.002"/>
        <joint name="elbow" axis="0 1 0" damping="2" ref="20"/>
        <site name="f" pos="0.02 0 -0.05"/><site name="g" pos="-0.02 0.01 0.02"/></body></body></body>
  </worldbody>
  <tendon><spatial name="flex"><site site="a"/><site site="c"/></spatial>
    <spatial name="biarticular"><site site="a"/><site site="c"/><site site="f"/></spatial>
    <spatial name="triceps"><site site="d"/><site site="g"/></spatial></tendon>
  <actuator><muscle name="flex" tendon="flex" lengthrange="0.06 0.12" force="300"/>
    <muscle name="biarticular" tendon="biarticular" lengthrange="0.2 0.4" force="200" vmax="5"/>
    <muscle name="triceps" tendon="triceps" lengthrange="0.15 0.3" force="200"/></actuator></mujoco>"""
BALL = """<mujoco><option gravity="0 0 0"/><worldbody><site name="o" pos="0.2 0.1 0.5"/>
  <body name="cart"><inertial mass="1" pos="0 0 0" diaginertia="0.1 0.1 0.1"/>
    <joint name="rail" type="slide" axis="0.6 0 0.8"/>
    <body name="bone" pos="0.1 0 0.1" quat="0.9 0.1 0.3 0.2">
      <inertial mass="1" pos="0.02 0 0.1" quat="0.8 0.1 0.2 0.1" diaginertia="0.02 0.03 0.04"/>
      <joint name="hip" type="ball"/><site name="i" pos="0.05 0.02 0.2"/></body></body></worldbody>
  <tendon><spatial name="t"><site site="o"/><site site="i"/></spatial></tendon>
  <actuator><muscle name="m" tendon="t" lengthrange="0.2 0.5" force="100"/></actuator></mujoco>"""
CONTROLS = [0.5, 0.3, 0.2]


def opened(folder: Path, text: str) -> World:
    (folder / "arm.xml").write_text(text)
    backend = DrakeBackend()
    return backend.open(read_scene(folder / "arm.xml"), seed=1, options=backend.options())


def alone(text: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_IMPLICITFAST, 0.002
    return model, mujoco.MjData(model)


def test_an_arm_with_three_muscles_moves_as_in_mujoco_alone(tmp_path: Path) -> None:
    model, data = alone(ARM)
    data.ctrl = CONTROLS
    world = opened(tmp_path, ARM)
    world.advertise("/base/muscles/cmd").publish(Float64MultiArray(data=CONTROLS))
    for seconds in (0.004, 0.05, 0.2, 1.0):
        world.run_until(round(seconds * 1e9))
        mujoco.mj_step(model, data, round((seconds - data.time) / 0.002))
        efforts = data.qfrc_actuator.copy()
        mujoco.mj_forward(model, data)
        states, muscles = world.joint_states("base"), world.subscribe("/base/muscles/state").latest
        assert muscles is not None
        assert states.positions == pytest.approx(data.qpos - model.qpos0, abs=6e-4)
        assert states.efforts == pytest.approx(efforts, rel=5e-3)
        assert muscles.message.length == pytest.approx(data.actuator_length, abs=5e-5)
        assert muscles.message.force == pytest.approx(-data.actuator_force, rel=1e-3)
        assert muscles.message.activation == pytest.approx(data.act, abs=1e-9)


def test_muscles_are_in_the_efforts_of_slides_and_balls(tmp_path: Path) -> None:
    model, data = alone(BALL)
    data.ctrl = 1.0
    mujoco.mj_step(model, data, 2)  # the second step has an activation
    world = opened(tmp_path, BALL)
    world.advertise("/cart/m/cmd").publish(Float64(1.0))
    world.run_until(4_000_000)
    efforts = world.joint_states("cart").efforts
    assert np.linalg.norm(efforts) > 1.0
    assert efforts == pytest.approx(data.qfrc_actuator, rel=1e-3)


def test_a_snapshot_decides_about_the_future_of_muscles(tmp_path: Path) -> None:
    world = opened(tmp_path, ARM)
    cmd = world.advertise("/base/muscles/cmd")
    cmd.publish(Float64MultiArray(data=[0.9, 0.0, 0.4]))
    world.run_until(20_000_000)
    saved = world.snapshot()
    world.run_until(60_000_000)
    there = world.joint_states("base")
    cmd.publish(Float64MultiArray(data=[0.0, 0.0, 0.0]))
    world.run_until(80_000_000)
    world.restore(saved)
    world.run_until(60_000_000)
    again = world.joint_states("base")
    assert again.positions.tolist() == there.positions.tolist()
    assert again.efforts.tolist() == there.efforts.tolist()
