"""MJCF, read by MuJoCo, is a scene like any other, for both engines."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from golden import Golden

from nrp_core import worlds
from nrp_core.errors import SceneError
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController, Pid
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import Box, Capsule, Mesh, Scene
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.sensors.camera import Camera

LAB = """<mujoco model="lab">
  <option gravity="0 0 -9.8"/>
  <compiler angle="degree"/>
  <asset><material name="steel" rgba="0.1 0.2 0.3 1"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" rgba="0 1 0 1"/>
    <body name="table" pos="3 0 0.4"><geom type="box" size="0.5 0.4 0.02" material="steel"/></body>
    <body name="ball" pos="0 2 1.1"><freejoint/><geom type="sphere" size="0.1" mass="2"/></body>
    <body name="arm" pos="0 0 2" euler="0 0 90">
      <joint name="shoulder" type="hinge" axis="0 1 0" range="-120 90" damping="0.05"/>
      <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.04" mass="1" contype="0" conaffinity="0"/>
      <body name="forearm" pos="0.5 0 0">
        <joint name="elbow" type="hinge" axis="0 1 0" pos="0 0 0.01" damping="0.05"/>
        <joint name="reach" type="slide" axis="1 0 0" range="-0.1 0.1" damping="5"/>
        <geom type="box" size="0.2 0.03 0.03" pos="0.2 0 0" mass="0.5" contype="0" conaffinity="0"/>
        <camera name="eye" pos="0.4 0 0" xyaxes="0 -1 0 0 0 1" fovy="45"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="shoulder" gear="2" ctrlrange="-3 3"/>
    <position joint="reach" kp="200" kv="20" forcerange="-50 50"/>
    <velocity joint="elbow" kv="5"/>
    <damper joint="elbow" kv="1" ctrlrange="0 1"/>
  </actuator>
