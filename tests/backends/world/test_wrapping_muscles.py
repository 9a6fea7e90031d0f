"""Muscles that wrap around shapes move joints in PyBullet as in MuJoCo alone, which reads the same file."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from golden import Golden

from nrp_core import World, worlds
from nrp_core.checks.validate import validate_file
from nrp_core.errors import CapabilityError
from nrp_core.findings import Level
from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.scene.sdf import read_scene

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
  <tendon><spatial name="front"{tendon}><site site="a"/><geom geom="roll" sidesite="side"/><site site="c"/>
      <geom geom="ball"/><site site="d"/></spatial>
    <spatial name="back"><site site="b"/><geom geom="ball"/><site site="e"/></spatial>
    <spatial name="straight"><site site="b"/><site site="c"/></spatial></tendon>
  <actuator><muscle name="front" tendon="front" lengthrange="0.2 0.5" force="300" gear="2"/>
    <muscle name="back" tendon="back" lengthrange="0.2 0.5" force="300"/>
    <muscle name="straight" tendon="straight" lengthrange="0.1 0.3" force="100"/>
    <muscle name="joint" joint="knee" lengthrange="-2 0.2" force="5"/></actuator></mujoco>"""

HEAD = "name: leg\nduration: 100 ms\nbrain: {backend: event, model: brain.py}\n"
BRAIN = "import nrp_core.pynn as sim\n\nsim.setup()\nsim.Population(1, sim.IF_curr_exp(), label='one')\n"


def opened(file: Path) -> World:
    backend = worlds().load("pybullet")
    return backend.open(read_scene(file), seed=1, options=backend.options())


@pytest.mark.parametrize("root", ["", "<freejoint/>"])
def test_a_leg_whose_muscles_wrap_moves_as_in_mujoco_alone(root: str, tmp_path: Path) -> None:
    file = tmp_path / "leg.xml"
    file.write_text(LEG.format(root=root, tendon=""))
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    moved = 0.0
    with opened(file) as world:
        command = world.advertise("/base/muscles/cmd")
        for k, row in enumerate(np.random.default_rng(3).uniform(0.0, 1.0, (50, 4))):
            data.ctrl[:] = row
            mujoco.mj_step(model, data, 5)
            command.publish(Float64MultiArray(data=row))
            world.run_until((k + 1) * 10_000_000)
            mujoco.mj_forward(model, data)
            joints = world.joint_states("base")
            moved = max(moved, np.abs(joints.positions).max())
            np.testing.assert_allclose(joints.positions, data.qpos[-2:] - model.qpos0[-2:], atol=1e-9)
            state = world.subscribe("/base/muscles/state").latest.message
            gears = model.actuator_gear[:, 0]
            np.testing.assert_allclose(state.length, data.actuator_length / gears, atol=1e-9)
            np.testing.assert_allclose(state.force, -data.actuator_force * gears, rtol=1e-6)
    assert moved > 0.05


def lengths_in(file: Path) -> np.ndarray:
    with opened(file) as world:
        return np.array(world.subscribe("/base/muscles/state").latest.message.length)


def test_a_file_has_any_suffix_and_parts_without_names_or_with_those_of_bodies(tmp_path: Path) -> None:
    text = LEG.format(root="", tendon="")
    plain, other = tmp_path / "leg.xml", tmp_path / "leg.mjcf"
    plain.write_text(text)
    text = text.replace('<joint name="hip"', "<joint").replace('"knee"', '"lower"')
    other.write_text(text.replace('<muscle name="front"', "<muscle"))
    np.testing.assert_array_equal(lengths_in(other), lengths_in(plain))


def test_another_actuator_may_have_the_name_of_the_group_of_all_muscles(tmp_path: Path) -> None:
    motors = '<actuator><motor name="one" joint="hip"/><motor name="muscles" joint="hip"/>'
    file = tmp_path / "leg.xml"
    file.write_text(LEG.format(root="", tendon="").replace("<actuator>", motors))
    backend = worlds().load("mujoco")
    with backend.open(read_scene(file), seed=1, options=backend.options()) as world:
        assert world.topics["/base/muscles/cmd"].type is Float64


