"""Muscles that wrap around shapes move joints in Drake as in MuJoCo alone, which reads the same file."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from nrp_world_drake import DrakeBackend

from nrp_core.errors import CapabilityError
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.world import World, read_scene

LEG = """<mujoco><option integrator="implicitfast" tolerance="1e-14"/>
  <worldbody><body name="base" pos="0 0 1">{root}<inertial mass="2" pos="0 0 0" diaginertia=".02 .02 .02"/>
    <site name="a" pos="0.03 0 -0.02"/><site name="b" pos="-0.03 0 -0.02"/>
    <body name="upper" pos="0 0 -0.05"><inertial mass="1.5" pos="0 0 -0.15" diaginertia="0.02 0.02 0.004"/>
      <joint name="hip" axis="0 1 0" armature="0.01" ref="6" damping="5"/>
      <geom name="roll" type="cylinder" size="0.02 0.05" euler="90 0 0" mass="0"
        contype="0" conaffinity="0"/>
      <site name="c" pos="0.02 0 -0.2"/><site name="side" pos="0.04 0 0"/>
      <body name="lower" pos="0 0 -0.3"><inertial mass="1" pos="0 0 -0.12" diaginertia="0.01 0.01 0.002"/>
        <joint name="knee" axis="0 1 0" damping="5"/>
        <geom name="ball" type="sphere" size="0.025" mass="0" contype="0" conaffinity="0"/>
        <site name="d" pos="0.02 0 -0.05"/><site name="e" pos="-0.02 0 -0.05"/></body></body></body>
  </worldbody>
  <tendon><spatial name="front"><site site="a"/><geom geom="roll" sidesite="side"/><site site="c"/>
      <geom geom="ball"/><site site="d"/></spatial>
    <spatial name="back"><site site="{back}"/><geom geom="ball"/><site site="e"/></spatial>
    <spatial name="straight"><site site="b"/><site site="c"/></spatial></tendon>
  <actuator><muscle name="front" tendon="front" lengthrange="0.2 0.5" force="60" gear="2"/>
    <muscle name="straight" tendon="straight" lengthrange="0.1 0.3" force="100"/>
    <muscle name="back" tendon="back" lengthrange="0.2 0.5" force="60"/>
    <muscle name="joint" joint="knee" lengthrange="-2 0.2" force="5"/></actuator></mujoco>"""


def opened(folder: Path, text: str) -> World:
    (folder / "leg.xml").write_text(text)
    backend = DrakeBackend()
    return backend.open(read_scene(folder / "leg.xml"), seed=1, options=backend.options())


def test_a_leg_whose_muscles_wrap_moves_as_in_mujoco_alone(tmp_path: Path) -> None:
    text = LEG.format(root="", back="b")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    moved, off = 0.0, 0.0
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
            off = max(off, np.abs(joints.positions - data.qpos + model.qpos0).max())
            gears = model.actuator_gear[:, 0]
            np.testing.assert_allclose(state.message.length, data.actuator_length / gears, atol=1e-4)
            np.testing.assert_allclose(state.message.activation, data.act, atol=1e-9)
    assert off < 1e-9
    assert moved > 0.05


def test_a_muscle_from_a_free_base_to_the_world_is_refused_by_its_name(tmp_path: Path) -> None:
    text = LEG.format(root="<freejoint/>", back="o").replace(
        "<worldbody>", '<worldbody><site name="o" pos="0 0 2"/>'
    )
    with pytest.raises(CapabilityError, match="'back' of 'base'") as caught:
        opened(tmp_path, text)
    assert [*DrakeBackend().refusals(read_scene(tmp_path / "leg.xml"))] == [("base", str(caught.value))]
