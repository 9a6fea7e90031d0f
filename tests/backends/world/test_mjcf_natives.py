"""What MJCF says beyond a scene acts as in MuJoCo alone, and other engines say that they lack it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from golden import Golden
from nrp_world_mujoco.mechanisms import touches_itself
from scipy.spatial import ConvexHull

from nrp_core import World, worlds
from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.meshes.convex import convex_pieces
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import Scene
from nrp_core.scene.outline import outline
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene

GECKO = """<mujoco>
  <option impratio="10"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <geom name="wall" type="box" size="0.05 1 1" pos="0.15 0 1"/>
    <body name="pad" pos="0 0 1"><freejoint/>
      <geom name="sole" type="box" size="0.1 0.05 0.05" mass="0.1"/>
      <site name="root" pos="0.05 0 0.04"/>
      <body name="tail" pos="-0.1 0 0"><joint name="wag" axis="0 1 0" armature="0.01" damping="0.1" ref="10"/>
        <geom type="capsule" fromto="0 0 0 -0.2 0 0" size="0.01" mass="0.02"/>
        <site name="end" pos="-0.2 0 0"/></body>
      <body name="drum" pos="0 0 -0.1"><geom name="drum" type="cylinder" size="0.02 0.05" mass="0.01"/></body>
    </body>
  </worldbody>
  <contact><pair geom1="sole" geom2="wall" condim="4" friction="1 1 0.01 0.001 0.001"/></contact>
  <tendon><spatial name="cord" stiffness="1"><site site="root"/><geom geom="drum"/>
    <site site="end"/></spatial></tendon>
  <actuator><adhesion name="grip" body="pad" ctrlrange="0 10" gain="1"/>
    <muscle name="pull" tendon="cord" lengthrange="0.05 0.4" force="2"/></actuator>
</mujoco>"""

LINKAGE = """<mujoco><compiler angle="radian"/><option viscosity="0.5" wind="1 0 0"/>
  <worldbody>
    <body name="crank"><joint name="crank_pin" axis="0 1 0" ref="0.4"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.3" size="0.02" mass="1"/>
      <body name="rod" pos="0 0 0.3"><joint name="rod_pin" axis="0 1 0" damping="0.05"/>
        <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" mass="0.5"/></body></body>
    <body name="rocker" pos="0.4 0 0"><joint name="rocker_pin" axis="0 1 0" damping="0.05" range="-2 2"
        solreflimit="0.01 1"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.3" size="0.02" mass="1"/></body>
    <body name="door" pos="0 1 0"><joint name="hinge" axis="1 0 0" ref="-0.2"/>
      <geom type="box" size="0.1 0.2 0.02" pos="0 0.2 0" mass="1"/><site name="knob" pos="0 0.3 0"/></body>
    <body name="slider" pos="0 2 0"><joint name="slide" type="slide" axis="0 0 1" damping="3"/>
      <geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    <body name="load" pos="0.5 2 0"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="0.5"/></body>
  </worldbody>
  <contact><exclude body1="slider" body2="load"/></contact>
  <tendon><fixed name="cable" stiffness="20" springlength="0.1">
    <joint joint="crank_pin" coef="0.5"/></fixed></tendon>
  <equality>
    <connect body1="rod" body2="rocker" anchor="0.4 0 0"/>
    <weld body1="slider" body2="load" anchor="0.1 0 0" solref="0.01 1"/>
    <joint joint1="hinge" joint2="slide" polycoef="0 0.5 0.3 0 0"/>
  </equality>
  <actuator>
    <general name="turn" joint="crank_pin" gainprm="2" biastype="affine" biasprm="0.1 -3 -0.2"
      dyntype="filter" dynprm="0.05"/>
    <motor name="lift" site="knob" gear="0 0 2 0 0 0"/>
    <position name="cable" tendon="cable" kp="4"/>
  </actuator>