</mujoco>"""


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))


@pytest.fixture
def lab(tmp_path: Path) -> Scene:
    (tmp_path / "lab.xml").write_text(LAB)
    return read_scene(tmp_path / "lab.xml")


def test_bodies_are_models_links_and_joints(lab):
    assert [(model.name, model.static) for model in lab.models] == [
        ("lab_ground", True), ("table", True), ("ball", False), ("arm", False)
    ]  # fmt: skip
    arm = lab.model("arm")
    shoulder, elbow, reach = arm.joints
    assert (shoulder.kind, elbow.kind, reach.kind) == ("revolute", "continuous", "prismatic")
    assert (shoulder.parent, shoulder.lower) == ("world", pytest.approx(np.radians(-120)))
    assert arm.pose.yaw == pytest.approx(np.pi / 2)
    assert arm.link("forearm").inertial.mass == pytest.approx(0.5)
    assert lab.warnings == ()
    assert (shoulder.effort, elbow.effort, reach.effort) == (6, np.inf, 50)
    assert arm.controllers == (
        JointController("shoulder", "effort", "/arm/shoulder/cmd_effort", Pid(), range=(-6.0, 6.0)),
        JointController("reach", "position", "/arm/reach/cmd_pos", Pid(200, 0, 20, 1), 0.0, beyond=True),
        JointController("elbow", "velocity", "/arm/elbow/cmd_vel", Pid(5), 0.0),
    )


def test_geoms_are_what_is_seen_and_touched(lab):
    (table,) = lab.model("table").links
    assert table.visuals[0].geometry == table.collisions[0].geometry == Box((1, 0.8, 0.04))
    assert table.visuals[0].rgba == pytest.approx((0.1, 0.2, 0.3, 1))
    arm = lab.model("arm").link("arm")
    assert isinstance(arm.visuals[0].geometry, Capsule)
    assert arm.collisions == ()


def test_a_camera_looks_where_mujocos_does(lab):
    (eye,) = lab.model("arm").link("forearm").sensors
    assert isinstance(eye, Camera)
    assert eye.pose.rotate((1, 0, 0)) == pytest.approx((1, 0, 0), abs=1e-9)
    assert eye.pose.rotate((0, 0, 1)) == pytest.approx((0, 0, 1), abs=1e-9)


def test_it_moves_as_in_mujoco_itself(open_world, lab, tmp_path):
    world = open_world(lab)
    native = mujoco.MjModel.from_xml_path(str(tmp_path / "lab.xml"))
    native.opt.timestep, data = 0.002, mujoco.MjData(native)
    for _ in range(20):  # not yet at the limit of a joint, which is softer in MuJoCo
        world.run_until(world.now_ns + 20_000_000)
        mujoco.mj_step(native, data, 10)
        mujoco.mj_forward(native, data)
        states = world.joint_states("arm")
        assert list(states.positions) == pytest.approx(data.qpos[-3:].tolist(), abs=0.03)
        assert world.model_motion("ball").pose.position == pytest.approx(
            data.body("ball").xpos.tolist(), abs=0.03
        )


def test_commands_do_what_mujocos_actuators_do(open_world, lab, tmp_path):
    world = open_world(lab)
    native = mujoco.MjModel.from_xml_path(str(tmp_path / "lab.xml"))
    native.opt.timestep, data = 0.002, mujoco.MjData(native)
    data.ctrl[:] = -1.0, 0.05, -1.0, 0.0
    for topic, command in (("shoulder/cmd_effort", -2.0), ("reach/cmd_pos", 0.05), ("elbow/cmd_vel", -1.0)):
        world.advertise(f"/arm/{topic}").publish(Float64(command))
    for _ in range(20):  # not yet at the limit of a joint, which is softer in MuJoCo
        world.run_until(world.now_ns + 20_000_000)
        mujoco.mj_step(native, data, 10)
        mujoco.mj_forward(native, data)
        positions = list(world.joint_states("arm").positions)
        assert positions == pytest.approx(data.qpos[-3:].tolist(), abs=0.03)


def test_meshes_come_along(tmp_path):
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    write_stl(tmp_path / "a.stl", corners[[(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]])
    asset = '<asset><mesh name="a" file="a.stl" scale="2 2 2"/></asset>'
    body = '<body name="thing" pos="1 0 0"><freejoint/><geom type="mesh" mesh="a"/></body>'
    (tmp_path / "thing.xml").write_text(f"<mujoco>{asset}<worldbody>{body}</worldbody></mujoco>")
    thing = read_model(tmp_path / "thing.xml", name="it")
    assert thing.name == "it"
    (link,) = thing.links
    assert isinstance(link.visuals[0].geometry, Mesh)
    assert link.inertial.mass == pytest.approx(1000 * 8 / 6)


def test_a_model_that_mujoco_cannot_read_is_one_error(tmp_path, golden: Golden):
    (tmp_path / "bad.xml").write_text("<mujoco><worldbody><geom type='ring'/></worldbody></mujoco>")
    with golden.raises(SceneError, match="MuJoCo") as refusal:
        read_scene(tmp_path / "bad.xml")
    assert "\n" not in refusal.value.message
    assert refusal.value.path == tmp_path / "bad.xml"


def test_ball_joints_move_as_in_mujoco_itself(open_world, tmp_path):
    box = '<geom type="box" size=".05 .02 .2" pos="0 0 -.2" mass="1"/>'
    link = f'<joint name="{{}}" type="ball" damping="0.02"/>{box}'
    arm = f'<body name="arm" pos="0 0 2" euler="40 20 0">{link.format("shoulder")}'
    arm += f'<body name="forearm" pos="0 0 -0.4">{link.format("elbow")}</body></body>'
    (tmp_path / "arm.xml").write_text(
        f"<mujoco><option gravity='0 0 -9.8'/><worldbody>{arm}</worldbody></mujoco>"
    )
    scene = read_scene(tmp_path / "arm.xml")
    world = open_world(scene)
    native = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    native.opt.timestep, data = 0.002, mujoco.MjData(native)
    assert [joint.kind for joint in scene.model("arm").joints] == ["ball", "ball"]
    for _ in range(20):
        world.run_until(world.now_ns + 20_000_000)
        mujoco.mj_step(native, data, 10)
        mujoco.mj_forward(native, data)
        assert world.joint_states("arm").velocities == pytest.approx(data.qvel, abs=0.05)
        there = world.link_motion("arm", "forearm").pose.position
        assert there == pytest.approx(data.body("forearm").xpos.tolist(), abs=0.01)


@pytest.mark.parametrize(
    ("of_file", "of_floor", "slides"),
    [(1.0, 1.0, False), (1.0, 0.05, True), (0.05, 2.0, True), (2.0, 1.0, False)],
)
def test_the_more_slippery_of_a_box_in_mjcf_and_a_floor_in_sdf_decides(
    open_world, tmp_path, of_file, of_floor, slides
):
    box = f'<geom type="box" size=".1 .1 .05" mass="1" friction="{of_file} 0 0"/>'
    body = f'<body name="box" pos="0 0 0.1"><freejoint/>{box}</body>'
    (tmp_path / "box.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    mu = f"<surface><friction><ode><mu>{of_floor}</mu></ode></friction></surface>"
    plane = f"<geometry><plane><normal>0 0 1</normal></plane></geometry>{mu}"
    floor = f'<link name="l"><collision name="c">{plane}</collision></link>'
    (tmp_path / "room.sdf").write_text(
        f'<sdf version="1.9"><world name="w"><gravity>3 0 -9.4</gravity>'
        f'<model name="floor"><static>true</static>{floor}</model></world></sdf>'
    )
    robot = read_model(tmp_path / "box.xml", name="box")
    world = open_world(read_scene(tmp_path / "room.sdf").with_model(robot))
    world.run_until(1_000_000_000)
    assert (world.model_motion("box").pose.position[0] > 0.5) == slides


_SERVO = """<mujoco model="arm">{more}<worldbody><body name="upper" pos="0 0 1">
  <joint name="shoulder" axis="0 1 0" range="-90 90" {joint}/>
  <geom type="sphere" size="0.1" pos="0.3 0 0" mass="1"/></body></worldbody>
