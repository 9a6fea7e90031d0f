"""Files as other people write them: what libsdformat accepts is read, and what it refuses is refused."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.scene.loops import Freedom
from nrp_core.scene.model import Box, Cylinder, Model, Scene, Sphere
from nrp_core.scene.rigid import Pose

ModelReader = Callable[..., Model]
WorldReader = Callable[..., Scene]

LINK = '<link name="base"><inertial/></link>'
TWIN = (
    '<link name="base"><inertial/></link><link name="arm"><pose>1 0 0 0 0 0</pose><inertial/></link>'
    '<joint name="arm" type="revolute"><pose>0 0 2 0 0 {turn}</pose><parent>base</parent><child>arm</child>'
    "<axis><xyz>1 0 0</xyz></axis></joint>"
)


def test_a_link_and_a_joint_have_one_name_up_to_sdf_1_6(model: ModelReader, golden: Golden) -> None:
    read = model(TWIN.format(turn=pi / 2), version="1.6")
    (joint,) = read.joints
    assert (joint.name, joint.parent, joint.child) == ("arm", "base", "arm")
    assert joint.pose.position == pytest.approx((1, 0, 2))  # the frame of the child, then its own pose
    assert joint.pose.rotate(joint.axis) == pytest.approx((0, 1, 0))
    with golden.raises(SceneError, match="'arm'.*<link>"):
        model(TWIN.format(turn=0), version="1.7")


def test_two_links_of_one_name_are_refused_in_every_version(model: ModelReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="'base'.*<link>"):
        model(LINK + LINK, version="1.6")


def test_scopes_in_names_are_refused_as_from_sdf_1_8(model: ModelReader, golden: Golden) -> None:
    flat = '<link name="hand::palm"><inertial/></link>'
    assert model(flat, version="1.7").links[0].name == "hand::palm"
    with golden.raises(SceneError, match=r"robot\.sdf:4.*'hand::palm'.*'::'"):
        model(flat, version="1.8")
    plugin = '<plugin name="gz::sim::systems::JointStatePublisher" filename="x"/>'
    assert model(LINK + plugin, version="1.8").warnings == ()


def test_parts_that_would_collide_or_be_static_in_gazebo_are_reported(model: ModelReader) -> None:
    nested = '<model name="{0}"><static>{1}</static><link name="l"><inertial/></link></model>'
    usual = f"<self_collide>0</self_collide>{LINK}" + nested.format("a", "false")
    assert model(usual).warnings == ()
    read = model(f"<self_collide>true</self_collide>{LINK}" + nested.format("a", "true"))
    assert [str(each).split(": ", 1)[1][:44] for each in read.warnings] == [
        "the <static> of the nested model 'a' is not ", "<self_collide> true of a <model> is not simu",
    ]  # fmt: skip
    assert model("<static>1</static>" + LINK + nested.format("a", "true")).warnings == ()


def test_shapes_without_sizes_have_those_of_the_specification(model: ModelReader, golden: Golden) -> None:
    shapes = "".join(
        f'<collision name="{tag}"><geometry><{tag}/></geometry></collision>'
        for tag in ("box", "sphere", "cylinder")
    )
    read = model(f'<link name="base"><inertial/>{shapes}</link>')
    assert [each.geometry for each in read.links[0].collisions] == [
        Box((1.0, 1.0, 1.0)), Sphere(1.0), Cylinder(1.0, 1.0),
    ]  # fmt: skip
    assert {warning.code for warning in read.warnings} == {Code.NRP264}
    assert "<size>: 1 1 1" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_a_static_model_without_a_link_is_nothing_to_simulate(world: WorldReader) -> None:
    scene = world('<model name="mark"><static>true</static></model>')
    assert (scene.models, scene.warnings) == ((), ())
    (warning,) = world('<model name="mark"/>').warnings
    assert warning.code is Code.NRP260


JOINT = '<joint name="j" type="fixed"><parent>{0}</parent><child>{1}</child></joint>'


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (
            '<frame name="f" attached_to="robt"/>',
            "'robt'.*'robot'",
        ),
        (JOINT.format("world", "robot::bass"), "'robot::bass'.*'robot::base'"),
        (JOINT.format("robot::base", "robot"), "'j'.*'robot::base'"),
    ],
)
def test_wrong_references_of_a_world_are_refused(
    world: WorldReader, inside: str, message: str, golden: Golden
) -> None:
    with golden.raises(SceneError, match=message):
        world(f'<model name="robot">{LINK}</model>{inside}')


HINGE = (
    '<joint name="swing" type="revolute"><pose>0 0 1 0 0 0</pose><parent>world</parent><child>{0}</child>'
    "<axis><xyz>1 0 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>"
)


def test_a_joint_of_a_world_holds_a_model_as_one_in_the_model_does(world: WorldReader) -> None:
    arm = f"<pose>1 2 3 0 0 {pi / 2}</pose>{LINK}"
    outside = world(f'<model name="arm">{arm}</model>{HINGE.format("arm::base")}')
    inside = world(f'<model name="arm">{arm}{HINGE.format("base")}</model>')
    (joint,) = outside.model("arm").joints
    (expected,) = inside.model("arm").joints
    assert (joint.name, joint.kind, joint.parent, joint.child) == ("swing", "revolute", "world", "base")
    assert joint.pose.position == pytest.approx((0, 0, 1))  # of the link, in the frame of the model
    assert joint.pose.orientation == pytest.approx(expected.pose.orientation)
    assert (joint.axis, joint.lower, joint.upper) == (expected.axis, -1, 1)
    assert outside.warnings == inside.warnings == ()


PAIR = "".join(
    f'<model name="{name}"><pose>{x} 0 0 0 0 {turn}</pose>{LINK}</model>'
    for name, x, turn in (("a", 0, 0), ("b", 1, pi / 2))
)


def test_a_joint_of_a_world_ties_two_models(world: WorldReader) -> None:
    scene = world(PAIR + JOINT.format("a", "b::base"))
    (tie,) = scene.ties
    assert scene.warnings == ()
    assert (tie.name, tie.kind, tie.parent, tie.child) == ("j", "fixed", ("a", "base"), ("b", "base"))
    for there, here in tie.points:  # the frame of the joint is that of its child, at (1, 0) and turned to y
        x, y, z = here
        assert there == pytest.approx((1 - y, x, z))
    assert scene.without("a").ties == scene.without("b").ties == ()
    assert world(PAIR).digest != scene.digest == world(PAIR + JOINT.format("a", "b::base")).digest


def test_a_screw_between_two_models_is_left_out(world: WorldReader, golden: Golden) -> None:
    screw = JOINT.replace('type="fixed">', 'type="screw"><axis><xyz>1 0 0</xyz></axis>')
    scene = world(PAIR + screw.format("a", "b"))
    (warning,) = scene.warnings
    assert "'j'" in str(warning)
    golden(str(warning))
    assert (warning.code, scene.ties) == (Code.NRP260, ())


def test_a_rail_between_two_models_has_its_axis_in_the_frame_of_the_joint(world: WorldReader) -> None:
    limit = "<limit><lower>-1</lower><upper>2</upper></limit><dynamics><damping>3</damping></dynamics>"
    slide = JOINT.replace('type="fixed">', f'type="prismatic"><axis><xyz>1 0 0</xyz>{limit}</axis>')
    scene = world(PAIR + slide.format("a", "b"))
    (tie,) = scene.ties
    assert (scene.warnings, tie.kind) == ((), "prismatic")
    assert tie.freedoms == (Freedom("prismatic", pytest.approx((1, 0, 0)), -1.0, 2.0, 3.0),)


def test_a_joint_of_a_world_within_one_model_is_one_of_it(world: WorldReader) -> None:
    two = f'<model name="a">{LINK}<link name="arm"><pose>1 0 0 0 0 0</pose><inertial/></link></model>'
    scene = world(two + JOINT.format("a::base", "a::arm"))
    (joint,) = scene.model("a").joints
    assert (joint.parent, joint.child, scene.ties, scene.warnings) == ("base", "arm", (), ())


def test_a_frame_of_a_nested_model_is_found_by_its_name(model: ModelReader) -> None:
    nested = f'<model name="hand"><pose>0 0 1 0 0 0</pose>{LINK}</model>'
    read = model(
        f'{nested}<link name="tip"><pose relative_to="f"/><inertial/></link>'
        '<frame name="f" attached_to="hand::__model__"><pose>1 0 0 0 0 0</pose></frame>'
    )
    tip = read.link("tip")
    assert tip.pose == Pose((1.0, 0.0, 1.0))