</mujoco>"""

HOPPER = """<mujoco><option cone="pyramidal" timestep="0.002"/>
  <asset><mesh name="toes" file="toes.stl"/></asset>
  <worldbody><geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="hip" pos="0 0 0.45" euler="0 10 20"><freejoint/>
      <geom type="box" size="0.1 0.1 0.05" mass="1" contype="0" conaffinity="0"/>
      <body name="thigh" pos="0 0 -0.05"><joint name="swing" axis="0 1 0" damping="0.2"/>
        <geom type="capsule" fromto="0 0 0 0.1 0 -0.2" size="0.02" mass="0.2" contype="0" conaffinity="0"/>
        <body name="foot" pos="0.1 0 -0.2"><joint name="ankle" axis="0 1 0" stiffness="4" damping="0.03"
            range="-1 1"/>
          <geom name="toes" type="mesh" mesh="toes" mass="0.01"/></body></body></body></worldbody>
  <actuator><position joint="swing" kp="30" ctrlrange="-2 2"/></actuator></mujoco>"""

FLOOR = '<sdf version="1.9"><world name="w"><include><uri>model://ground_plane</uri></include></world></sdf>'


def opened(scene: Scene, engine: str = "mujoco") -> World:
    backend = worlds().load(engine)
    return backend.open(scene, seed=1, options=backend.options())


def alone(
    text: str, controls: Mapping[str, float], seconds: float, assets: Mapping[str, bytes] | None = None
) -> dict[str, float]:
    """Return the positions of joints, and heights of bodies, in MuJoCo without this program."""
    model = mujoco.MjModel.from_xml_string(text, dict(assets or {}))
    data = mujoco.MjData(model)
    for name, value in controls.items():
        data.actuator(name).ctrl = value
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
    mujoco.mj_forward(model, data)
    moved = data.qpos - model.qpos0
    single = [model.joint(n) for n in range(model.njnt) if model.jnt_type[n] != mujoco.mjtJoint.mjJNT_FREE]
    joints = {each.name: float(moved[each.qposadr[0]]) for each in single}
    return joints | {model.body(n).name + "_z": float(data.xpos[n][2]) for n in range(1, model.nbody)}


def ours(world: World, bodies: Mapping[str, str], seconds: float) -> dict[str, float]:
    world.run_until(round(seconds * 1e9))
    found: dict[str, float] = {}
    for model in world.scene.models:
        if not model.static:
            states = world.joint_states(model.name)
            found |= dict(zip(states.names, states.positions.tolist(), strict=True))
    heights = {f"{link}_z": world.link_motion(model, link).pose.position[2] for link, model in bodies.items()}
    return found | heights


@pytest.mark.parametrize(("grip", "pull"), [(0.0, 0.0), (5.0, 0.0), (5.0, 0.5)])
def test_adhesion_pairs_and_muscles_act_as_in_mujoco_alone(tmp_path, grip, pull):
    (tmp_path / "gecko.xml").write_text(GECKO)
    with opened(read_scene(tmp_path / "gecko.xml")) as world:
        for name, value in (("grip", grip), ("pull", pull)):
            world.advertise(f"/pad/{name}/cmd").publish(Float64(value))
        found = ours(world, {"pad": "pad", "tail": "pad"}, 0.5)
    wanted = alone(GECKO, {"grip": grip, "pull": pull}, 0.5)
    assert (wanted["pad_z"] > 0.99) == (grip > 0)  # it sticks to the wall
    assert found == pytest.approx({name: wanted[name] for name in found}, abs=1e-5)


def test_loops_welds_tendons_and_actuators_of_any_kind_act_as_in_mujoco_alone(tmp_path):
    (tmp_path / "linkage.xml").write_text(LINKAGE)
    controls = {"turn": 1.5, "lift": 3.0, "cable": 0.7}
    with opened(read_scene(tmp_path / "linkage.xml")) as world:
        topics = {name: f"/{owner}/{name}/cmd"
                  for name, owner in (("turn", "crank"), ("lift", "door"), ("cable", "crank"))}  # fmt: skip
        for name, value in controls.items():
            world.advertise(topics[name]).publish(Float64(value))
        found = ours(world, {"rod": "crank", "load": "load", "slider": "slider"}, 0.6)
    wanted = alone(LINKAGE, controls, 0.6)
    assert abs(wanted["crank_pin"]) > 0.1
    assert wanted["load_z"] == pytest.approx(wanted["slider_z"], abs=0.02)
    assert found == pytest.approx({name: wanted[name] for name in found}, abs=1e-5)


LEG = """<mujoco><option tolerance="1e-12" impratio="1.0000001"/>
  <worldbody>
    <body name="leg"><joint name="knee" armature="1e-10"/><geom size="0.001" mass="1e-6"/></body>
  </worldbody>
  <tendon><fixed stiffness="1e-9"><joint joint="knee" coef="1"/></fixed></tendon>
