"""Robots of the platform move as their plugins made them move, on every pair of engines."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin

import pytest
from recorded import rows

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.scene.model import Box

Played = Callable[..., Run]


def test_a_husky_turns_by_the_speeds_of_its_wheels(played: Played) -> None:
    run = played("husky_wheels_2016/wheels.exc")
    motion = run.world.model_motion("husky")
    turn = (0.4 - 0.2) / 0.5709  # rad/s, of the separation in the file of the robot
    assert motion.angular[2] == pytest.approx(turn, rel=0.02)
    assert motion.pose.rpy[2] == pytest.approx(turn * 1.0, rel=0.03)


def test_a_bump_is_seen_in_all_contacts_of_the_world(played: Played) -> None:
    run = played("shelf_2018/shelf.exc")
    first = rows(run, "bump", "recorder")[0]
    # the body ends 0.45 m ahead of the origin and the shelf begins at 0.8 m; the wheels stay behind the body
    assert float(first[0]) == pytest.approx((0.8 - 0.45) / 0.8, abs=0.021)
    assert first[1] == "husky::base_link::body"
    assert not any("contact_point_data" in text for text in map(str, run.problems))


def test_of_two_joints_that_hold_a_link_the_second_is_left_out_and_the_robot_moves(played: Played) -> None:
    run = played("mouse_2018/mouse.exc")
    joints = run.world.joint_states("mouse")
    assert joints.positions[joints.names.index("shoulder")] == pytest.approx(0.4, abs=0.05)
    (told,) = [one for one in run.problems if "hold the link 'foot'" in one.message]
    assert "two joints, 'wrist' and 'tendon_to_foot'" in told.message
    assert told.code is Code.NRP260
    assert told.message.endswith("left out")
    held = {joint.name for joint in run.world.scene.model("mouse").joints}
    assert held == {"shoulder", "wrist", "tendon_to_trunk"}


def test_an_icub_holds_its_posture_and_turns_both_eyes(played: Played) -> None:
    run = played("icub_2018/icub.exc")
    joints = run.world.joint_states("icub")
    positions = dict(zip(joints.names, joints.positions.tolist(), strict=True))
    held = {"torso_pitch": 0.0, "eye_tilt": 0.0}
    held |= {
        f"{side}_{name}": at for side in "lr" for name, at in (("shoulder_pitch", -0.52), ("elbow", 0.785))
    }
    assert {name: positions[name] for name in held} == pytest.approx(held, abs=0.02)
    assert positions["neck_pitch"] == pytest.approx(-0.2, abs=0.02)  # -0.2 rad/s for a second
    time, *eyes = map(float, rows(run, "set_eyepos", "recorder")[-1])
    assert time == pytest.approx(1.98)
    # the version is the mean and the vergence the difference of both: 0.2 and 0.1 are 0.25 and 0.15
    assert eyes == pytest.approx([0.2, 0.1, 0.25, 0.15], abs=0.01)
    assert run.world.link_motion("icub", "head").pose.position[2] == pytest.approx(0.85, abs=0.02)
    assert not run.result().failures


def test_an_arm_without_meshes_stands_on_a_ground_without_one(played: Played) -> None:
    run = played("lab_2017/lab.exc")
    world = run.world
    assert world.model_motion("robot").pose.position == pytest.approx((0.0, 0.0, 0.3), abs=0.01)
    joints = world.joint_states("robot")
    elbow, wrist = (joints.positions[joints.names.index(name)] for name in ("elbow", "wrist"))
    assert (elbow, wrist) == pytest.approx((0.5, 0.3), abs=0.05)
    (hand,) = world.scene.model("robot").link("hand").collisions
    assert isinstance(hand.geometry, Box)
    assert max(hand.geometry.size) == pytest.approx(0.1)  # its inertia would be that of a box of 0.53 m
    table, chair = (world.scene.model(name).links[0].collisions[0].geometry for name in ("table", "chair"))
    assert isinstance(table, Box)
    assert isinstance(chair, Box)
    assert table.size == chair.size == pytest.approx((0.3, 0.3, 0.3))  # half the way to each other
    assert any("'lab_floor' is taken for the ground" in text for text in map(str, run.result().problems))


def test_textures_of_an_experiment_are_shown_in_their_mean_colour(opened: Played) -> None:
    run = opened("classroom_2019/classroom.exc")
    # rows of (255, 64, 0) and (255, 128, 0) in turn
    mean = pytest.approx((1.0, 96 / 255, 0.0, 1.0), abs=1e-6)
    assert run.world.scene.visuals["wall/link/bricks"].rgba == mean
    assert run.world.scene.visuals["poster/link/paper"].rgba == mean
    assert not any("shown grey" in text for text in map(str, run.problems))


def test_fonts_of_other_machines_and_indices_that_are_floats_work(opened: Played) -> None:
    run = opened("classroom_2019/classroom.exc")
    run.run()
    assert not run.result().failures
    assert int(rows(run, "write", "rows")[-1][1]) > 10  # some of the page is black
    assert rows(run, "sample", "rows")[-1][1:] == ["6.0", "[1.0, 2.0]", "[0.0, 3.0]", "half"]


def test_a_robot_with_legs_and_no_controller_moves_as_its_body_is_commanded(played: Played) -> None:
    run = played("lauron_2016/lauron.exc")
    pose = run.world.model_motion("lauron").pose
    # an arc of radius 0.2 / 0.3 m through 0.6 rad
    x, y = 0.2 / 0.3 * sin(0.6), 0.2 / 0.3 * (1 - cos(0.6))
    assert pose.position[:2] == pytest.approx((x, y), abs=0.02)
    assert pose.rpy[2] == pytest.approx(0.6, abs=0.02)
    assert pose.position[2] == pytest.approx(0.0, abs=0.05)  # its legs hold it up
    (told,) = [text for text in map(str, run.result().problems) if "'/lauron/cmd_vel'" in text]
    assert "its body slides as commanded, and its legs do not walk" in told
