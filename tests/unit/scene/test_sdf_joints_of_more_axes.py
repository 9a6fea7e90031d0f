"""What moves in more than one way is read as simple joints in a row; gearboxes let joints follow others."""

from __future__ import annotations

import re
from collections.abc import Callable
from math import inf, pi
from pathlib import Path

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.scene.model import Joint, Mimic, Model, Scene
from nrp_core.scene.outline import outline
from nrp_core.scene.sdf import read_scene

ModelReader = Callable[..., Model]

LINKS = """<link name="base"><inertial/></link>
<link name="arm"><pose>0 0 1 0 0 1.5707963267948966</pose><inertial/></link>
"""
CROSS = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"


def joint(kind: str, more: str = "", *, name: str = "j", ends: tuple[str, str] = ("base", "arm")) -> str:
    parent, child = ends
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{more}</joint>'


def told(joints: tuple[Joint, ...]) -> list[tuple[str, str, str, str]]:
    return [(each.name, each.kind, each.parent, each.child) for each in joints]


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
def test_two_axes_are_two_joints_with_a_light_link_between(model: ModelReader, kind: str) -> None:
    read = model(LINKS + joint(kind, CROSS))
    assert told(read.joints) == [
        ("j", "continuous", "base", "j_carrier"),
        ("j_axis2", "continuous", "j_carrier", "arm"),
    ]
    assert [each.axis for each in read.joints] == [(1, 0, 0), (0, 1, 0)]
    assert read.joints[0].pose == read.joints[1].pose == read.link("j_carrier").pose == read.link("arm").pose
    carrier = read.link("j_carrier").inertial
    assert carrier is not None
    assert carrier.mass < 1e-6
    assert not read.warnings


def test_each_axis_has_its_own_frame_limits_and_dynamics(model: ModelReader) -> None:
    limits = "<limit><lower>-1</lower><upper>2</upper><effort>3</effort></limit>"
    slow = "<dynamics><damping>0.5</damping><friction>0.1</friction></dynamics>"
    first = f'<axis><xyz expressed_in="__model__">1 0 0</xyz>{limits}</axis>'
    second = f'<axis2><xyz expressed_in="base">0 1 0</xyz>{slow}</axis2>'
    one, other = model(LINKS + joint("universal", first + second)).joints
    assert (one.kind, one.lower, one.upper, one.effort, one.damping) == ("revolute", -1, 2, 3, 0)
    assert (other.kind, other.lower, other.effort) == ("continuous", -inf, inf)
    assert (other.damping, other.friction) == (0.5, 0.1)
    # the arm is turned to the left
    assert one.axis == pytest.approx((0, -1, 0), abs=1e-12)
    assert other.axis == pytest.approx((1, 0, 0), abs=1e-12)


def test_an_axis_held_between_0_and_0_does_not_turn(model: ModelReader) -> None:
    held = CROSS.replace("</xyz></axis>", "</xyz><limit><lower>0</lower><upper>0</upper></limit></axis>")
    assert [each.kind for each in model(LINKS + joint("revolute2", held)).joints] == ["fixed", "continuous"]


def test_of_two_equal_axes_the_first_one_turns_with_a_warning(model: ModelReader) -> None:
    read = model(LINKS + joint("revolute2", "<axis><xyz>0 0 1</xyz></axis>"))
    assert told(read.joints) == [("j", "continuous", "base", "arm")]
    assert "robot.sdf:6: both axes of the joint 'j' are the same: it turns about the first" in str(
        read.warnings[0]
    )


def test_a_ball_has_three_coordinates_and_takes_no_commands(model: ModelReader, golden: Golden) -> None:
    plugin = (
        '<plugin name="c" filename="libgeneric_controller_plugin.so"><controller joint_name="j">'
        "<type>position</type></controller></plugin>"
    )
    damped = "<axis><xyz>0 0 1</xyz><dynamics><damping>0.3</damping></dynamics></axis>"
    read = model(LINKS + joint("ball", damped) + plugin)
    assert told(read.joints) == [("j", "ball", "base", "arm")]
    assert read.joints[0].coordinates == ("j_x", "j_y", "j_z")
    assert read.joints[0].damping == 0.3
    assert read.controllers == ()
    assert "'j'" in str(read.warnings[0])
    golden(str(read.warnings[0]))
    assert read.joint_states_topic == "/robot/joint_states"


def test_a_spring_of_a_ball_is_warned_of(model: ModelReader, golden: Golden) -> None:
    spring = "<axis><xyz>0 0 1</xyz><dynamics><spring_stiffness>3</spring_stiffness></dynamics></axis>"
    (warning,) = model(LINKS + joint("ball", spring)).warnings
    assert "<spring_stiffness>" in str(warning)
    golden(str(warning))