</mujoco>"""


def hopped(folder: Path) -> tuple[dict[str, float], dict[str, float]]:
    """Return how a leg with a round foot of 400 corners lands, here and in MuJoCo alone."""
    spread = np.random.default_rng(1).normal(size=(400, 3))
    corners = 0.05 * spread / np.linalg.norm(spread, axis=1)[:, None] * (2.0, 1.0, 1.0)
    write_stl(folder / "toes.stl", corners[ConvexHull(corners).simplices])
    (folder / "hopper.xml").write_text(HOPPER)
    with opened(read_scene(folder / "hopper.xml")) as world:
        world.advertise("/hip/swing/cmd_pos").publish(Float64(0.4))
        found = ours(world, {"hip": "hip", "foot": "hip"}, 0.3)
    text = HOPPER.replace('kp="30"', 'name="swing" kp="30"')
    return found, alone(text, {"swing": 0.4}, 0.3, {"toes.stl": (folder / "toes.stl").read_bytes()})


def test_position_servos_springs_and_meshes_of_a_file_act_as_in_mujoco_alone(tmp_path):
    found, wanted = hopped(tmp_path)
    assert wanted["hip_z"] > 0.2  # it has landed; in free fall it would be at 0.01 m
    assert found == pytest.approx({name: wanted[name] for name in found}, abs=1e-12)


def test_a_hull_of_a_scene_is_another_shape_than_the_mesh_of_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr("nrp_world_mujoco.mjcf.files_of", lambda *_: {})
    found, wanted = hopped(tmp_path)
    assert found == pytest.approx({name: wanted[name] for name in found}, abs=1e-7)
    assert found != pytest.approx({name: wanted[name] for name in found}, abs=1e-11)


def test_a_mesh_in_a_folder_of_its_own_is_that_of_mujoco_alone_bit_for_bit(tmp_path):
    hopped(tmp_path)
    (tmp_path / "parts").mkdir()
    (tmp_path / "toes.stl").rename(tmp_path / "parts" / "toes.stl")
    text = HOPPER.replace("<asset>", '<compiler meshdir="parts"/><asset>').replace(
        'file="toes.stl"', 'file="toes.stl" scale="1 1.1 0.9" refpos="0.01 0 0"'
    )
    (tmp_path / "hopper.xml").write_text(text.replace('mesh="toes"', 'mesh="toes" pos="0 0.1 0.02"'))
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "hopper.xml"))
    with opened(read_scene(tmp_path / "hopper.xml")) as world:
        ours = world.engine._model
    assert ours.nmesh == 1
    for field in ("mesh_vert", "mesh_graph"):
        np.testing.assert_array_equal(getattr(ours, field), getattr(theirs, field))
    place = [model.geom(name).pos.tolist() for model, name in ((ours, "hip/foot/toes"), (theirs, "toes"))]
    assert place[0] == pytest.approx(place[1], abs=1e-15)


@pytest.mark.parametrize("faces", ["", "0 2 1 0 3 2 0 1 4 1 2 4 2 3 4 3 0 4"])
def test_a_mesh_whose_corners_are_in_the_file_is_that_of_mujoco_alone_bit_for_bit(tmp_path, faces):
    corners = "-.1 -.07 0 .13 -.05 0 .1 .05 0.01 -.1 .05 0 0 0.003 .08"
    given = f'vertex="{corners}" scale="1 1.1 0.9" ' + (f'face="{faces}"' if faces else "")
    (tmp_path / "hopper.xml").write_text(HOPPER.replace('file="toes.stl"', given))
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "hopper.xml"))
    with opened(read_scene(tmp_path / "hopper.xml")) as world:
        ours = world.engine._model
    for field in ("mesh_vert", "mesh_graph"):
        np.testing.assert_array_equal(getattr(ours, field), getattr(theirs, field))


def test_numbers_near_the_usual_ones_are_kept(tmp_path):
    """Those of an insect are, in SI units."""
    (tmp_path / "leg.xml").write_text(LEG)
    with opened(read_scene(tmp_path / "leg.xml")) as world:
        model = world.engine._model
    assert (model.opt.tolerance, model.opt.impratio) == (1e-12, 1.0000001)
    assert model.joint("leg/knee").armature == 1e-10
    assert model.tendon_stiffness.max() == 1e-9


def damped_servos(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nrp_world_mujoco.native.NativeElements.declared", {})


def coarse_meshes(monkeypatch: pytest.MonkeyPatch) -> None:
    coarse = "nrp_core.scene.meshes.convert.whole_hull"
    monkeypatch.setattr(coarse, lambda triangles: convex_pieces(triangles)[0])
    monkeypatch.setattr("nrp_world_mujoco.mjcf.files_of", lambda *_: {})


@pytest.mark.parametrize("mistake", [damped_servos, coarse_meshes])
def test_a_leg_distinguishes_servos_and_meshes_of_engines(tmp_path, monkeypatch, mistake):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    mistake(monkeypatch)
    found, wanted = hopped(tmp_path)
    assert found != pytest.approx({name: wanted[name] for name in found}, abs=2e-4)


def test_a_robot_stands_on_the_room_although_its_file_has_pairs_only_with_its_own_floor(
    tmp_path, golden: Golden
):
    (tmp_path / "gecko.xml").write_text(GECKO)
    (tmp_path / "room.sdf").write_text(FLOOR)
    robot = read_model(tmp_path / "gecko.xml", name="gecko")
    assert "'gecko_ground'" in str(robot.warnings[0])
    golden(str(robot.warnings[0]))
    with opened(read_scene(tmp_path / "room.sdf").with_model(robot)) as world:
        world.run_until(1_000_000_000)
        assert 0.04 < world.model_motion("gecko").pose.position[2] < 0.06
        assert any("touch everything" in warning.message for warning in world.warnings)


def test_another_engine_names_the_actuators_that_it_lacks(tmp_path):
    cord = GECKO.replace('<muscle name="pull"', '<motor name="pull"').replace(
        'lengthrange="0.05 0.4" force="2"', ""
    )
    (tmp_path / "gecko.xml").write_text(cord)
    with opened(read_scene(tmp_path / "gecko.xml"), "pybullet") as world:
        world.advertise("/pad/grip/cmd").publish(Float64(1.0))
        world.run_until(20_000_000)
        lacking = {warning.subject for warning in world.warnings if warning.code is Code.NRP260}
    assert {"grip", "pull", "spatial"} <= lacking


def test_inspect_shows_what_is_for_mujoco_and_that_pairs_touch(tmp_path):
    (tmp_path / "gecko.xml").write_text(GECKO)
    text = "\n".join(outline(read_scene(tmp_path / "gecko.xml"), "gecko").lines())
    assert "touches with box" in text
    assert "1 collision shape" in text
    assert "1 <pair>" in text


PAIR = '<mujoco:contact><mujoco:pair geom1="hand/palm" geom2="x"/></mujoco:contact>'
ARM = """<sdf version="1.9"><model name="arm" xmlns:mujoco="urn:mujoco"><link name="hand"/>
<joint name="held" type="fixed"><parent>world</parent><child>hand</child></joint>{}</model></sdf>"""


@pytest.mark.parametrize(
    ("native", "message"),
    [
        (PAIR, "no collision 'hand/palm'"),
        ('<mujoco:contact><mujoco:pairs/></mujoco:contact>', "did you mean 'pair'"),
        ('<mujoco:actuator><mujoco:adhesion name="a" body="hnad"/></mujoco:actuator>', "did you mean 'hand'"),
        ('<mujoco:actuator><mujoco:adhesion body="hand"/></mujoco:actuator>', 'it needs name="..."'),
        ('<mujoco:actuator><mujoco:adhesion name="a" body="hand" gian="1"/></mujoco:actuator>', "gian"),
        ('<mujoco:site name="s" link="palm"/>', "no link 'palm'"),
        ('<mujoco:mesh name="m"/>', 'it needs name="...", and file="..." or vertex="..."'),
        ('<mujoco:freejoint link="hnad" armature="1"/>', "did you mean 'hand'"),
        ('<mujoco:tendon><mujoco:spatial name="t"><mujoco:rope/></mujoco:spatial></mujoco:tendon>', "<rope>"),
    ],
)  # fmt: skip
def test_mistakes_in_sections_for_mujoco_are_errors_with_their_line(tmp_path: Path, native, message):
    (tmp_path / "arm.sdf").write_text(ARM.format("\n" + native))
    with pytest.raises(SceneError, match=r"arm\.sdf:3: .*" + message.replace("(", r"\(")):
        opened(read_scene(tmp_path / "arm.sdf"))


@pytest.mark.parametrize(
    ("hand", "excluded", "told"),
    [
        ('contype="1"', "", ["contact"]),
        ('contype="2" conaffinity="2"', "", []),
        ('contype="1"', '<exclude body1="mast" body2="hand"/>', []),
    ],
)
def test_pybullet_reports_parts_that_would_collide(tmp_path, hand, excluded, told):
    """The arm touches neither of its neighbours, the mast and the hand, in MuJoCo either."""
    (tmp_path / "crane.xml").write_text(
        '<mujoco><worldbody><body name="mast"><geom size="0.1"/><joint/><body name="arm" pos="0.1 0 0">'
        f'<joint/><geom size="0.1"/><body name="hand"><joint axis="1 0 0"/><geom size="0.1" {hand}/></body>'
        f"</body></body></worldbody><contact>{excluded}</contact></mujoco>"
    )
    with opened(read_scene(tmp_path / "crane.xml"), "pybullet") as world:
        found = [warning for warning in world.warnings if warning.code is Code.NRP260]
        assert [warning.subject for warning in found] == told
        assert ["parts of 'mast' do not touch each other" in one.message for one in found] == [True] * len(
            told
        )


@pytest.mark.parametrize(
    ("option", "armature", "told"),
    [
        ('density="1000" viscosity="0.001"', "0", ["density", "viscosity"]),
        ('density="0"', "0.01", ["armature"]),
        ('wind="1 0 0"', "0", []),
    ],
)
def test_pybullet_reports_that_it_ignores_inertia_of_motors_and_the_medium(tmp_path, option, armature, told):
    (tmp_path / "fin.xml").write_text(
        f'<mujoco><option {option}/><worldbody><body name="fin"><geom size="0.1"/><joint name="root"/>'
        f'<body pos="0.2 0 0"><joint name="flap" armature="{armature}"/><geom size="0.1"/></body></body>'
        "</worldbody></mujoco>"
    )
    with opened(read_scene(tmp_path / "fin.xml"), "pybullet") as world:
        found = [warning for warning in world.warnings if warning.code is Code.NRP260]
        assert [warning.subject for warning in found if warning.subject != "contact"] == told
        assert all("'flap'" in each.message for each in found if each.subject == "armature")
    with opened(read_scene(tmp_path / "fin.xml")) as world:
        assert not [warning for warning in world.warnings if warning.code is Code.NRP260]


@pytest.mark.parametrize(("base", "touches"), [("", True), ("<freejoint/>", False)])
def test_an_arm_touches_its_base_only_if_the_base_is_fixed_as_in_mujoco(tmp_path, base, touches):
    (tmp_path / "arm.xml").write_text(
        f'<mujoco><worldbody><body name="base">{base}<geom type="box" size="0.1 0.1 0.1"/>'
        '<body name="arm" pos="0 0 0.15"><joint axis="0 1 0"/>'
        '<geom type="capsule" size="0.02 0.1" pos="0 0 0.1"/></body></body></worldbody></mujoco>'
    )
    own = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    data = mujoco.MjData(own)
    data.qpos[-1] = 2.5  # the arm points into the base
    mujoco.mj_forward(own, data)
    assert bool(data.ncon) is touches
    (model,) = read_scene(tmp_path / "arm.xml").models
    assert touches_itself(model) is touches


@pytest.mark.parametrize(("other", "told"), [("left/arm", []), ("rock", ["exclude"])])
def test_pybullet_lacks_only_excludes_between_models(tmp_path, other, told):
    """Parts of one model never touch each other there."""
    (tmp_path / "crane.xml").write_text(
        '<mujoco><worldbody><body name="mast"><geom size="0.1"/><joint/><body name="left/arm" pos="0.1 0 0">'
        '<joint/><geom size="0.1"/></body></body><body name="rock"><freejoint/><geom size="0.1"/></body>'
        f'</worldbody><contact><exclude body1="mast" body2="{other}"/></contact></mujoco>'
    )
    with opened(read_scene(tmp_path / "crane.xml"), "pybullet") as world:
        assert [warning.subject for warning in world.warnings if warning.code is Code.NRP260] == told


@pytest.mark.parametrize(("times", "more"), [(1, ""), (3, " (and 2 more)")])
def test_excludes_of_absent_links_are_reported_once_and_the_robot_opens(tmp_path, times, more):
    excludes = '<mujoco:exclude body1="hnad" body2="arm"/>' * times
    (tmp_path / "arm.sdf").write_text(
        ARM.format(
            '<link name="arm"/><joint name="j" type="fixed"><parent>hand</parent><child>arm</child></joint>'
            f"\n<mujoco:contact>{excludes}</mujoco:contact>"
        )
    )
    with opened(read_scene(tmp_path / "arm.sdf")) as world:
        said = [(warning.message, warning.line) for warning in world.warnings]
    what = "the scene has no link 'hnad'; did you mean 'hand'?: the <exclude> has no effect"
    assert said == [(what + more, 3)]


TEXTBOOK_ARM = """<mujoco><worldbody>{ground}
  <site name="anchor" pos="-0.1 0 1.3" euler="0 30 0"/><site name="post" pos="0.3 0.05 1.2"/>
  <body name="arm" pos="0 0 1" euler="0 0 20"><joint name="elbow" axis="0 1 0" damping="0.1"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.3" contype="0" conaffinity="0"/>
    <site name="insertion" pos="0.15 0 0.02"/></body></worldbody>
  <equality><connect body1="arm" body2="world" anchor="0 0 0"/></equality>
  <tendon><spatial name="cord">{path}</spatial></tendon>
  <actuator><muscle name="biceps" tendon="cord" lengthrange="0.1 0.6" force="30"/>
    <motor name="hand" site="post" refsite="insertion" gear="0 0 0.3 0 0.1 0"/></actuator></mujoco>"""
PULLEY = (
    '<geom name="pulley" type="cylinder" size="0.03 0.1" pos="0 0 1.1" euler="90 0 0" contype="0" '
    'conaffinity="0"/>',
    '<geom geom="pulley"/>',
)
SITES = ('<site site="anchor"/>', '<site site="insertion"/>')


@pytest.mark.parametrize("sites", [SITES, SITES[::-1]], ids=["from the world", "from the arm"])
@pytest.mark.parametrize(("ground", "along"), [("", ""), PULLEY], ids=["no ground", "pulley"])
def test_a_muscle_between_the_world_and_an_arm_acts_as_in_mujoco_alone(tmp_path, sites, ground, along):
    text = TEXTBOOK_ARM.format(path=along.join(sites), ground=ground)
    (tmp_path / "arm.xml").write_text(text)
    controls = {"biceps": 0.6, "hand": 1.0}
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        assert not world.warnings
        for name, value in controls.items():
            world.advertise(f"/arm/{name}/cmd").publish(Float64(value))
        found = ours(world, {"arm": "arm"}, 0.5)
    wanted = alone(text, controls, 0.5)
    assert abs(wanted["elbow"] - alone(text, {}, 0.5)["elbow"]) > 0.1
    assert found == pytest.approx({name: wanted[name] for name in found}, abs=1e-9)


def test_the_places_of_a_robot_on_the_world_are_relative_to_where_it_stands(tmp_path):
    (tmp_path / "arm.xml").write_text(TEXTBOOK_ARM.format(path="".join(SITES), ground=""))
    arm = read_model(tmp_path / "arm.xml")
    moved = replace(arm, pose=Pose((3.0, 2.0, 1.0)) @ arm.pose)
    found = []
    for model in (arm, moved):
        with opened(Scene((model,))) as world:
            world.advertise("/arm/biceps/cmd").publish(Float64(0.6))
            found.append(ours(world, {}, 0.5))
    assert abs(found[0]["elbow"]) > 0.1
    assert found[1] == pytest.approx(found[0], abs=1e-9)


PULLED = """<mujoco><default><default class="of"><tendon {tendon}/><general {actuator}/>
  <joint {joint}/></default></default><worldbody><body name="arm"><joint name="elbow" axis="0 1 0" class="of"
  damping="0.1"/>
  <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.3"/></body></worldbody>
  <tendon><fixed name="cord" class="of"><joint joint="elbow" coef="0.5"/></fixed></tendon><actuator>
  <general name="pull" {target} class="of" gainprm="9"/></actuator></mujoco>"""
PASSED = [
    *[("actuator", f'{name}="{value}"') for name, value in (
        ("damping", "0.5 0.2"), ("armature", "0.3"), ("delay", '0.05" nsample="40'))],
    *[("tendon", f'{name}="{value}"') for name, value in (
        ("actuatorfrcrange", "-1 2"), ("damping", "0.3 0.2"), ("stiffness", "2 1"), ("armature", "0.2"))],
    ("joint", 'actuatorfrcrange="-1 1.5"'),
]  # fmt: skip


@pytest.mark.parametrize("target", ['joint="elbow"', 'tendon="cord"'])
@pytest.mark.parametrize(("where", "attribute"), PASSED)
def test_attributes_of_a_file_act_as_in_mujoco_alone(tmp_path, where, attribute, target):
    usual = dict.fromkeys(("joint", "actuator", "tendon"), "")
    text = PULLED.format(**usual | {where: attribute}, target=target)
    (tmp_path / "arm.xml").write_text(text)
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        assert not world.warnings
        commands = {"/arm/pull/cmd": 1.0, "/arm/elbow/cmd_effort": 9.0}  # the latter in N m
        for topic in commands.keys() & set(world.topics):
            world.advertise(topic).publish(Float64(commands[topic]))
        found = ours(world, {}, 0.5)
    wanted, without = (
        alone(each, {"pull": 1.0}, 0.5) for each in (text, PULLED.format(**usual, target=target))
    )
    if where != "tendon" or target.startswith("tendon") or "frcrange" not in attribute:
        assert abs(wanted["elbow"] - without["elbow"]) > 1e-4
    assert found["elbow"] == pytest.approx(wanted["elbow"], abs=1e-9)


@pytest.mark.parametrize("other", ['tendon="cord" gear="2"', 'joint="elbow"'])
def test_the_limit_of_a_joint_bounds_its_actuators_together(tmp_path, other):
    joint = 'joint="elbow"'
    text = PULLED.format(joint='actuatorfrcrange="-2 2"', actuator="", tendon="", target=joint)
    text = text.replace("</actuator>", f'<general name="back" {other}/></actuator>')
    (tmp_path / "arm.xml").write_text(text)
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        world.advertise("/arm/elbow/cmd_effort").publish(Float64(9.0))
        world.advertise("/arm/back/cmd").publish(Float64(-8.5))
        found = ours(world, {}, 0.5)
    wanted = alone(text, {"pull": 1.0, "back": -8.5}, 0.5)
    assert found["elbow"] == pytest.approx(wanted["elbow"], abs=1e-9)


@pytest.mark.parametrize("effort", [-3.0, 3.0])
def test_a_joint_has_a_limit_of_effort_in_each_direction(tmp_path, effort):
    joint = 'joint="elbow"'
    text = PULLED.format(joint='actuatorfrcrange="-5 1"', actuator="", tendon="", target=joint)
    (tmp_path / "arm.xml").write_text(text)
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        world.advertise("/arm/elbow/cmd_effort").publish(Float64(effort))
        found = ours(world, {}, 0.5)
    wanted = alone(text, {"pull": effort / 9.0}, 0.5)  # its gain is 9
    assert found["elbow"] == pytest.approx(wanted["elbow"], abs=1e-9)
    with opened(read_scene(tmp_path / "arm.xml"), "pybullet") as world:
        assert "actuatorfrcrange" in [each.subject for each in world.warnings]


@pytest.mark.parametrize(("flag", "told"), [('actuation="disable"', 1), ('constraint="disable"', 1), ("", 0)])
def test_flags_that_are_not_used_are_reported(tmp_path, flag, told):
    text = PULLED.format(joint="", actuator="", tendon="", target='joint="elbow"')
    text = text.replace("<mujoco>", f"<mujoco><option><flag {flag}/></option>")
    (tmp_path / "arm.xml").write_text(text)
    found = [each.message for each in read_model(tmp_path / "arm.xml").warnings]
    assert len(found) == told
    assert all(flag.partition("=")[0] in each for each in found)


def test_a_body_without_mass_weighs_nothing(tmp_path):
    (tmp_path / "leg.xml").write_text(
        '<mujoco><worldbody><body name="leg"><freejoint/><geom size="0.1" mass="1"/>'
        '<body name="foot" pos="0 0 -0.3"><geom size="0.05" mass="0"/></body></body></worldbody></mujoco>'
    )
    with opened(read_scene(tmp_path / "leg.xml")) as world:
        assert world.engine._model.body_mass.sum() == pytest.approx(1.0, abs=1e-9)


def test_flat_bodies_have_their_inertia_in_any_rotation(tmp_path):
    random = np.random.default_rng(5)
    bodies = ""
    for number in range(40):
        turn, (a, b) = random.normal(size=4), random.uniform(0.001, 1, 2)
        bodies += (
            f'<body name="b{number}" pos="{number} 0 0"><freejoint/><inertial pos="0 0 0" mass="1" '
            f'quat="{" ".join(map(str, turn))}" diaginertia="{a} {b} {a + b}"/>'
            '<body><geom size="0.1" mass="0"/></body></body>'
        )
    (tmp_path / "flat.xml").write_text(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "flat.xml"))
    with opened(read_scene(tmp_path / "flat.xml")) as world:
        model = world.engine._model
        heavy = model.body_mass > 0.5
        found, wanted = (np.sort(each, axis=1) for each in (
            model.body_inertia[heavy], theirs.body_inertia[theirs.body_mass > 0.5]))  # fmt: skip
    assert found == pytest.approx(wanted, rel=1e-9)


ALONE = """<mujoco><compiler angle="radian" {compiler}/><worldbody>
  <body name="arm" {arm}><joint name="elbow" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.3" contype="0" conaffinity="0"/>
    <body name="wrist" pos="0.3 0 0"><body name="hand"><joint name="ball" type="ball" {ball}/>
      <geom size="0.05" pos="0.1 0 0" mass="0.2" contype="0" conaffinity="0"/></body></body></body>
  </worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("where", "attribute"),
    [
        ("arm", 'gravcomp="0.4"'),
        ("ball", 'stiffness="0.5"'),
        ("compiler", 'boundinertia="0.01"'),  # of the wrist, which has no mass
    ],
)
def test_bodies_of_a_file_move_as_in_mujoco_alone(tmp_path, where, attribute):
    usual = dict.fromkeys(("compiler", "arm", "ball"), "")
    text = ALONE.format(**usual | {where: attribute})
    (tmp_path / "arm.xml").write_text(text)
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        assert not world.warnings
        found = ours(world, {}, 0.3)["elbow"]
    wanted, without = (alone(each, {}, 0.3)["elbow"] for each in (text, ALONE.format(**usual)))
    assert abs(wanted - without) > 1e-3
    assert found == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize(
    ("where", "attribute", "told"),
    [
        ("arm", 'gravcomp="0.4"', "gravcomp"),
        ("ball", 'stiffness="0.5"', "stiffness"),
        ("ball", 'limited="true" range="0 30"', "range"),
    ],
)
def test_pybullet_reports_unsupported_attributes_of_bodies(tmp_path, where, attribute, told):
    usual = dict.fromkeys(("compiler", "arm", "ball"), "")
    (tmp_path / "arm.xml").write_text(ALONE.format(**usual | {where: attribute}))
    with opened(read_scene(tmp_path / "arm.xml"), "pybullet") as world:
        assert told in [warning.subject for warning in world.warnings if warning.code is Code.NRP260]


