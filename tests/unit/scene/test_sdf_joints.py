from __future__ import annotations

from collections.abc import Callable
from math import inf, pi, sqrt

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.model import Joint, Mimic, Model

ModelReader = Callable[..., Model]

LINKS = """<link name="base"><inertial/></link>
<link name="arm"><pose>0 0 1 0 0 1.5707963267948966</pose><inertial/></link>
"""


@pytest.fixture
def joint(model: ModelReader) -> Callable[..., Joint]:
    """Read a <joint> (line 6 of its file) from ``base`` to ``arm``, which is turned by 90 degrees."""

    def read(body: str = "", *, kind: str = "revolute", version: str = "1.9") -> Joint:
        ends = "<parent>base</parent><child>arm</child>"
        text = f'{LINKS}<joint name="j" type="{kind}">{ends}\n{body}</joint>'
        return model(text, version=version).joints[0]

    return read


JointReader = Callable[..., Joint]


def test_a_revolute_joint_without_limits_is_continuous(joint: JointReader) -> None:
    read = joint("<axis><xyz>0 1 0</xyz></axis>")
    assert (read.kind, read.lower, read.upper, read.effort, read.velocity) == (
        "continuous",
        -inf,
        inf,
        inf,
        inf,
    )


@pytest.mark.parametrize(
    "limit",
    [
        "<limit/>",
        "<limit><lower>-1e16</lower><upper>1e16</upper></limit>",
        "<limit><lower>-1.79769e+308</lower><upper>1.79769e+308</upper></limit>",
        "<limit><lower>-inf</lower><upper>inf</upper></limit>",
    ],
)
def test_every_spelling_of_an_unlimited_joint_is_continuous(joint: JointReader, limit: str) -> None:
    assert joint(f"<axis><xyz>0 1 0</xyz>{limit}</axis>").kind == "continuous"


def test_limits_and_damping_are_read(joint: JointReader) -> None:
    limit = "<limit><lower>-1</lower><upper>2</upper><effort>3</effort><velocity>4</velocity></limit>"
    read = joint(f"<axis><xyz>0 1 0</xyz>{limit}<dynamics><damping>0.5</damping></dynamics></axis>")
    assert (read.kind, read.lower, read.upper, read.effort, read.velocity, read.damping) == (
        "revolute",
        -1,
        2,
        3,
        4,
        0.5,
    )


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        ("<effort>-500</effort>", ["the <effort> of the joint 'j' is -500: a negative one is no limit"]),
        ("<velocity>-20</velocity>", ["the <velocity> of the joint 'j' is -20: a negative one is no lim"]),
        ("<effort>-1</effort><velocity>-1.0</velocity>", []),
        ("<effort>-1e16</effort><velocity>inf</velocity>", []),
    ],
)
def test_a_negative_limit_that_does_not_say_none_is_reported(
    model: Callable[..., Model], limit: str, said: list[str]
) -> None:
    axis = f"<axis><xyz>0 1 0</xyz><limit>{limit}</limit></axis>"
    ends = "<parent>base</parent><child>arm</child>"
    links = '<link name="base"/><link name="arm"/>'
    read = model(f'{links}<joint name="j" type="revolute">{ends}{axis}</joint>')
    found = [one.message for one in read.warnings if "mass" not in one.message]
    assert [words in one for words, one in zip(said, found, strict=True)] == [True] * len(said)


def test_a_negative_effort_means_unlimited(joint: JointReader) -> None:
    assert joint("<axis><limit><effort>-1</effort></limit></axis>").effort == inf


def test_the_limits_of_a_continuous_joint_do_not_count(joint: JointReader) -> None:
    read = joint("<axis><limit><lower>0</lower><upper>0</upper></limit></axis>", kind="continuous")
    assert (read.kind, read.lower, read.upper) == ("continuous", -inf, inf)


def test_a_joint_held_between_0_and_0_is_fixed(joint: JointReader) -> None:
    assert joint("<axis><limit><lower>0</lower><upper>0</upper></limit></axis>").kind == "fixed"


def test_crossed_limits_are_refused(joint: JointReader, golden: Golden) -> None:
    with golden.raises(SceneError, match=r"\(2\).*\(1\)") as refusal:
        joint("<axis><limit><lower>2</lower><upper>1</upper></limit></axis>")
    assert refusal.value.line == 7


def test_the_axis_is_z_by_default_and_of_length_1(joint: JointReader, golden: Golden) -> None:
    assert joint("<axis/>").axis == (0, 0, 1)
    assert joint("<axis><xyz>0 2 0</xyz></axis>").axis == (0, 1, 0)
    with golden.raises(SceneError, match="<xyz>.*0 0 0"):
        joint("<axis><xyz>0 0 0</xyz></axis>")