def test_the_ball_of_a_caster_rolls_with_its_own_friction(model: ModelReader) -> None:
    collision = '<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>'
    links = f'<link name="base"><inertial/></link><link name="arm">{collision}</link>'
    assert model(links + joint("ball")).link("arm").collisions[0].friction == 1.0


@pytest.mark.parametrize(
    ("pitch", "lead"),
    [
        ("", 1.0),
        ("<screw_thread_pitch>0.5</screw_thread_pitch>", 0.5),
        ("<screw_thread_pitch>-0.5</screw_thread_pitch><thread_pitch>3</thread_pitch>", -0.5),
        ("<thread_pitch>3</thread_pitch>", -2 * pi / 3),  # rad/m, to the left
        ("<thread_pitch>-1000</thread_pitch>", 2 * pi / 1000),
    ],
)
def test_a_screw_turns_and_travels_its_pitch_a_turn(model: ModelReader, pitch: str, lead: float) -> None:
    limits = "<axis><xyz>0 1 0</xyz><limit><lower>-3</lower><upper>4</upper></limit></axis>"
    turn, travel = (read := model(LINKS + joint("screw", pitch + limits))).joints
    assert told(read.joints) == [
        ("j", "revolute", "base", "j_carrier"),
        ("j_travel", "prismatic", "j_carrier", "arm"),
    ]
    assert (turn.lower, turn.upper, turn.axis) == (-3, 4, travel.axis)
    assert (travel.lower, travel.upper) == (-inf, inf)
    assert travel.mimic == Mimic("j", pytest.approx(lead / 2 / pi))


def test_a_screw_that_never_turns_is_refused(model: ModelReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="thread_pitch>"):
        model(LINKS + joint("screw", "<thread_pitch>0</thread_pitch>"))


def test_a_planar_joint_slides_across_its_axis_and_turns_about_it(model: ModelReader) -> None:
    x, y, turn = model(LINKS + joint("planar", "<axis><xyz>1 1 0</xyz></axis>")).joints
    assert [each.name for each in (x, y, turn)] == ["j_x", "j_y", "j"]
    assert [each.kind for each in (x, y, turn)] == ["prismatic", "prismatic", "continuous"]
    assert np.cross(x.axis, y.axis) == pytest.approx(turn.axis)
    assert np.dot(x.axis, y.axis) == pytest.approx(0.0)


def test_a_joint_of_two_axes_that_closes_a_loop_is_left_out_as_a_whole(
    model: ModelReader, golden: Golden
) -> None:
    read = model(f"{LINKS}{joint('fixed', name='held')}{joint('universal', CROSS)}")
    assert [each.name for each in read.joints] == ["held"]
    assert [each.name for each in read.links] == ["base", "arm"]
    assert "'j'" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_a_joint_follows_the_second_axis_of_another_one(model: ModelReader, golden: Golden) -> None:
    text = LINKS + '<link name="tip"><inertial/></link>' + joint("universal", CROSS)
    mimic = '<axis><mimic joint="j" axis="axis2"><multiplier>2</multiplier></mimic></axis>'
    read = model(text + joint("revolute", mimic, name="k", ends=("arm", "tip")))
    assert read.joints[-1].mimic == Mimic("j_axis2", 2.0, 0.0)
    broken = CROSS.replace("</axis2>", '<mimic joint="jj"/></axis2>')
    with golden.raises(SceneError, match="'j_axis2'.*'jj'") as refusal:
        model(LINKS + joint("universal", broken))
    assert refusal.value.line == 6


def test_a_follower_of_a_ball_moves_freely_with_a_warning(model: ModelReader, golden: Golden) -> None:
    text = LINKS + '<link name="tip"><inertial/></link>' + joint("ball")
    follower = joint("revolute", '<axis><mimic joint="j"/></axis>', name="k", ends=("arm", "tip"))
    read = model(text + follower)
    assert read.joints[-1].mimic is None
    assert "'k'" in str(read.warnings[0])
    golden(str(read.warnings[0]))


@pytest.mark.parametrize(
    ("index", "led", "topic"), [("", "j", "j/0/cmd_pos"), ("1", "j_axis2", "j/1/cmd_pos")]
)
def test_a_controller_of_gazebo_names_an_axis_by_its_index(
    model: ModelReader, index: str, led: str, topic: str
) -> None:
    chosen = f"<joint_index>{index}</joint_index>" if index else ""
    name = "gz::sim::systems::JointPositionController"
    plugin = f'<plugin name="{name}" filename="x"><joint_name>j</joint_name>{chosen}</plugin>'
    (controller,) = model(LINKS + joint("universal", CROSS) + plugin).controllers
    assert (controller.joint, controller.topic) == (led, f"/model/robot/joint/{topic}")