def test_a_muscle_that_moves_nothing_opens(tmp_path):
    text = TEXTBOOK_ARM.format(path='<site site="anchor"/><site site="post"/>', ground="")
    (tmp_path / "arm.xml").write_text(text.replace('force="30"', 'force="-1"'))
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        assert ours(world, {}, 0.1)


SPRINGS = """<mujoco><worldbody>
  <body name="arm" pos="0 0 1"><joint name="a" axis="0 1 0" damping=".1 .2" stiffness="1 2 3"/>
    <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".2"/>
    <body name="hand" pos=".3 0 0"><joint name="b" type="ball" damping=".01 .02" stiffness=".1 .2"/>
      <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".2"/></body></body>
  <body name="ball" pos="0 1 1"><freejoint name="free"/><geom size=".1" mass="1"/></body></worldbody>
  <actuator><motor name="turn" joint="b" gear="0.1 0.3 0.2"/>
    <motor name="lift" joint="free" gear="0 0 20 0 1 0"/>
    <position name="reach" joint="a" kp="1"/></actuator></mujoco>"""


def test_springs_of_any_law_motors_on_any_joint_and_targets_beyond_limits_act_as_in_mujoco_alone(tmp_path):
    text = SPRINGS.replace('name="a"', 'name="a" range="-0.1 0.1"')
    (tmp_path / "arm.xml").write_text(text)
    theirs = mujoco.MjModel.from_xml_string(text)
    there = mujoco.MjData(theirs)
    there.ctrl = 0.9, 0.6, 1.5
    mujoco.mj_step(theirs, there, 150)
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        topics = "/arm/turn/cmd", "/ball/lift/cmd", "/arm/a/cmd_pos"
        for topic, value in zip(topics, (0.9, 0.6, 1.5), strict=True):
            world.advertise(topic).publish(Float64(value))
        world.run_until(300_000_000)
        assert not {Code.NRP260, Code.NRP299} & {each.code for each in world.warnings}
        np.testing.assert_allclose(world.engine._data.qpos, there.qpos, rtol=0, atol=1e-12)