@pytest.mark.parametrize(
    ("version", "axis", "in_joint_frame"),
    [
        # the arm, and the joint with it, is turned to the left: the model's x is its -y
        ("1.9", "<xyz>1 0 0</xyz>", (1, 0, 0)),
        ("1.9", '<xyz expressed_in="__model__">1 0 0</xyz>', (0, -1, 0)),
        ("1.9", '<xyz expressed_in="base">1 0 0</xyz>', (0, -1, 0)),
        ("1.9", '<xyz expressed_in="arm">1 0 0</xyz>', (1, 0, 0)),
        ("1.5", "<xyz>1 0 0</xyz>", (1, 0, 0)),
        ("1.6", "<xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame>", (0, -1, 0)),
        ("1.6", "<xyz>1 0 0</xyz><use_parent_model_frame>0</use_parent_model_frame>", (1, 0, 0)),
        ("1.4", "<xyz>1 0 0</xyz>", (0, -1, 0)),
    ],
)
def test_the_axis_is_given_in_the_frame_that_its_version_says(
    joint: JointReader, version: str, axis: str, in_joint_frame: tuple[float, ...]
) -> None:
    read = joint(f"<axis>{axis}</axis>", version=version)
    assert read.axis == pytest.approx(in_joint_frame, abs=1e-12)


def test_a_joint_is_where_its_child_is(joint: JointReader) -> None:
    read = joint()
    assert read.pose.position == (0, 0, 1)
    assert read.pose.yaw == pytest.approx(pi / 2)


def test_the_pose_of_a_joint_is_relative_to_its_child(joint: JointReader) -> None:
    assert joint("<pose>1 0 0 0 0 0</pose>").pose.position == pytest.approx((0, 1, 1))


def test_the_pose_of_a_joint_may_be_relative_to_another_frame(joint: JointReader) -> None:
    assert joint('<pose relative_to="base">1 0 0 0 0 0</pose>').pose.position == pytest.approx((1, 0, 0))


@pytest.mark.parametrize("kind", ["fixed", "prismatic", "continuous"])
def test_other_kinds_of_joints_are_read(joint: JointReader, kind: str) -> None:
    assert joint(kind=kind).kind == kind


def test_an_unknown_kind_of_joint_is_refused(joint: JointReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="'revolut'.*'revolute'"):
        joint(kind="revolut")


def test_a_fixed_joint_takes_no_commands(model: ModelReader, golden: Golden) -> None:
    plugin = (
        '<plugin name="c" filename="libgeneric_controller_plugin.so"><controller joint_name="j">'
        "<type>position</type></controller></plugin>"
    )
    joint = '<joint name="j" type="fixed"><parent>base</parent><child>arm</child></joint>'
    read = model(LINKS + joint + plugin)
    assert read.controllers == ()
    assert "robot.sdf:6" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_the_world_holds_a_link(model: ModelReader) -> None:
    read = model(f'{LINKS}<joint name="j" type="fixed"><parent>world</parent><child>base</child></joint>')
    assert read.joints[0].parent == "world"


# -- what joints must not do


def refuse(model: ModelReader, joints: str, message: str, line: int) -> None:
    with pytest.raises(SceneError, match=message) as refusal:
        model(LINKS + joints)
    assert refusal.value.line == line


def test_the_world_cannot_be_a_child(model: ModelReader) -> None:
    joint = '<joint name="j" type="fixed"><parent>base</parent><child>world</child></joint>'
    refuse(model, joint, "the world cannot be the child", 6)


def test_a_joint_to_nowhere_is_refused(model: ModelReader) -> None:
    joint = '<joint name="j" type="fixed"><parent>base</parent>\n<child>amr</child></joint>'
    refuse(model, joint, "has no frame 'amr'; did you mean 'arm'", 7)


def test_a_joint_without_ends_is_refused(model: ModelReader) -> None:
    refuse(model, '<joint name="j" type="fixed"><child>arm</child></joint>', "<joint> needs a <parent>", 6)
    refuse(model, '<joint name="j" type="fixed"><parent/><child>arm</child></joint>', "must name a link", 6)


def test_a_joint_from_a_link_to_itself_is_refused(model: ModelReader) -> None:
    joint = '<joint name="j" type="fixed"><parent>arm</parent><child>arm</child></joint>'
    refuse(model, joint, "the joint 'j' connects the link 'arm' with itself", 6)


def test_a_joint_that_closes_a_loop_is_not_in_the_tree(model: ModelReader, golden: Golden) -> None:
    joints = "\n".join(
        f'<joint name="{a}_{b}" type="revolute"><parent>{a}</parent><child>{b}</child></joint>'
        for a, b in (("base", "arm"), ("arm", "base"))
    )
    read = model(LINKS + joints)
    assert [joint.name for joint in read.joints] == ["base_arm"]
    assert [(loop.name, loop.parent, loop.child) for loop in read.loops] == [("arm_base", "arm", "base")]
    assert "robot.sdf:7" in str(read.warnings[0])
    golden(str(read.warnings[0]))
    slides = model(LINKS + joints.replace('"revolute"', '"prismatic"'))
    assert slides.loops == ()
    assert "'prismatic'" in str(slides.warnings[0])
    golden(str(slides.warnings[0]))


