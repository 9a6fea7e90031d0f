"""Muscles are the same in all engines: values of MuJoCo alone and of its formulas."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, sin
from pathlib import Path

import mujoco
import numpy as np
import pytest
from golden import Golden

from nrp_core import World, worlds
from nrp_core.errors import CapabilityError, SceneError, TopicError
from nrp_core.findings import Code
from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.scene.model import Scene
from nrp_core.scene.outline import outline
from nrp_core.scene.sdf import read_scene
from nrp_core.world.drives.muscles import moment_arms, muscles_of
from nrp_core.world.engine_kit.muscles import (
    activation_rate,
    force_length,
    force_velocity,
    passive_force,
)

ENGINES = ("mujoco", "pybullet")
ARM = """<mujoco><compiler angle="degree"/><option gravity="0 0 0" integrator="implicitfast"/>
  <worldbody><site name="o" pos="0 0 0.3"/>
    <body name="arm"><inertial mass="1" pos="0.15 0 0" diaginertia="0.01 0.01 0.01"/>
      <joint name="q" axis="0 1 0" range="-90 90" limited="true"{joint}/>
      <site name="i" pos="0.05 0 0"/></body>
  </worldbody>
  <tendon><spatial name="t"><site site="o"/><site site="i"/></spatial></tendon>
  <actuator><muscle name="m" tendon="t" lengthrange="0.25 0.35" force="100"{muscle}/></actuator>
</mujoco>"""
PAIR = """<mujoco>
  <worldbody><body name="base" pos="0.1 0.2 1"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
    <site name="a" pos="0.02 0 -0.02"/><site name="b" pos="-0.02 0 -0.02"/>
    <body name="upper" pos="0 0 0">
      <inertial mass="1.5" pos="0 0.01 -0.15" quat="0.9 0.1 0.2 0.1" diaginertia="0.02 0.019 0.004"/>
      <joint name="shoulder" axis="0 1 0" damping="4"/>
      <site name="c" pos="0.03 0.01 -0.1"/><site name="d" pos="-0.03 0 -0.1"/>
      <site name="e" pos="0.03 0 -0.2"/>
      <body name="lower" pos="0 0 -0.3">
        <inertial mass="1" pos="0 0 -0.12" diaginertia="0.01 0.01 0.002"/>
        <joint name="elbow" axis="0 1 0" damping="2" ref="20"/>
        <site name="f" pos="0.02 0 -0.05"/><site name="g" pos="-0.02 0.01 0.02"/></body></body></body>
  </worldbody>
  <tendon><spatial name="flex"><site site="a"/><site site="c"/></spatial>
    <spatial name="extend"><site site="b"/><site site="d"/></spatial>
    <spatial name="biarticular"><site site="a"/><site site="c"/><site site="e"/><site site="f"/></spatial>
    <spatial name="triceps"><site site="d"/><site site="g"/></spatial></tendon>
  <actuator><muscle name="flex" tendon="flex" lengthrange="0.06 0.12" force="300"/>
    <muscle name="extend" tendon="extend" lengthrange="0.06 0.12" force="250" timeconst="0.02 0.06"/>
    <muscle name="biarticular" tendon="biarticular" lengthrange="0.2 0.4" force="200" gear="2"
      vmax="5" tausmooth="0.2"/>
    <muscle name="triceps" tendon="triceps" lengthrange="0.15 0.3" force="200"/></actuator>
