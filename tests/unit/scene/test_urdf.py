"""URDF is read as the SDF that it means, so here is only what it says in its own way."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, pi
from pathlib import Path

import cv2
import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code, Level
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.model import Box, Capsule, Cylinder, Inertial, Mesh, Mimic, Model, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene

MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
WHITE = (1, 1, 1)
TWO_LINKS = f'<link name="base">{MASS}</link><link name="arm">{MASS}</link>'


@pytest.fixture
def urdf(tmp_path: Path) -> Callable[..., Model]:
    """Read the contents of a <robot>, the first line of which is line 2 of the file."""

    def read(body: str, **options: object) -> Model:
        path = tmp_path / "robot.urdf"
        path.write_text(f'<robot name="r2" xmlns:xacro="http://ros.org/wiki/xacro">\n{body}\n</robot>')
        return read_model(path, **options)  # type: ignore[arg-type]

    return read


UrdfReader = Callable[..., Model]


def joint(kind: str, inside: str = "", name: str = "j", parent: str = "base") -> str:
    ends = f'<parent link="{parent}"/><child link="arm"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def test_a_link_has_its_mass_its_shapes_and_their_places(urdf: UrdfReader) -> None:
    origin = f'<origin xyz="1 2 3" rpy="0 0 {pi}"/>'
    read = urdf(
        '<link name="base"><inertial><mass value="2"/><origin xyz="0 0 1"/>'
        '<inertia ixx="3" iyy="4" izz="5" ixy="0.1" ixz="0.2" iyz="0.3"/></inertial>'
        f'<visual>{origin}<geometry><box size="1 2 3"/></geometry></visual>'
        f'<visual>{origin}<geometry><sphere radius="2"/></geometry></visual>'
        f'<collision name="hull">{origin}<geometry><cylinder radius="1" length="2"/></geometry></collision>'
        "</link>"
    )
    (base,) = read.links
    assert (read.name, read.warnings) == ("r2", ())
    assert base.inertial == Inertial(2, Pose((0, 0, 1)), (3, 4, 5, 0.1, 0.2, 0.3))
    assert [(v.name, v.geometry) for v in base.visuals] == [
        ("base_visual", Box((1, 2, 3))),
        ("base_visual_1", Sphere(2)),
    ]
    (hull,) = base.collisions
    assert (hull.name, hull.geometry, hull.pose.position) == ("hull", Cylinder(1, 2), (1, 2, 3))
    assert abs(hull.pose.yaw) == pytest.approx(pi)


def test_capsules_and_meshes_are_read(urdf: UrdfReader, tmp_path: Path, tetrahedron: Triangles) -> None:
    (tmp_path / "meshes").mkdir()
    write_stl(tmp_path / "meshes/a.stl", tetrahedron)
    read = urdf(
        f'<link name="base">{MASS}<visual><geometry><capsule radius="1" length="2"/></geometry></visual>'
        '<visual><geometry><mesh filename="package://meshes/a.stl" scale="2 2 2"/></geometry></visual></link>'
    )
    capsule, mesh = (visual.geometry for visual in read.links[0].visuals)
    assert capsule == Capsule(1, 2)
    assert isinstance(mesh, Mesh)
    assert mesh.scale == (2, 2, 2)
    assert read.warnings == ()


def test_materials_are_named_once_or_given_in_place(urdf: UrdfReader, golden: Golden) -> None:
    def skin(material: str) -> str:
        return f'<visual><geometry><box size="1 1 1"/></geometry>{material}</visual>'

    read = urdf(
        '<material name="blue"><color rgba="0 0 1 0.5"/></material>'
        f'<link name="base">{MASS}'
        + skin('<material name="blue"/>')
        + skin('<material name="mine"><color rgba="0.1 0.2 0.3 1"/></material>')
        + skin('<material name="nowhere"/>')
        + "</link>"
    )
    assert [v.rgba for v in read.links[0].visuals][:2] == [(0, 0, 1, 0.5), (0.1, 0.2, 0.3, 1)]
    assert "'nowhere'" in str(read.warnings[0])
    golden(str(read.warnings[0]))


def test_an_image_is_tinted_by_the_colour_beside_it(urdf: UrdfReader, tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "poster.png"), np.full((2, 2, 3), 255, np.uint8))
    (tmp_path / "a.mtl").write_text("newmtl poster\nmap_Kd poster.png\n")
    places = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    (tmp_path / "imaged.obj").write_text(f"mtllib a.mtl\nusemtl poster\n{places}")
    (tmp_path / "plain.obj").write_text(places)
    color, image = '<color rgba="1 0.5 0 1"/>', '<texture filename="poster.png"/>'
    looks = {
        "plain.obj": [color, image, color + image],
        "imaged.obj": ["", color, '<color rgba="1 1 1 1"/>'],
    }
    visuals = "".join(
        f'<visual><geometry><mesh filename="{mesh}"/></geometry><material name="m">{look}</material></visual>'
        for mesh, materials in looks.items()
        for look in materials
    )
    read = urdf(f'<link name="base">{MASS}{visuals}</link>')
    tinted = (1, 0.5, 0)
    assert [v.rgba[:3] for v in read.links[0].visuals] == [tinted, WHITE, tinted, WHITE, tinted, WHITE]
    tints = [v.texture and v.texture.tint for v in read.links[0].visuals]
    assert tints == [None, WHITE, tinted, WHITE, tinted, WHITE]
    for empty in ("<texture/>", '<texture filename=""/>'):
        (plain,) = (
            urdf(
                f'<link name="base">{MASS}<visual><geometry><box size="1 1 1"/></geometry>'
                f'<material name="m">{color}{empty}</material></visual></link>'
            )
            .links[0]
            .visuals
        )
        assert (plain.rgba[:3], plain.texture, plain.finish) == (tinted, None, None)
    lost = urdf(f'<link name="base">{MASS}{visuals.replace("poster.png", "lost.png")}</link>')
    assert any("the image 'lost.png' is not there: left out" in str(each) for each in lost.warnings)


def test_a_child_stands_at_its_joint(urdf: UrdfReader) -> None:
    read = urdf(
        TWO_LINKS
        + f'<link name="hand">{MASS}</link>'
        + joint("continuous", f'<origin xyz="1 0 0" rpy="0 0 {pi / 2}"/>')
        + '<joint name="wrist" type="fixed"><origin xyz="1 0 0"/>'
        + '<parent link="arm"/><child link="hand"/></joint>'
    )
    assert read.link("arm").pose.position == (1, 0, 0)
    assert read.link("hand").pose.position == pytest.approx((1, 1, 0))
    assert read.joints[1].pose.position == pytest.approx((1, 1, 0))


def test_the_axis_is_x_by_default_in_the_frame_of_the_joint(urdf: UrdfReader) -> None:
    turned = f'<origin rpy="0 0 {pi / 2}"/>'
    assert urdf(TWO_LINKS + joint("continuous", turned)).joints[0].axis == pytest.approx((1, 0, 0))
    given = urdf(TWO_LINKS + joint("continuous", turned + '<axis xyz="0 2 0"/>')).joints[0]
    assert given.axis == pytest.approx((0, 1, 0))


def test_limits_that_are_not_given_are_0(urdf: UrdfReader) -> None:
    limit = '<limit upper="2" effort="3" velocity="4"/><dynamics damping="0.5"/>'
    read = urdf(TWO_LINKS + joint("revolute", limit)).joints[0]
    assert (read.kind, read.lower, read.upper, read.effort, read.velocity, read.damping) == (
        "revolute",
        0,
        2,
        3,
        4,
        0.5,
    )
    assert urdf(TWO_LINKS + joint("continuous", '<limit effort="3" velocity="4"/>')).joints[0].lower == -inf


def test_a_revolute_joint_without_a_limit_is_continuous(urdf: UrdfReader) -> None:
    assert urdf(TWO_LINKS + joint("revolute")).joints[0].kind == "continuous"


def test_the_link_called_world_is_the_world(urdf: UrdfReader) -> None:
    read = urdf(
        f'<link name="world"/><link name="arm">{MASS}</link>'
        + joint("fixed", '<origin xyz="0 0 2"/>', parent="world")
    )
    assert [link.name for link in read.links] == ["arm"]
    assert (read.joints[0].parent, read.links[0].pose.position) == ("world", (0, 0, 2))


def test_a_floating_joint_lets_its_child_go(urdf: UrdfReader) -> None:
    read = urdf(TWO_LINKS + joint("floating", '<origin xyz="0 0 2"/>'))
    assert read.joints == ()
    assert read.link("arm").pose.position == (0, 0, 2)


def test_a_planar_joint_slides_in_a_plane_and_turns_about_its_normal(urdf: UrdfReader) -> None:
    read = urdf(TWO_LINKS + joint("planar", '<axis xyz="0 1 0"/><limit effort="1" velocity="1"/>'))
    assert [(each.name, each.kind) for each in read.joints] == [
        ("j_x", "prismatic"), ("j_y", "prismatic"), ("j", "continuous")
    ]  # fmt: skip
    assert read.joints[-1].axis == (0, 1, 0)


def test_a_block_gives_a_joint_a_spring(urdf: UrdfReader) -> None:
    springs = "<springStiffness>7</springStiffness><springReference>0.3</springReference>"
    damped = '<axis xyz="0 1 0"/><dynamics damping="2"/>'
    read = urdf(TWO_LINKS + joint("continuous", damped) + f'<gazebo reference="j">{springs}</gazebo>')
    assert (read.joints[0].stiffness, read.joints[0].rest, read.joints[0].damping) == (7.0, 0.3, 2.0)
    assert not read.warnings


def test_a_joint_may_have_the_name_of_a_link(urdf: UrdfReader) -> None:
    assert urdf(TWO_LINKS + joint("fixed", name="arm")).joints[0].name == "arm_joint"


def test_it_may_be_renamed_and_included_in_a_world(urdf: UrdfReader, tmp_path: Path) -> None:
    assert urdf(TWO_LINKS + joint("continuous"), name="left").joint_states_topic == "/left/joint_states"
    (tmp_path / "room.sdf").write_text(
        '<sdf version="1.9"><world name="w">'
        "<include><uri>robot.urdf</uri><name>r7</name></include></world></sdf>"
    )
    assert read_scene(tmp_path / "room.sdf").model("r7").joints[0].kind == "continuous"


# -- <gazebo>


def test_gazebo_elements_of_a_link_apply_to_it(urdf: UrdfReader) -> None:
    box = '<geometry><box size="1 1 1"/></geometry>'
    read = urdf(
        f'<link name="base">{MASS}<visual>{box}<material name="m"><color rgba="0 1 0 1"/></material></visual>'
        f"<collision>{box}</collision></link>"
        '<gazebo reference="base"><material>Gazebo/Red</material><mu1>0.5</mu1><mu2 value="0.5"/>'
        "<maxContacts>10</maxContacts><kp>1e7</kp>"
        '<sensor name="cam" type="camera"><update_rate>10</update_rate><topic>eye</topic><camera/></sensor>'
        "</gazebo>"
    )
    (base,) = read.links
    assert base.visuals[0].rgba == (1, 0, 0, 1)
    assert base.collisions[0].friction == 0.5
    assert (base.sensors[0].topic, base.sensors[0].rate_hz) == ("/r2/eye", 10)
    (note,) = read.warnings
    assert (note.level, note.subject, note.line) == (Level.NOTE, "kp", 2)


def test_gazebo_elements_without_a_reference_apply_to_the_model(urdf: UrdfReader) -> None:
    read = urdf(
        TWO_LINKS
        + f'<link name="other">{MASS}</link>'
        + joint("continuous")
        + '<joint name="k" type="continuous"><parent link="base"/><child link="other"/></joint>'
        + '<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so"><leftJoint>j</leftJoint>'
        "<rightJoint>k</rightJoint></plugin></gazebo>"
    )
    assert read.drives[0].command_topic == "/r2/cmd_vel"


def test_gravity_can_be_turned_off(urdf: UrdfReader) -> None:
    block = '<gazebo reference="base"><turnGravityOff>{}</turnGravityOff></gazebo>'
    for value, pulled in (("true", False), ("false", True)):
        read = urdf(f'<link name="base">{MASS}</link>{block.format(value)}')
        assert (read.links[0].gravity, read.warnings) == (pulled, ())


# -- errors, with the line of the URDF


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ('<link name="base"><visual><geometry><box size="1 0 1"/></geometry></visual></link>', "more than 0"),
        ('<link name="base"><visual><geometry/></visual></link>', "<geometry>"),
        (
            '<link name="base"><visual><geometry><sphere/></geometry></visual></link>',
            "<sphere> needs .*radius",
        ),
        (
            '<link name="base"><visual><geometry><cone/></geometry><origin xyz="1 2"/></visual></link>',
            "<origin>.*'1 2'",
        ),
        ('<link name="base"><inertial/></link>', "<inertial> needs a <mass>"),
        (
            f'<link name="base">{MASS.replace("1", "-1", 1)}</link>',
            "'base'.*-1",
        ),
        (TWO_LINKS + joint("planer"), "'planer'"),
        (TWO_LINKS + joint("fixed", parent="bass"), "'bass'"),
    ],
)
def test_an_error_points_into_the_file(urdf: UrdfReader, body: str, message: str, golden: Golden) -> None:
    with golden.raises(SceneError, match=message) as refusal:
        urdf(body)
    assert refusal.value.line == 2
    assert str(refusal.value.path).endswith("robot.urdf")


def test_a_block_about_a_missing_part_is_ignored_with_a_warning(urdf: UrdfReader, golden: Golden) -> None:
    (warning,) = urdf(f'<link name="arm">{MASS}</link><gazebo reference="arms"/>').warnings
    assert "robot.urdf:2" in str(warning)
    golden(str(warning))


def test_unknown_elements_and_those_for_other_programs_cause_a_warning(
    urdf: UrdfReader, golden: Golden
) -> None:
    other, unknown = urdf(f'<link name="base">{MASS}</link><sensor name="t"/><lnk/>').warnings
    assert "robot.urdf:2" in str(other)
    golden(str(other))
    assert "<robot>" in str(unknown)
    golden(str(unknown))


def test_an_inertia_of_0_is_that_of_the_shapes(urdf: UrdfReader) -> None:
    nothing = '<inertial><mass value="12"/><origin xyz="0 0 1"/><inertia ixx="0" iyy="0" izz="0"/></inertial>'
    box = '<collision><geometry><box size="1 2 3"/></geometry></collision>'
    read = urdf(f'<link name="base">{nothing}{box}</link>')
    inertial = read.links[0].inertial
    assert inertial is not None
    assert inertial.mass == 12
    assert inertial.pose.position == (0, 0, 1)
    assert inertial.inertia == pytest.approx((13, 10, 5, 0, 0, 0))
    assert "has no inertia or one of about 0: the inertia of its collision shapes is used" in str(
        read.warnings[0]
    )


def test_without_shapes_it_is_that_of_a_small_ball(urdf: UrdfReader) -> None:
    nothing = '<inertial><mass value="2"/><inertia ixx="0" iyy="0" izz="0"/></inertial>'
    inertial = urdf(f'<link name="base">{nothing}</link>').links[0].inertial
    assert inertial is not None
    assert inertial.inertia == pytest.approx((0.002, 0.002, 0.002, 0, 0, 0))


def test_a_transmission_lets_a_joint_be_commanded(urdf):
    def transmission(interface: str) -> str:
        return (
            '<transmission name="t"><type>transmission_interface/SimpleTransmission</type>'
            '<joint name="hinge">'
            f"<hardwareInterface>{interface}</hardwareInterface></joint></transmission>"
        )

    arm = (
        f'<link name="base">{MASS}</link><link name="hand">{MASS}</link>'
        '<joint name="hinge" type="continuous"><parent link="base"/><child link="hand"/></joint>'
        '<gazebo><plugin name="control" filename="libgazebo_ros_control.so"/></gazebo>'
    )
    for interface, kind, topic in (
        ("hardware_interface/EffortJointInterface", "effort", "cmd_effort"),
        ("PositionJointInterface", "position", "cmd_pos"),
        ("hardware_interface/VelocityJointInterface", "velocity", "cmd_vel"),
    ):
        read = urdf(arm + transmission(interface))
        (controller,) = read.controllers
        assert (controller.joint, controller.kind, controller.gains) == ("hinge", kind, None)
        assert controller.topic == f"/{read.name}/hinge/{topic}"
        assert not read.warnings
    assert "cannot be commanded by 'ImuInterface'" in str(
        urdf(arm + transmission("ImuInterface")).warnings[0]
    )


def test_a_transmission_without_its_joint_commands_nothing_and_says_so(urdf, golden: Golden):
    arm = (
        f'<link name="base">{MASS}</link><link name="hand">{MASS}</link>'
        '<joint name="hinge" type="continuous"><parent link="base"/><child link="hand"/></joint>'
    )
    kind = "<hardwareInterface>PositionJointInterface</hardwareInterface>"
    read = urdf(f'{arm}<transmission name="t"/>')
    (warning,) = read.warnings
    assert (warning.code, read.controllers) == (Code.NRP265, ())
    assert "<transmission> 't'" in str(warning)
    golden(str(warning))
    read = urdf(f'{arm}<transmission name="t"><joint name="hing">{kind}</joint></transmission>')
    (warning,) = read.warnings
    assert (warning.code, read.controllers) == (Code.NRP265, ())
    assert "'hinge'" in str(warning)
    golden(str(warning))


@pytest.mark.parametrize("tag", ["visual", "collision"])
def test_a_visual_or_collision_without_a_shape_is_left_out(urdf, tag):
    read = urdf(f'<link name="base">{MASS}<{tag} name="bare"/></link>')
    (warning,) = read.warnings
    assert f"the {tag} 'bare' has no <geometry>: left out" in str(warning)
    assert (warning.code, read.links[0].visuals, read.links[0].collisions) == (Code.NRP260, (), ())


def test_an_interface_of_ros2_control_lets_a_joint_be_commanded(urdf):
    def system(*interfaces: str) -> str:
        commands = "".join(f'<command_interface name="{name}"/>' for name in interfaces)
        joint = f'<joint name="hinge">{commands}<state_interface name="position"/></joint>'
        return f'<ros2_control name="all" type="system"><hardware/>{joint}</ros2_control>'

    arm = (
        f'<link name="base">{MASS}</link><link name="hand">{MASS}</link>'
        '<joint name="hinge" type="continuous"><parent link="base"/><child link="hand"/></joint>'
        '<gazebo><plugin name="control" filename="libgazebo_ros2_control.so"/></gazebo>'
    )
    read = urdf(arm + system("position", "effort"))
    assert [(each.joint, each.kind) for each in read.controllers] == [
        ("hinge", "position"),
        ("hinge", "effort"),
    ]
    assert not read.warnings
    assert "joints cannot be commanded by 'impedance'" in str(urdf(arm + system("impedance")).warnings[0])


def test_a_joint_follows_the_one_it_mimics_and_has_dry_friction(urdf):
    links = "".join(f'<link name="{name}">{MASS}</link>' for name in ("base", "left", "right"))
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="base"/><child link="{name}"/>{more}</joint>'
        for name, more in (
            ("left", '<dynamics friction="0.2"/>'),
            ("right", '<mimic joint="left" multiplier="-2" offset="0.1"/>'),
        )
    )
    read = urdf(links + joints)
    assert [joint.friction for joint in read.joints] == [0.2, 0.0]
    assert [joint.mimic for joint in read.joints] == [None, Mimic("left_joint", -2.0, 0.1)]
    assert not read.warnings


def test_a_plugin_names_a_joint_that_has_the_name_of_a_link(urdf):
    wheels = "".join(
        f'<link name="{name}">{MASS}</link><joint name="{name}" type="continuous"><parent link="base"/>'
        f'<child link="{name}"/></joint>'
        for name in ("left", "right")
    )
    drive = (
        '<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">'
        "<leftJoint>left</leftJoint><rightJoint>right</rightJoint></plugin></gazebo>"
    )
    (read,) = urdf(f'<link name="base">{MASS}</link>{wheels}{drive}').drives
    assert (read.left, read.right) == (("left_joint",), ("right_joint",))


def test_a_link_that_no_joint_holds_is_warned_of(urdf: UrdfReader, golden: Golden) -> None:
    read = urdf(f'<link name="base">{MASS}</link><link name="lost">{MASS}</link>')
    (warning,) = read.warnings
    assert "'lost'" in str(warning)
    golden(str(warning))


def test_a_joint_of_gazebo_holds_a_link(urdf: UrdfReader) -> None:
    ends = "<parent>base</parent><child>tip</child>"
    block = f'<gazebo><joint name="wrist" type="fixed">{ends}</joint></gazebo>'
    read = urdf(f'<link name="base">{MASS}</link><link name="tip">{MASS}</link>{block}')
    assert [joint.name for joint in read.joints] == ["wrist"]
    assert read.warnings == ()


def test_the_mass_of_a_link_without_one_is_that_of_the_links_fixed_to_it(urdf: UrdfReader) -> None:
    shape = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    nothing = '<inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0"/></inertial>'
    links = (
        f'<link name="base">{shape}</link><link name="plate">{nothing}{shape}</link>'
        f'<link name="inertia">{MASS}</link><link name="wheel">{shape}</link>'
    )
    fixed = "".join(
        f'<joint name="{one}_{other}" type="fixed"><parent link="{one}"/><child link="{other}"/></joint>'
        for one, other in (("base", "plate"), ("plate", "inertia"))
    )
    turns = '<joint name="w" type="continuous"><parent link="base"/><child link="wheel"/></joint>'
    masses = {link.name: link.inertial and link.inertial.mass for link in urdf(links + fixed + turns).links}
    assert masses == {"base": None, "plate": None, "inertia": 1.0, "wheel": 1000.0}


@pytest.mark.parametrize(("effort", "velocity", "told"), [("0", "0.0", "0"), ("-5", "-5", "-5")])
def test_limits_of_effort_and_velocity_that_hold_a_joint_still_are_none(
    urdf: UrdfReader, effort: str, velocity: str, told: str
) -> None:
    limit = f'<limit lower="-1" upper="1" effort="{effort}" velocity="{velocity}"/>'
    model = urdf(f'<link name="base">{MASS}</link><link name="arm">{MASS}</link>{joint("revolute", limit)}')
    (turning,) = model.joints
    assert (turning.effort, turning.velocity, turning.lower) == (inf, inf, -1.0)
    (said,) = (each.message for each in model.warnings if each.code is Code.NRP384)
    assert f"the effort and velocity of the joint 'j' are limited to {told}," in said


def test_a_file_has_one_finding_for_joints_without_limits_and_one_for_missing_meshes(
    urdf: UrdfReader,
) -> None:
    mesh = '<visual><geometry><mesh filename="m{}.stl"/></geometry></visual>'
    links = "".join(f'<link name="l{n}">{MASS}{mesh.format(n)}</link>' for n in range(6))
    turns = "".join(
        f'<joint name="j{n}" type="continuous"><parent link="l{n}"/><child link="l{n + 1}"/>'
        f'<limit effort="{n % 2}" velocity="0"/></joint>'
        for n in range(5)
    )
    missing, limits = sorted(urdf(links + turns).warnings, key=lambda each: each.code.name)
    assert (missing.code, missing.count, limits.code, limits.count) == (Code.NRP258, 6, Code.NRP384, 5)
    assert missing.message.endswith("; also 'm1.stl', 'm2.stl', 'm3.stl' and 2 more")
    assert limits.message.endswith("; also 'j1', 'j2', 'j3' and 1 more")


def test_a_link_without_mass_at_a_force_sensor_gets_a_little_because_it_moves_alone(urdf: UrdfReader) -> None:
    links = f'<link name="base">{MASS}</link><link name="hip"/><link name="arm">{MASS}</link>'
    turns = '<joint name="t" type="continuous"><parent link="base"/><child link="hip"/></joint>'
    felt = '<gazebo reference="j"><sensor name="ft" type="force_torque"/></gazebo>'
    model = urdf(links + turns + joint("fixed", parent="hip") + felt)
    assert [body.inertial and body.inertial.mass for body in bodies_of(model)] == [1.0, 0.002, 1.0]


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('<xacro:include filename="robot.urdf"/>', "it includes itself"),
        ('<xacro:include filename="$(find nowhere)/x.xacro"/>', "file: there is no package 'nowhere'"),
        ('<link name="$(env NRP_NOWHERE)"/>', "environment variable 'NRP_NOWHERE' is not set"),
        ('<link name="$(fnd x)"/>', "Unknown substitution command [fnd x]"),
        ('<link name="${half}"/>', "name 'half' is not defined"),
        ('<link name="${2 + 9**9**9}"/>', "9 ** 9 ** 9"),
        ('<xacro:property name="n" value="999999"/><link name="${n**(n*n)}"/>', "n ** (n * n)"),
    ],
)
def test_a_xacro_file_that_cannot_be_expanded_is_an_error_in_plain_words(
    urdf: UrdfReader, body: str, words: str
) -> None:
    pytest.importorskip("xacro")
    with pytest.raises(SceneError) as caught:
        urdf(TWO_LINKS + body)
    assert str(caught.value).count(words.removeprefix("file: ")) == 1
    assert words in str(caught.value)
    assert "class" not in str(caught.value)