<actuator><position joint="shoulder" kp="20" {force}/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("joint", "force", "more", "words"),
    [
        ('armature="0.1" frictionloss="1"', 'forcerange="-50 50"', "", ""),
        ("", 'forcerange="-5 50"', "", "and joints have one limit for both directions: the limit used is 50"),
        ("", 'forcerange="-5 50" forcelimited="false"', "", ""),
        ("", "", '<keyframe><key qpos="1" qvel="1"/></keyframe>', "the velocities of 1 keyframes"),
        ("", 'ctrlrange="-1.5 1.5"', "", ""),
        ("", 'ctrlrange="-0.05 0.05"', "", ""),
        ("", 'ctrlrange="-90 90" gear="60"', "", ""),  # of the motor's shaft
        ("", 'ctrlrange="1.5 3"', "", ""),
        ("", 'ctrlrange="2 3" gear="60"', "", ""),
        ("", '/><velocity name="b" joint="shoulder" kv="9"', "", ""),
        ("", '/><motor name="b" joint="shoulder"', "", ""),
        ('damping="1"', 'gear="-1"', "", ""),
    ],
)  # fmt: skip
def test_forces_that_are_lost_are_reported(
    tmp_path: Path, joint: str, force: str, more: str, words: str
) -> None:
    (tmp_path / "arm.xml").write_text(_SERVO.format(joint=joint, force=force, more=more))
    found = [str(one) for one in read_model(tmp_path / "arm.xml").warnings]
    assert len(found) == bool(words)
    assert all(words in one for one in found)


