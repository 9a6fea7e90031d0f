"""Robots as URDF, read by PyBullet's own reader of URDF, and by nodes of ROS."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest
from nrp_core import load_experiment, open_world
from nrp_core.errors import SceneError
from nrp_core.world import Box, Capsule, Collision, Inertial, Joint, Link, Model, Pose, Scene, Visual

from conftest import Ros, Ros2, needs_ros, needs_ros2
from nrp_world_ros.urdf import described, urdf

LIMB = Pose.from_rpy((0.1, 0.2, 0.3), 0.4, 0.5, 0.6)
ARM = Model(
    "arm",
    (
        Link("base", visuals=(Visual("v", Box((0.1, 0.2, 0.3))),)),
        Link(
            "limb",
            LIMB,
            Inertial(3.5, Pose((0.01, 0.02, 0.03)), (0.1, 0.2, 0.25, 0.0, 0.0, 0.0)),
            visuals=(Visual("v", Box((0.4, 0.5, 0.6)), Pose((0.0, 0.0, 0.2))),),
            collisions=(Collision("c", Capsule(0.1, 0.4), Pose((0.0, 0.3, 0.0))),),
        ),
    ),
    (Joint("elbow", "revolute", "base", "limb", LIMB, (0.0, 1.0, 0.0), lower=-0.5, upper=1.5),),
)


def test_pybullet_has_the_robot_where_the_scene_has_it(tmp_path: Path) -> None:
    bullet = import_module("pybullet")
    file = tmp_path / "arm.urdf"
    file.write_text(urdf(ARM))
    client = bullet.connect(bullet.DIRECT)
    try:
        body = bullet.loadURDF(str(file), useFixedBase=True, flags=bullet.URDF_USE_INERTIA_FROM_FILE)
        info = bullet.getJointInfo(body, 0)
        assert (info[1], info[2], info[8], info[9]) == (b"elbow", bullet.JOINT_REVOLUTE, -0.5, 1.5)
        assert info[12] == b"arm/limb"
        assert info[13] == pytest.approx((0.0, 1.0, 0.0))
        state = bullet.getLinkState(body, 0)
        assert state[4] == pytest.approx(LIMB.position)
        assert abs(sum(a * b for a, b in zip(state[5], LIMB.orientation, strict=True))) == pytest.approx(1.0)
        shapes = {shape[1]: shape for shape in bullet.getVisualShapeData(body)}
        assert shapes[0][3] == pytest.approx((0.4, 0.5, 0.6))
        assert shapes[0][5] == pytest.approx((0.0, 0.0, 0.2))
        mass, _, moments, centre = bullet.getDynamicsInfo(body, 0)[:4]
        assert (mass, moments, centre) == (3.5, pytest.approx((0.1, 0.2, 0.25)), (0.01, 0.02, 0.03))
        touched = {tuple(round(x, 6) for x in one[5]) for one in bullet.getCollisionShapeData(body, 0)}
        assert touched == {(-0.01, 0.28, z) for z in (-0.03, -0.23, 0.17)}  # from the centre of mass
    finally:
        bullet.disconnect(client)


def test_pybullet_reads_a_robot_of_many_parts(tmp_path: Path) -> None:
    bullet = import_module("pybullet")
    with open_world(load_experiment("walking_hexapod")) as world:
        model = world.scene.models[-1]
    file = tmp_path / "hexapod.urdf"
    file.write_text(urdf(model))
    client = bullet.connect(bullet.DIRECT)
    try:
        assert bullet.getNumJoints(bullet.loadURDF(str(file))) == len(model.joints) > 20
    finally:
        bullet.disconnect(client)


def test_a_joint_beside_the_frame_of_its_link_is_refused_and_one_along_its_axis_is_not() -> None:
    (joint,) = ARM.joints
    aside = replace(joint, pose=LIMB @ Pose((0.1, 0.0, 0.0)))
    with pytest.raises(SceneError, match=r"'elbow'.*'arm'"):
        urdf(replace(ARM, joints=(aside,)))
    along = replace(joint, pose=LIMB @ Pose((0.0, 0.1, 0.0)))
    assert urdf(replace(ARM, joints=(along,))) == urdf(ARM)


def test_one_robot_has_the_usual_name_and_several_their_own() -> None:
    room = Model("room", (Link("floor"),), static=True)
    assert set(described(Scene((ARM, room)))) == {"/robot_description"}
    assert set(described(Scene((ARM, replace(ARM, name="b"), room)))) == {
        "/arm/robot_description",
        "/b/robot_description",
    }


def links_and_joints(text: str) -> tuple[set[str], set[str]]:
    robot = ET.fromstring(text)
    return {link.attrib["name"] for link in robot.iter("link")}, {
        j.attrib["name"] for j in robot.iter("joint")
    }


def husky() -> tuple[set[str], set[str]]:
    with open_world(load_experiment("braitenberg_husky")) as world:
        model = next(each for each in world.scene.models if each.name == "husky")
    return {f"husky/{link.name}" for link in model.links}, {joint.name for joint in model.joints}


@pytest.mark.heavy
@needs_ros2
@pytest.mark.slow
def test_a_node_of_ros_2_that_comes_late_gets_the_robot(ros2: Ros2) -> None:
    ros2.body()
    text, _ = ros2.peer("description").communicate(timeout=60)
    assert links_and_joints(text) == husky()


TF2 = """
import json, rospy, tf2_ros
rospy.init_node("listener", anonymous=True)
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
frames = json.loads(rospy.myargv()[1])
for frame in frames:
    buffer.lookup_transform("world", frame, rospy.Time(0), rospy.Duration(20))
print("all there")
print(rospy.get_param("/robot_description"))
"""


@needs_ros
@pytest.mark.slow
def test_tf2_of_ros_1_finds_every_link_of_the_robot_and_its_camera(bridged: Ros) -> None:
    camera = "husky/eye_vision_camera/camera_optical_frame"
    program = bridged.folder / "listen.py"
    program.write_text(TF2)
    frames = json.dumps([*sorted(husky()[0]), camera])
    first, _, text = bridged.run("/usr/bin/python3", str(program), frames).partition("\n")
    assert first == "all there"
    assert links_and_joints(text) == husky()
