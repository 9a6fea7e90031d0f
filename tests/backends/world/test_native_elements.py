"""Elements of a file that are meant for one engine reach it, and wrong ones are refused with their line."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import mujoco
import pytest
from golden import Golden

from nrp_core import Scene, World, read_model, worlds
from nrp_core.errors import SceneError, SimulationError
from nrp_core.findings import Code
from nrp_core.messages.base import Duration
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose, Twist, Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.world.robot_setup import JointControl, RobotSetup, set_up_robot

Open = Callable[..., World]

ROTOR = """<model name="rotor" xmlns:mujoco="urn:mujoco">{native}
<link name="disc"><inertial><mass>1</mass>
<inertia><ixx>0.5</ixx><iyy>0.5</iyy><izz>0.5</izz></inertia></inertial>
<collision name="rim"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>
<joint name="axle" type="revolute"><parent>world</parent><child>disc</child>
<axis><xyz>0 0 1</xyz></axis></joint>
</model>"""

BALL = """<model name="ball" xmlns:mujoco="urn:mujoco"><pose>0 0 0.1 0 0 0</pose>{native}
<link name="ball"><inertial><mass>1</mass>
<inertia><ixx>0.004</ixx><iyy>0.004</iyy><izz>0.004</izz></inertia></inertial>
<collision name="skin"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
</link></model>"""

GROUND = """<model name="ground"><static>true</static><link name="floor"><collision name="floor"><geometry>
<plane><normal>0 0 1</normal></plane></geometry></collision></link></model>"""

CAR = """<robot name="car">{native}
<link name="base"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="1 1 1"/></geometry></collision>
<contact>{contact}</contact></link></robot>"""


@pytest.fixture
def open_in(tmp_path: Path) -> Iterator[Open]:
    opened: list[World] = []

    def open_files(backend: str, *texts: str) -> World:
        models = []
        for number, text in enumerate(texts):
            kind = "urdf" if text.startswith("<robot") else "sdf"
            path = tmp_path / f"model{number}.{kind}"
            path.write_text(text if kind == "urdf" else f'<sdf version="1.9">\n{text}\n</sdf>\n')
            models.append(read_model(path, name=f"model{number}"))
        found = worlds().load(backend)
        opened.append(found.open(Scene(tuple(models)), seed=1, options=found.options()))
        return opened[-1]

    yield open_files
    for world in opened:
        world.close()


@pytest.mark.parametrize(
    ("native", "armature"), [("", 0.0), ('<mujoco:joint name="axle" armature="1.5"/>', 1.5)]
)
def test_the_inertia_of_a_rotor_behind_a_gear_counts_in_mujoco(
    open_in: Open, native: str, armature: float
) -> None:
    world = open_in("mujoco", ROTOR.format(native=native))
    world.call("/gazebo/apply_joint_effort", "model0::axle", effort=2.0, duration=Duration(10))
    world.run_until(1_000_000_000)
    assert world.joint_states("model0").velocities[0] == pytest.approx(2.0 / (0.5 + armature), rel=0.01)


@pytest.mark.parametrize("limit", ["", "<limit><effort>20</effort></limit>"])
def test_a_joint_without_gains_stops_a_heavy_rotor_at_its_target(tmp_path: Path, limit: str) -> None:
    """Its path brakes for the rotor as well: the disc alone could stop twenty times as fast."""
    text = ROTOR.format(native='<mujoco:joint name="axle" armature="10"/>')
    text = text.replace("</xyz></axis>", f"</xyz>{limit}</axis>")
    path = tmp_path / "rotor.sdf"
    path.write_text(f'<sdf version="1.9">{text}</sdf>')
    model = set_up_robot(read_model(path), RobotSetup(control=((".*", JointControl("position")),)))
    backend, largest = worlds().load("mujoco"), 0.0
    with backend.open(Scene((model,)), seed=1, options=backend.options()) as world:
        world.advertise(model.controllers[0].topic).publish(Float64(0.2))
        for step in range(1, 126):
            world.run_until(step * 20_000_000)
            largest = max(largest, float(world.joint_states("rotor").positions[0]))
        assert world.joint_states("rotor").positions[0] == pytest.approx(0.2, abs=1e-4)
    assert largest < 0.201


def test_a_warning_of_mujoco_is_a_finding_and_writes_no_file(
    open_in: Open, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (here := tmp_path / "here").mkdir()
    monkeypatch.chdir(here)
    world = open_in("mujoco", ROTOR.format(native='<mujoco:joint name="axle" armature="-0.5"/>'))
    with suppress(SimulationError):
        world.run_until(20_000_000)
    told = [each for each in world.warnings if each.code is Code.NRP277]
    assert told
    assert all("MuJoCo: Inertia matrix is too close to singular" in str(each) for each in told)
    assert not list(here.iterdir())
    assert capfd.readouterr() == ("", "")


ROLLS = '<mujoco:geom link="ball" condim="6" friction="1 0.005 0.02"/>'


@pytest.mark.parametrize(("native", "rolls"), [("", True), (ROLLS, False)])
def test_a_ball_with_rolling_friction_for_mujoco_comes_to_rest(
    open_in: Open, native: str, rolls: bool
) -> None:
    world = open_in("mujoco", GROUND, BALL.format(native=native))
    rolling = Twist(Vector3(1.0), Vector3(0.0, 10.0))
    world.call("/gazebo/set_model_state", ModelState("model1", Pose(Point(0.0, 0.0, 0.1)), rolling))
    world.run_until(3_000_000_000)
    speed = world.model_motion("model1").linear[0]
    assert speed == pytest.approx(1.0, abs=0.05) if rolls else abs(speed) < 0.05


OPTION = '<option cone="pyramidal" impratio="7" density="1.2" noslip_iterations="3"/>'


def test_the_options_of_a_urdf_are_those_that_mujoco_itself_reads(open_in: Open, tmp_path: Path) -> None:
    text = CAR.format(native=f'<mujoco><compiler discardvisual="true"/>{OPTION}</mujoco>', contact="")
    ours = open_in("mujoco", text)
    own = mujoco.MjModel.from_xml_path(str(tmp_path / "model0.urdf"))
    for name in ("cone", "impratio", "density", "noslip_iterations"):
        assert getattr(_model_of(ours).opt, name) == getattr(own.opt, name)
    assert not any("mujoco" in warning.message for warning in ours.warnings)


def test_time_step_and_gravity_of_a_file_are_not_used_and_say_so(open_in: Open, golden: Golden) -> None:
    native = '<mujoco:option timestep="0.1" gravity="0 0 -1" impratio="7"/>'
    world = open_in("mujoco", ROTOR.format(native=native))
    opt = _model_of(world).opt
    assert (opt.timestep, opt.gravity[2], opt.impratio) == (0.002, -9.8, 7)
    golden(*[warning.message for warning in world.warnings if "option" in warning.message])  # fmt: skip


@pytest.mark.parametrize(
    ("native", "message"),
    [
        ('<mujoco:optoin cone="pyramidal"/>', "<mujoco:optoin>.*'option'"),
        ('<mujoco:option kone="pyramidal"/>', "<mujoco:option>: MuJoCo refuses it: .*'kone'"),
        ('<mujoco:option cone="round"/>', "<mujoco:option>: MuJoCo.*'round'"),
        ('<mujoco:joint name="axel" armature="1"/>', "'axel'.*'axle'"),
        ('<mujoco:joint armature="1"/>', 'it needs name="..."'),
        ('<mujoco:joint name="axle" armatur="1"/>', "'armatur'.*'armature'"),
        ('<mujoco:joint name="axle" frictionloss="1"/>', "'frictionloss'"),
        ('<mujoco:joint name="axle" armature="big"/>', "'armature'"),
        ('<mujoco:geom link="disk" condim="4"/>', "'disk'.*'disc'"),
        ('<mujoco:geom link="disc" condim="5"/>', "condim"),
        ('<mujoco:geom link="disc" mesh="dics"/>', "has no <mujoco:mesh> 'dics'"),
    ],
)
def test_a_wrong_element_for_mujoco_is_an_error_with_file_and_line(
    open_in: Open, native: str, message: str, golden: Golden
) -> None:
    with golden.raises(SceneError, match=message) as caught:
        open_in("mujoco", ROTOR.format(native=f"\n{native}"))
    assert (caught.value.path and caught.value.path.name, caught.value.line) == ("model0.sdf", 3)


def test_different_options_of_two_files_are_one_finding_with_the_values(open_in: Open) -> None:
    native = '\n<mujoco:option impratio="{}" density="{}"/>'
    world = open_in("mujoco", *(ROTOR.format(native=native.format(n, 4 + n)) for n in (1, 2)))
    assert (world.engine._model.opt.impratio, world.engine._model.opt.density) == (1, 5)
    (finding,) = (each for each in world.warnings if each.code is Code.NRP264)
    assert "impratio is 1 and 2; density is 5 and 6; used: impratio 1, density 5" in finding.message
    assert finding.line == 3


CONTACT = """<lateral_friction value="0.7"/><rolling_friction value="0.01"/><spinning_friction value="0.02"/>
<restitution value="0.4"/><stiffness value="30000"/><damping value="1000"/><friction_anchor/>"""


def test_the_contacts_of_a_urdf_are_those_that_pybullet_itself_reads(open_in: Open, tmp_path: Path) -> None:
    bullet = pytest.importorskip("pybullet")
    world = open_in("pybullet", CAR.format(native="", contact=CONTACT))
    ours = _dynamics(bullet, 0, world.engine)
    client = bullet.connect(bullet.DIRECT)
    body = bullet.loadURDF(str(tmp_path / "model0.urdf"), physicsClientId=client)
    own = bullet.getDynamicsInfo(body, -1, physicsClientId=client)
    bullet.disconnect(client)
    assert [ours[i] for i in (1, 5, 6, 7, 8, 9)] == pytest.approx([own[i] for i in (1, 5, 6, 7, 8, 9)])
    assert ours[1] == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        (
            '<lateral_fricton value="1"/>',
            "<lateral_fricton>.*'lateral_friction'",
        ),
        ('<restitution value="much"/>', "<restitution>.*'much'"),
        ('<stiffness value="1000"/>', "<pybullet:contact>"),
    ],
)
def test_a_wrong_contact_for_pybullet_is_an_error_with_file_and_line(
    open_in: Open, contact: str, message: str, golden: Golden
) -> None:
    pytest.importorskip("pybullet")
    with golden.raises(SceneError, match=message) as caught:
        open_in("pybullet", CAR.format(native="", contact=contact))
    assert (caught.value.path and caught.value.path.name, caught.value.line) == ("model0.urdf", 5)


def test_an_engine_leaves_the_elements_of_another_alone(open_in: Open) -> None:
    car = open_in("mujoco", CAR.format(native="", contact='<no_such_thing value="1"/>'))
    assert not [each for each in car.warnings if "no_such_thing" in str(each)]
    pytest.importorskip("pybullet")
    rotor = open_in("pybullet", ROTOR.format(native='<mujoco:no_such_thing value="1"/>'))
    assert not [each for each in rotor.warnings if "mujoco:no_such_thing" in str(each)]


def _model_of(world: World) -> Any:
    return world.engine._model  # type: ignore[attr-defined]  # the compiled model is what MuJoCo runs


def _dynamics(bullet: Any, body: int, engine: Any) -> Any:
    return bullet.getDynamicsInfo(body, -1, physicsClientId=engine._client)