CART = """<mujoco><worldbody><geom type="plane" size="9 9 1"/><body name="cart" pos="0 0 0.1"><freejoint/>
  <geom type="box" size=".2 .1 .03" mass="2"/>
  <body name="l" pos="0 .15 -.02"><joint name="left" axis="0 1 0"/><geom size=".08" mass=".1"/></body>
  <body name="r" pos="0 -.15 -.02"><joint name="right" axis="0 1 0"/><geom size=".08" mass=".1"/></body>
  <body name="c" pos="-.15 0 -.02"><joint type="ball"/><geom size=".08" mass=".1"/></body>
</body></worldbody></mujoco>"""
ROOM = """<sdf version="1.9"><world name="w"><include><uri>model://ground_plane</uri></include>
<include><uri>cart.xml</uri><name>husky</name>{}</include></world></sdf>"""
WHEELS = """<plugin name="gz::sim::systems::DiffDrive" filename="d"><left_joint>left</left_joint>
<right_joint>right</right_joint><wheel_separation>.3</wheel_separation><wheel_radius>.08</wheel_radius>
<topic>cmd</topic></plugin>"""


@pytest.mark.parametrize(("drive", "friction"), [(WHEELS, 0.0), ("", 1.0)])
def test_a_drive_moves_an_included_file_with_smooth_wheels_and_nothing_else_is_smooth(
    tmp_path, drive, friction
):
    (tmp_path / "cart.xml").write_text(CART)
    (tmp_path / "room.sdf").write_text(ROOM.format(drive))
    scene = read_scene(tmp_path / "room.sdf")
    assert [model.name for model in scene.models] == ["ground_plane", "husky"]
    backend = worlds().load("mujoco")
    with backend.open(scene, seed=1, options=backend.options()) as world:
        model = world.engine._model
        found = {name: model.geom(f"husky/{name}/geom_{n}").friction[0] for n, name in enumerate("lrc", 2)}
        if drive:
            world.advertise("/husky/cmd").publish(Twist(Vector3(0.5, 0.0, 0.0), Vector3()))
        world.run_until(2_000_000_000)
        went = world.model_motion("husky").pose.position[0]
    assert found == {"l": friction, "r": friction, "c": 1.0}
    assert went == pytest.approx(1.0 if drive else 0.0, abs=0.01)