</mujoco>"""
CONTROLS = {"flex": 0.5, "extend": 0.1, "biarticular": 0.3, "triceps": 0.2}


def arm(folder: Path, muscle: str = "", joint: str = "", text: str = ARM) -> Scene:
    (folder / "arm.xml").write_text(text.format(muscle=muscle, joint=joint) if "{joint}" in text else text)
    return read_scene(folder / "arm.xml")


def opened(scene: Scene, engine: str, step: str = "2 ms") -> World:
    backend = worlds().load(engine)
    return backend.open(scene, seed=1, options=backend.options.model_validate({"timestep": step}))


def state(world: World, topic: str) -> np.ndarray:
    message = world.subscribe(topic).latest.message
    return np.array([message.length, message.velocity, message.force, message.activation])


def test_curves_have_the_values_of_mujoco():
    lengths = [force_length(x, 0.5, 1.6) for x in (0.6, 0.75, 0.9, 1.15, 1.3, 1.45)]
    assert lengths == pytest.approx([0.08, 0.5, 0.92, 0.875, 0.5, 0.125])
    passive = [passive_force(x, 1.6, 1.3) for x in (1.15, 1.3, 1.45, 1.6, 1.7)]
    assert passive == pytest.approx([0.1625, 0.65, 1.3, 1.95, 2.3833333333])
    velocities = [force_velocity(x, 1.2) for x in (-0.75, -0.5, -0.25, 0.1, 0.2, 0.5)]
    assert velocities == pytest.approx([0.0625, 0.25, 0.5625, 1.15, 1.2, 1.2])
    assert [force_velocity(x, 1.0) for x in (-0.5, 0.0, 0.1)] == [0.25, 1.0, 1.0]


@pytest.mark.parametrize("smooth", [0.0, 0.2])
def test_the_activation_has_the_dynamics_of_mujoco(smooth):
    prm = np.array([0.01, 0.04, smooth])
    for control in (-1.0, 0.0, 0.4, 0.6, 1.0, 2.0):
        for activation in (-0.1, 0.0, 0.5, 0.55, 1.0, 1.1):
            ours = activation_rate(control, activation, *prm)
            assert ours == pytest.approx(mujoco.mju_muscleDynamics(control, activation, prm), rel=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("q", [0.0, 0.5, 1.4])
def test_length_force_and_acceleration_are_those_of_the_formula(engine, q, tmp_path):
    """The first step accelerates a limb at rest by moment times force over inertia."""
    with opened(arm(tmp_path), engine) as world:
        world.advertise("/arm/m/cmd").publish(Float64(1.0))
        world.run_until(100_000_000)
        state(world, "/arm/m/state")  # must not be remembered
        world.set_joints("arm", {"q": q})
        length, velocity, force, activation = state(world, "/arm/m/state")
        world.run_until(102_000_000)
        states = world.joint_states("arm")
        (rate,), (effort,) = states.velocities, states.efforts
    assert length == pytest.approx(hypot(0.05 * cos(q), 0.3 + 0.05 * sin(q)), rel=1e-9)
    assert velocity == pytest.approx(0.0, abs=1e-9)
    assert activation == pytest.approx(1.0, abs=3e-3)
    relative = (length - 0.25) / (0.1 / 0.3) + 0.75
    wanted = 100 * (activation * force_length(relative, 0.5, 1.6) + passive_force(relative, 1.6, 1.3))
    assert force == pytest.approx(wanted, rel=1e-6)
    moment = 0.3 * 0.05 * cos(q) / length
    assert effort == pytest.approx(-force * moment, rel=1e-6)  # as MuJoCo's joint sensor of actuator forces
    damped = 1 / (1 + 0.002 * 2 * moment**2 * 100 / 0.5 / 0.0325)  # by the muscle, implicitly
    assert rate == pytest.approx(-0.002 * force * moment / 0.0325 * damped, rel=0.01)


def alone(text: str, seconds: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions relative to their zeros, states of the muscles, and their efforts at the joints.

    They are those of MuJoCo without this program.
    """
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl = list(CONTROLS.values())
    mujoco.mj_step(model, data, round(seconds / 0.002))
    efforts = data.qfrc_actuator.copy()
    mujoco.mj_forward(model, data)
    gear = model.actuator_gear[:, 0]
    rows = data.actuator_length / gear, data.actuator_velocity / gear, -data.actuator_force * gear, data.act
    return data.qpos - model.qpos0, np.array(rows), efforts


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_with_four_muscles_moves_as_in_mujoco_alone(engine, tmp_path):
    scene, exact = arm(tmp_path, text=PAIR), engine == "mujoco"
    with opened(scene, engine) as world:
        group = [each for each in scene.models[0].drives if each.name == "muscles"]
        assert group[0].muscles == tuple(CONTROLS)
        world.advertise("/base/muscles/cmd").publish(Float64MultiArray(data=list(CONTROLS.values())))
        for seconds in (0.004, 0.02, 0.05, 0.1, 0.2, 0.5, 2.0):  # half of them while the activations rise
            world.run_until(round(seconds * 1e9))
            positions, states, efforts = alone(PAIR, seconds)
            found = world.subscribe("/base/muscles/state").latest.message
            assert found.name == list(CONTROLS)
            assert world.joint_states("base").positions == pytest.approx(
                positions, abs=1e-6 if exact else 6e-4
            )
            assert found.length == pytest.approx(states[0], abs=1e-7 if exact else 5e-5)
            assert found.force == pytest.approx(states[2], rel=1e-5 if exact else 1e-3)
            assert found.activation == pytest.approx(states[3], abs=1e-9)
            assert world.joint_states("base").efforts == pytest.approx(efforts, rel=1e-4 if exact else 5e-3)