def test_a_joint_closes_a_loop_also_if_its_parent_is_held_by_a_later_one(
    model: ModelReader, golden: Golden
) -> None:
    joints = "\n".join(
        f'<joint name="{a}_{b}" type="ball"><parent>{a}</parent><child>{b}</child></joint>'
        for a, b in (("base", "arm"), ("rod", "arm"), ("base", "rod"))
    )
    read = model(LINKS + '<link name="rod"><inertial/></link>' + joints)
    assert [joint.name for joint in read.joints] == ["base_arm", "base_rod"]
    assert [loop.name for loop in read.loops] == ["rod_arm"]
    locked = joints.replace('"rod_arm" type="ball"', '"rod_arm" type="fixed"')
    with golden.raises(SceneError, match="'base_arm'.*'rod_arm'.*'arm'"):
        model(LINKS + '<link name="rod"><inertial/></link>' + locked)


def test_a_link_with_two_parents_is_refused(model: ModelReader) -> None:
    joints = "\n".join(
        f'<joint name="from_{a}" type="revolute"><parent>{a}</parent><child>arm</child></joint>'
        for a in ("base", "world")
    )
    refuse(model, joints, "two joints, 'from_base' and 'from_world', hold the link 'arm'", 7)


def test_two_joints_of_one_name_are_refused(model: ModelReader) -> None:
    joint = '<joint name="j" type="fixed"><parent>base</parent><child>arm</child></joint>\n'
    refuse(model, joint + joint, "the name 'j' is used by the <joint> on line 6", 7)


def test_a_joint_mimics_another_one_from_where_that_is_at_its_reference(
    model: ModelReader, golden: Golden
) -> None:
    numbers = "<multiplier>2</multiplier><offset>0.5</offset><reference>0.1</reference>"
    mimic = f'<mimic joint="first">{numbers}</mimic>'
    text = (
        LINKS
        + '<link name="tip"><inertial/></link>'
        + "".join(
            f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>'
            f"<axis>{more}</axis></joint>"
            for name, parent, child, more in (("first", "base", "arm", ""), ("second", "arm", "tip", mimic))
        )
    )
    assert model(text).joints[1].mimic == Mimic("first", 2.0, pytest.approx(0.3))
    with golden.raises(SceneError, match="'second'.*'fist'"):
        model(text.replace('mimic joint="first"', 'mimic joint="fist"'))
    with golden.raises(SceneError, match="'second'"):
        model(text.replace('mimic joint="first"', 'mimic joint="second"'))
    (warning,) = model(text.replace('"first" type="revolute"', '"first" type="fixed"')).warnings
    assert "'second'" in str(warning)
    golden(str(warning))


@pytest.mark.parametrize(
    ("lower", "multiplier", "excluded"),
    [
        (0.0, -1, "exclude"),
        (-0.05, -1, "exclude for the most part"),
        (0.0, 0.5, None),
        (-0.5, -0.6, None),
        (0.0, 1.5, None),  # the follower stops its leader at two thirds of its way
        (0.5, 1, None),  # the leader cannot move, and the follower is where it belongs
        (0.5, -1, "exclude"),
    ],
)
def test_a_joint_whose_limits_exclude_the_positions_that_it_mimics_has_none(
    model: ModelReader, lower: float, multiplier: float, excluded: str | None
) -> None:
    """Files of grippers have the limits of one finger for the other, which goes the other way."""
    limit = f"<limit><lower>{lower}</lower><upper>0.5</upper></limit>"
    mimic = f'<mimic joint="first"><multiplier>{multiplier}</multiplier></mimic>'
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>'
        f"<axis>{limit}{more}</axis></joint>"
        for name, parent, child, more in (("first", "base", "arm", ""), ("second", "arm", "tip", mimic))
    )
    read = model(LINKS + '<link name="tip"><inertial/></link>' + joints)
    assert (read.joints[0].lower, read.joints[0].upper) == (lower, 0.5)
    assert ((read.joints[1].lower, read.joints[1].upper) == (lower, 0.5)) == (excluded is None)
    said = f"which its limits of {lower:g} to 0.5 {excluded}: they are not used"
    told = [str(each) for each in read.warnings if "mimics" in str(each)]
    assert [said in each for each in told] == [True] * (excluded is not None)


def test_springs_and_friction_are_read(joint: JointReader) -> None:
    spring = "<spring_stiffness>3</spring_stiffness><spring_reference>-0.2</spring_reference>"
    read = joint(f"<axis><dynamics><friction>0.1</friction>{spring}</dynamics></axis>")
    assert (read.friction, read.stiffness, read.rest) == (0.1, 3.0, -0.2)


def test_an_oblique_axis_keeps_its_direction(joint: JointReader) -> None:
    assert joint("<axis><xyz>1 1 0</xyz></axis>").axis == pytest.approx((sqrt(0.5), sqrt(0.5), 0))