def test_parts_of_a_nested_model_are_named_with_it(model: ModelReader) -> None:
    nested = f'<model name="leg">{LINKS}{joint("screw")}</model>'
    read = model(f'<link name="body"><inertial/></link>{nested}')
    assert told(read.joints) == [
        ("leg::j", "continuous", "leg::base", "leg::j_carrier"),
        ("leg::j_travel", "prismatic", "leg::j_carrier", "leg::arm"),
    ]
    assert read.joints[1].mimic is not None
    assert read.joints[1].mimic.leader == "leg::j"
    assert read.link("leg::j_carrier").pose == read.link("leg::arm").pose


def test_two_coordinates_of_one_name_are_refused(model: ModelReader, golden: Golden) -> None:
    text = LINKS + '<link name="tip"><inertial/></link>' + joint("ball")
    with golden.raises(SceneError, match="'j_y'"):
        model(text + joint("revolute", name="j_y", ends=("arm", "tip")))


def test_an_outline_describes_the_joints(model: ModelReader) -> None:
    text = LINKS + '<link name="tip"><inertial/></link>' + joint("screw")
    read = model(text + joint("ball", name="b", ends=("arm", "tip")))
    lines = "\n".join(outline(Scene((read,)), "room").lines())
    assert "joint j, continuous about 0 0 1\n" in lines
    assert "joint j_travel, prismatic along 0 0 1, mimics 0.1592 x j\n" in lines
    assert "joint b, ball\n" in lines


# -- gearboxes

BODY = "<gearbox_reference_body>base</gearbox_reference_body>"
LIMIT = "<limit><lower>-1</lower></limit><dynamics><damping>1</damping></dynamics>"
AXES = f"<axis><xyz>0 0 1</xyz>{LIMIT}</axis><axis2><xyz>0 0 1</xyz>{LIMIT}</axis2>"


def geared(more: str, *, first: str = "0 0 1", second: str = "0 0 1", **ends: tuple[str, str]) -> str:
    links = "".join(f'<link name="{name}"><inertial/></link>' for name in ("base", "one", "two"))
    turning = [
        joint("revolute", f"<axis><xyz>{axis}</xyz></axis>", name=name, ends=ends.get(name, usual))
        for name, axis, usual in (("a", first, ("base", "one")), ("b", second, ("base", "two")))
    ]
    return links + "".join(turning) + joint("gearbox", more, name="g", ends=("one", "two"))


@pytest.mark.parametrize(
    ("first", "second", "ends", "expected"),
    [
        ("0 0 1", "0 0 1", {}, -2.5),
        ("0 0 -1", "0 0 1", {}, 2.5),
        ("0 0 -1", "0 0 -1", {}, -2.5),
        ("0 0 1", "0 0 1", {"a": ("one", "base")}, 2.5),  # the angle of the base against the gear
    ],
)
def test_a_gearbox_lets_its_child_turn_back_by_the_ratio(
    model: ModelReader, first: str, second: str, ends: dict[str, tuple[str, str]], expected: float
) -> None:
    text = geared(f"{BODY}<gearbox_ratio>2.5</gearbox_ratio>{AXES}", first=first, second=second, **ends)
    read = model(text)
    assert [each.mimic for each in read.joints] == [None, Mimic("a", expected)]
    assert len(read.links) == 3
    assert not read.warnings


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (geared(AXES), "it has no <gearbox_reference_body>"),
        (geared(BODY + AXES, second="1 0 0"), "do not each turn by one joint of their own"),
        (geared(BODY + AXES, b=("one", "two")), "do not each turn by one joint of their own"),
        (
            geared(BODY + AXES).replace('name="b" type="revolute"', 'name="b" type="fixed"'),
            "do not each turn",
        ),
        (geared(BODY + AXES).replace('name="b" type="revolute"', 'name="b" type="prismatic"'), "do not each"),
    ],
)
def test_a_gearbox_without_two_gears_is_left_out_with_a_warning(
    model: ModelReader, text: str, why: str, golden: Golden
) -> None:
    read = model(text)
    assert all(each.mimic is None for each in read.joints)
    (warning,) = map(str, read.warnings)
    assert "robot.sdf:4" in warning
    golden(warning)
    assert why in warning


def test_a_gearbox_suggests_existing_names(model: ModelReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="'bsae'.*'base'"):
        model(geared(BODY.replace("base", "bsae") + AXES))


def test_a_gearbox_between_two_models_is_one_finding(tmp_path: Path) -> None:
    models = "".join(f'<model name="{name}">{geared("")}</model>' for name in "ab")
    models = re.sub(r'<joint name="g".*?</joint>', "", models, flags=re.DOTALL)
    body = BODY.replace("base", "a::base")
    gearbox = joint("gearbox", body + AXES, name="g", ends=("a::one", "b::two"))
    file = tmp_path / "room.sdf"
    file.write_text(f'<sdf version="1.9"><world name="w">{models}{gearbox}</world></sdf>')
    scene = read_scene(file)
    assert [(each.code, each.subject) for each in scene.warnings] == [(Code.NRP260, "g")]
    assert scene.ties == ()