JOINTS = """<mujoco><option gravity="0 0 0"/><worldbody><site name="o" pos="0.2 0.1 0.5"/>
  <body name="cart"><inertial mass="1" pos="0 0 0" diaginertia="0.1 0.1 0.1"/>
    <joint name="rail" type="slide" axis="0.6 0 0.8"/>
    <body name="bone" pos="0.1 0 0.1" quat="0.9 0.1 0.3 0.2">
      <inertial mass="1" pos="0.02 0 0.1" quat="0.8 0.1 0.2 0.1" diaginertia="0.02 0.03 0.04"/>
      <joint name="hip" type="ball"/><site name="i" pos="0.05 0.02 0.2"/></body></body></worldbody>
  <tendon><spatial name="t"><site site="o"/><site site="i"/></spatial></tendon>
  <actuator><muscle name="m" tendon="t" lengthrange="0.2 0.5" force="100"/></actuator></mujoco>"""


@pytest.mark.parametrize("engine", ENGINES)
def test_muscles_are_in_the_efforts_of_slides_and_balls(engine, tmp_path):
    model = mujoco.MjModel.from_xml_string(JOINTS)
    data = mujoco.MjData(model)
    data.ctrl = 1.0
    mujoco.mj_step(model, data, 2)  # the second step has an activation
    with opened(arm(tmp_path, text=JOINTS), engine) as world:
        world.advertise("/cart/m/cmd").publish(Float64(1.0))
        world.run_until(4_000_000)
        states = world.joint_states("cart")
        assert states.names == ("rail", "hip_x", "hip_y", "hip_z")
        assert np.linalg.norm(states.efforts) > 1.0
        assert states.efforts == pytest.approx(data.qfrc_actuator, rel=1e-3)


@pytest.mark.parametrize("passive", ["none", "muscle"])
def test_muscles_with_another_passive_force_keep_it_and_need_mujoco(passive, tmp_path):
    """As the supraspinatus of MyoSuite's arm."""
    active, other = ("0.75 1.05 100 1 0.5 1.6 1.5 1.3 1.2", "0.3 1.5 200 1 0.5 1.8 1.5 0.5 1.2")
    text = ARM.format(muscle="", joint="")
    start, end = text.index("<muscle"), text.index("</actuator>")
    general = (
        f'<general name="m" tendon="t" lengthrange="0.25 0.35" dyntype="muscle" dynprm="0.01 0.04" '
        f'gaintype="muscle" gainprm="{active}" biastype="{passive}" biasprm="{other}"/>'
    )
    text = text[:start] + general + text[end:]
    scene = arm(tmp_path, text=text)
    with opened(scene, "mujoco") as world:
        world.advertise("/arm/muscles/cmd").publish(Float64MultiArray(data=[0.2]))
        world.run_until(50_000_000)
        found = state(world, "/arm/m/state")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl = 0.2
    mujoco.mj_step(model, data, 25)
    mujoco.mj_forward(model, data)
    values = data.actuator_length, data.actuator_velocity, -data.actuator_force, data.act
    assert found == pytest.approx(np.concatenate(values), rel=1e-6)
    with pytest.raises(CapabilityError, match="'m'"):
        opened(scene, "pybullet")