def test_a_changed_file_that_is_included_is_read_again(tmp_path: Path) -> None:
    head, rest = LEG.format(root="", tendon="").split("<worldbody>")
    body, after = rest.split("</worldbody>")
    whole, part = tmp_path / "leg.xml", tmp_path / "body.xml"
    whole.write_text(f'{head}<worldbody><include file="body.xml"/></worldbody>{after}')
    part.write_text(f"<mujocoinclude>{body}</mujocoinclude>")
    lengths_in(whole)
    part.write_text(part.read_text().replace('name="d" pos="0.02', 'name="d" pos="0.04'))
    model = mujoco.MjModel.from_xml_path(str(whole))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(lengths_in(whole), data.actuator_length / model.actuator_gear[:, 0])


@pytest.mark.parametrize(
    ("place", "more"),
    [
        ('name="front"', ' limited="true" range="0.1 0.5"'),
        ('name="front"', ' stiffness="10"'),
        ('name="straight"', ' damping="1"'),
        ('tendon="front"', ' ctrlrange="0 0.5"'),
        ('name="hip"', ' actuatorfrcrange="-1 1"'),
    ],
)
def test_a_muscle_with_properties_that_only_mujoco_has_is_refused_before_the_run(
    place: str, more: str, tmp_path: Path, golden: Golden
) -> None:
    (tmp_path / "leg.xml").write_text(LEG.format(root="", tendon="").replace(place, place + more, 1))
    (tmp_path / "brain.py").write_text(BRAIN)
    muscle = "straight" if "straight" in place else "front"
    for engine in ("pybullet", "mujoco"):
        file = tmp_path / f"{engine}.yaml"
        file.write_text(f"{HEAD}world: {{backend: {engine}, scene: leg.xml}}\n")
        errors = [one for one in validate_file(file) if one.level is Level.ERROR]
        assert len(errors) == (engine == "pybullet"), errors
        for error in errors:
            assert f"'{muscle}' of 'base'" in error.message
            golden(error.message)
    with golden.raises(CapabilityError, match=f"'{muscle}' of 'base'"):
        opened(tmp_path / "leg.xml")
    backend = worlds().load("mujoco")
    with backend.open(read_scene(tmp_path / "leg.xml"), seed=1, options=backend.options()) as world:
        world.run_until(10_000_000)


SDF = """<sdf version="1.9"><model name="base"><link name="body"><inertial><mass>1</mass></inertial></link>
  <plugin name="front" filename="nrp_muscle"><wrapping>true</wrapping><force>1</force>
    <optimal_length>0.1</optimal_length></plugin></model></sdf>"""


@pytest.mark.parametrize("kind", ["another format", "a free base", "a ball joint"])
def test_a_muscle_that_mujoco_cannot_help_with_is_refused_before_the_run(
    kind: str, tmp_path: Path, golden: Golden
) -> None:
    """PyBullet moves the bodies, and MuJoCo's routines need the file, its joints and a held base."""
    free = LEG.format(root="<freejoint/>", tendon="")
    texts = {
        "another format": SDF,
        "a free base": free.replace('site="a"', 'site="o"').replace(
            "<worldbody>", '<worldbody><site name="o" pos="0 0 2"/>'
        ),
        "a ball joint": LEG.format(root="", tendon="").replace(
            "</body></body></body>",
            """<body pos="0 0 -0.3"><joint name="ankle" type="ball"/>
              <inertial mass="1" pos="0 0 0" diaginertia=".01 .01 .01"/></body></body></body></body>""",
        ),
    }
    scene = tmp_path / ("leg.sdf" if kind == "another format" else "leg.xml")
    scene.write_text(texts[kind])
    (tmp_path / "brain.py").write_text(BRAIN)
    file = tmp_path / "leg.yaml"
    file.write_text(f"{HEAD}world: {{backend: pybullet, scene: {scene.name}}}\n")
    with pytest.raises(CapabilityError, match="'front' of 'base'") as caught:
        opened(scene)
    errors = [one.message for one in validate_file(file) if one.level is Level.ERROR]
    assert errors[0] == str(caught.value)
    golden(*errors)


def test_what_a_flag_switches_off_for_mujoco_alone_is_reported(tmp_path: Path) -> None:
    for flags, subjects in (('<flag limit="disable"/>', ["limit"]), ('<flag energy="enable"/>', [])):
        file = tmp_path / "leg.xml"
        text = LEG.format(root="", tendon="").replace('tolerance="1e-14"/>', f">{flags}</option>")
        file.write_text(text)
        with opened(file) as world:
            found = [one.subject for one in world.warnings if one.code.name == "NRP260"]
        assert found == subjects