def test_the_angle_of_a_ball_joint_is_bounded_as_in_mujoco_alone(tmp_path):
    (tmp_path / "arm.xml").write_text(
        SPRINGS.replace('type="ball"', 'type="ball" limited="true" range="0 15"')
    )
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    there = mujoco.MjData(theirs)
    there.ctrl = 0.9, 0.6, 0.0
    mujoco.mj_step(theirs, there, 150)
    with opened(read_scene(tmp_path / "arm.xml")) as world:
        for topic, value in (("/arm/turn/cmd", 0.9), ("/ball/lift/cmd", 0.6)):
            world.advertise(topic).publish(Float64(value))
        world.run_until(300_000_000)
        np.testing.assert_allclose(world.engine._data.qpos, there.qpos, rtol=0, atol=1e-12)
    unbounded = alone(SPRINGS, {"turn": 0.9, "lift": 0.6}, 0.3)["b"]
    assert abs(there.joint("b").qpos[0] - 1.0 - unbounded) > 1e-3


TORUS = """<mujoco><extension><plugin plugin="mujoco.sdf.torus"><instance name="t">
  <config key="radius1" value="0.35"/><config key="radius2" value="0.15"/></instance></plugin></extension>
  <asset><mesh name="t"><plugin instance="t"/></mesh></asset>
  <worldbody><body><freejoint/><geom type="sdf" mesh="t"><plugin instance="t"/></geom></body></worldbody>
</mujoco>"""


def test_plugins_of_mujoco_are_refused_and_bodies_that_begin_asleep_are_reported(tmp_path):
    (tmp_path / "torus.xml").write_text(TORUS)
    with pytest.raises(SceneError, match=r"torus.xml:1: .*'mujoco.sdf.torus'"):
        read_scene(tmp_path / "torus.xml")
    asleep = '<mujoco><option><flag sleep="enable"/></option><worldbody><body name="b" sleep="init">'
    (tmp_path / "b.xml").write_text(f'{asleep}<freejoint/><geom size="1"/></body></worldbody></mujoco>')
    assert [each.code for each in read_scene(tmp_path / "b.xml").warnings] == [Code.NRP260]