def test_an_engine_with_straight_muscles_does_not_report_their_tendons(tmp_path):
    with opened(arm(tmp_path, text=PAIR), "pybullet") as world:
        assert not [each for each in world.warnings if each.subject == "spatial"]


def test_moment_arms_are_those_of_mujoco_with_the_sign_of_a_pull(tmp_path):
    model = arm(tmp_path, text=PAIR).models[0]
    alone = mujoco.MjModel.from_xml_string(PAIR)
    data = mujoco.MjData(alone)
    mujoco.mj_forward(alone, data)
    rows = np.zeros((alone.nu, alone.nv))
    mujoco.mju_sparse2dense(
        rows, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
    )
    for number, muscle in enumerate(muscles_of(model)):
        arms = moment_arms(model, muscle)
        gear = alone.actuator_gear[number, 0]
        assert [arms.get(name, 0.0) for name in ("shoulder", "elbow")] == pytest.approx(
            -rows[number] / gear, abs=1e-8
        )


def test_the_outline_has_force_range_and_moment_arms(tmp_path):
    lines = "\n".join(outline(arm(tmp_path), "arm").lines())
    assert "muscle 'm', 100 N, active from 0.167 to 0.533 m, moment arm -49.3 mm at q" in lines
    assert "muscle group 'muscles': m" in lines
    assert "/arm/muscles/cmd" in lines


SDF = """<sdf version="1.9"><world name="w"><gravity>0 0 0</gravity><model name="arm">
  <link name="bone"><pose>0 0 0 0 0 0</pose><inertial><mass>1</mass><pose>0.15 0 0 0 0 0</pose>
    <inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>
  <joint name="q" type="revolute"><parent>world</parent><child>bone</child>
    <axis><xyz>0 1 0</xyz></axis></joint>
  <plugin name="m" filename="nrp_muscle">{path}<force>100</force><length_range>{range}</length_range></plugin>
  <plugin name="g" filename="nrp_muscle_group"><muscle>{member}</muscle></plugin></model></world></sdf>"""
PATH = (
    "<point><link>world</link><xyz>0 0 0.3</xyz></point><point><link>{link}</link><xyz>0.05 0 0</xyz></point>"
)


def written(folder: Path, **values: str) -> Scene:
    given = {
        "path": PATH.format(link=values.pop("link", "bone")),
        "range": "0.25 0.35",
        "member": "m",
        **values,
    }
    (folder / "arm.sdf").write_text(SDF.format(**given))
    return read_scene(folder / "arm.sdf")


@pytest.mark.parametrize("engine", ENGINES)
def test_a_muscle_of_sdf_is_that_of_mjcf(engine, tmp_path):
    found = []
    for scene, topic in ((written(tmp_path), "/arm/g/cmd"), (arm(tmp_path), "/arm/muscles/cmd")):
        with opened(scene, engine) as world:
            world.advertise(topic).publish(Float64MultiArray(data=[0.2]))
            world.run_until(50_000_000)
            joints = world.joint_states("arm")
            found.append([*joints.positions, *joints.velocities, *state(world, "/arm/m/state")])
    assert found[0] == pytest.approx(found[1], abs=1e-6)
    assert found[0][:2] == pytest.approx([-0.0267919, -1.10619392], rel=1e-5 if engine == "mujoco" else 2e-3)