LIMITED = """<mujoco><compiler angle="radian"/><worldbody><body name="arm" pos="0 0 1">
  <joint name="hinge" axis="0 1 0" damping="0.1" range="-1 1"/><geom size="0.05" pos="0.1 0 0" mass="0.2"/>
</body></worldbody><actuator><{}/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("actuator", "topic"),
    [
        ('position joint="hinge" kp="3" kv="0.1" gear="2" ctrlrange="-0.2 0.2"', "cmd_pos"),
        ('position joint="hinge" kp="3" kv="0.1" inheritrange="0.5"', "cmd_pos"),
        ('velocity joint="hinge" kv="1" ctrlrange="-0.2 0.2"', "cmd_vel"),
        ('motor joint="hinge" gear="-2" ctrlrange="-0.1 0.05"', "cmd_effort"),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_commands_are_clamped_to_the_range_of_the_actuator(open_world, tmp_path, actuator, topic, sign):
    (tmp_path / "arm.xml").write_text(LIMITED.format(actuator))
    native = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    native.opt.timestep, native.opt.integrator = 0.002, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data, world = mujoco.MjData(native), open_world(read_scene(tmp_path / "arm.xml"))
    gear = native.actuator_gear[0][0]
    data.ctrl[0] = 0.9 * sign
    command = data.ctrl[0] * gear if topic == "cmd_effort" else data.ctrl[0] / gear
    world.advertise(f"/arm/hinge/{topic}").publish(Float64(command))
    world.run_until(200_000_000)
    mujoco.mj_step(native, data, 100)
    assert world.joint_states("arm").positions[0] == pytest.approx(data.qpos[0], abs=0.02)


def test_a_file_may_have_another_suffix_than_xml(tmp_path):
    (tmp_path / "box.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    )
    part = '<worldbody><body name="arm"><joint name="j"/><geom type="mesh" mesh="box"/></body></worldbody>'
    (tmp_path / "part.mjcf").write_text(f'<mujoco><asset><mesh file="box.obj"/></asset>{part}</mujoco>')
    (tmp_path / "arm.mjcf").write_text('<mujoco><include file="part.mjcf"/></mujoco>')
    native = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.mjcf"))
    (model,) = read_scene(tmp_path / "arm.mjcf").models
    (link,) = model.links
    assert link.inertial.mass == pytest.approx(native.body("arm").mass[0])


SEVERAL = """<mujoco><compiler angle="radian"/><worldbody><body name="arm" pos="0 0 1">
  <joint name="hinge" axis="0 1 0"/><geom size="0.05" pos="0.2 0 0" mass="0.5"/></body></worldbody>
  <actuator><{} name="first" joint="hinge"/>
  <position name="servo" joint="hinge" kp="9" kv="0.2"/></actuator></mujoco>"""


@pytest.mark.parametrize("other", ['velocity kv="0.5"', "motor"])
def test_the_forces_of_several_actuators_of_a_joint_add_up(tmp_path, other):
    (tmp_path / "arm.xml").write_text(SEVERAL.format(other))
    native = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    data = mujoco.MjData(native)
    data.ctrl[:] = 0.7, 0.4
    scene, backend = read_scene(tmp_path / "arm.xml"), worlds().load("mujoco")
    with backend.open(scene, seed=1, options=backend.options()) as world:
        world.advertise("/arm/first/cmd").publish(Float64(0.7))
        world.advertise("/arm/hinge/cmd_pos").publish(Float64(0.4))
        world.run_until(400_000_000)
        mujoco.mj_step(native, data, 200)
        assert world.joint_states("arm").positions[0] == pytest.approx(data.qpos[0], abs=1e-6)


def test_a_ball_lies_in_the_valley_of_a_height_field(open_world, tmp_path):
    field = '<hfield name="h" nrow="3" ncol="3" size="1 1 0.5 0.1" elevation="1 1 1 1 0 1 1 1 1"/>'
    ball = '<body name="ball" pos="0.1 0 0.4"><freejoint/><geom size="0.1" mass="1"/></body>'
    ground = f'<geom type="hfield" hfield="h"/>{ball}'
    (tmp_path / "valley.xml").write_text(
        f"<mujoco><asset>{field}</asset><worldbody>{ground}</worldbody></mujoco>"
    )
    world = open_world(read_scene(tmp_path / "valley.xml"))
    world.run_until(2_000_000_000)
    x, y, z = world.model_motion("ball").pose.position
    assert (x, y) == pytest.approx((0, 0), abs=0.1)
    assert 0.09 < z < 0.16


def test_a_height_field_has_the_mean_colour_of_its_image(tmp_path):
    """As on the terrain of MyoSuite's legs, whose image is a chequerboard."""
    image = '<texture name="t" type="2d" builtin="flat" rgb1="0.2 0.4 0.6" width="4" height="4"/>'
    field = '<hfield name="h" nrow="3" ncol="3" size="1 1 0.5 0.1" elevation="1 1 1 1 0 1 1 1 1"/>'
    (tmp_path / "valley.xml").write_text(
        f'<mujoco><asset>{image}{field}<material name="m" texture="t"/></asset>'
        '<worldbody><geom type="hfield" hfield="h" material="m"/></worldbody></mujoco>'
    )
    (visual,) = read_scene(tmp_path / "valley.xml").models[0].links[0].visuals
    assert visual.rgba[:3] == pytest.approx((0.2, 0.4, 0.6), abs=0.01)