@pytest.mark.parametrize(
    ("values", "part"),
    [
        ({"link": "bonee"}, "bone"),
        ({"path": "<point><link>bone</link><xyz>0 0 0</xyz></point>"}, "1 <point>"),
        ({"range": "0.35 0.25"}, "length_range"),
        ({"range": "0.25 0.35</length_range><smoothing>-1</smoothing><length_range>"}, "smoothing"),
        ({"member": "n"}, "the muscle 'n'"),
    ],
)
def test_mistakes_are_one_error_with_their_line(values, part, tmp_path):
    with pytest.raises(SceneError, match=part) as caught:
        written(tmp_path, **values)
    assert caught.value.line is not None


def test_groups_take_as_many_finite_numbers_as_they_have_muscles(tmp_path, golden: Golden):
    with opened(written(tmp_path), "mujoco") as world:
        cmd = world.advertise("/arm/g/cmd")
        for wrong in ([], [0.1, 0.2]):
            with golden.raises(TopicError):
                cmd.publish(Float64MultiArray(data=wrong))
        with golden.raises(TopicError):
            cmd.publish(Float64MultiArray(data=[float("nan")]))
        cmd.publish(Float64MultiArray(data=[1.5]))
        assert [each.code for each in world.warnings] == [Code.NRP299]


@pytest.mark.parametrize("engine", ENGINES)
def test_snapshots_hold_the_state_of_muscles(engine, tmp_path):
    with opened(arm(tmp_path, text=PAIR), engine) as world:
        cmd = world.advertise("/base/muscles/cmd")
        cmd.publish(Float64MultiArray(data=[0.9, 0.0, 0.4, 0.1]))
        world.run_until(20_000_000)
        saved = world.snapshot()
        world.run_until(60_000_000)
        there = world.subscribe("/base/muscles/state").latest.message
        cmd.publish(Float64MultiArray(data=[0.0, 0.0, 0.0, 0.0]))
        world.run_until(80_000_000)
        world.restore(saved)
        world.run_until(60_000_000)
        again = world.subscribe("/base/muscles/state").latest.message
        assert again.activation.tolist() == there.activation.tolist()
        assert again.force == pytest.approx(there.force, rel=1e-12)
        world.reset()
        assert not world.subscribe("/base/muscles/state").latest.message.activation.any()


def test_muscles_count_in_the_digest_of_a_scene(tmp_path):
    scene = written(tmp_path)
    (model,) = scene.models
    stronger = tuple(replace(each, force=200.0) if each.name == "m" else each for each in model.drives)
    assert replace(scene, models=(replace(model, drives=stronger),)).digest != scene.digest


@pytest.mark.parametrize("engine", ENGINES)
def test_copies_take_the_controls_of_a_group_as_rows_and_move_as_alone(engine, tmp_path, golden: Golden):
    scene, backend, topic = arm(tmp_path, text=PAIR), worlds().load(engine), "/base/muscles/cmd"
    rows = np.array([[0.9, 0.0, 0.4, 0.1], [0.0, 0.6, 0.0, 0.3]])
    with backend.open_batch(scene, seeds=[1, 2], options=backend.options(), threads=0) as batch:
        batch.advertise(topic).publish(rows)
        with golden.raises(TopicError):
            batch.advertise(topic).publish(rows[:, :3])
        batch.run_until(60_000_000)
        together = batch.joint_states("base").positions
    for row, positions in zip(rows, together, strict=True):
        with backend.open(scene, seed=1, options=backend.options()) as world:
            world.advertise(topic).publish(Float64MultiArray(data=row))
            world.run_until(60_000_000)
            assert world.joint_states("base").positions.tolist() == positions.tolist()
    assert (together[0] != together[1]).all()
