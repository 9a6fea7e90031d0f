"""Bodies, joints and contacts, against closed forms."""

from __future__ import annotations

from math import cos, degrees, pi, radians, sin, sqrt

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.model import Box, Collision, Inertial, Joint, Link, Model, Scene, Sphere
from nrp_core.scene.rigid import ModelMotion, Pose, Wrench


def test_a_pose_comes_back_as_it_was_given_w_last(open_world, parts):
    given = Pose.from_rpy((1.0, 2.0, 3.0), 0.1, 0.2, pi / 2)
    world = open_world(parts.prop("box", Box((0.1, 0.2, 0.3)), given, mass=1.0))
    pose = world.model_motion("box").pose
    assert pose.position == pytest.approx(given.position)
    assert pose.orientation == pytest.approx(given.orientation)
    assert pose.yaw == pytest.approx(pi / 2)


def test_a_static_model_does_not_move(open_world, parts, advance):
    wall = parts.wall(2.0)
    world = open_world(wall)
    advance(world, 0.1)
    motion = world.model_motion("wall")
    assert motion.pose == wall.pose
    assert motion.linear == motion.angular == (0.0, 0.0, 0.0)


def test_a_body_falls_by_half_g_t_squared(open_world, parts, advance):
    world = open_world(parts.prop("ball", Sphere(0.1), Pose((0.5, -0.5, 10.0)), mass=2.0))
    advance(world, 1.0)
    motion = world.model_motion("ball")
    # engines integrate semi-implicitly: half a step more than the parabola
    assert motion.pose.position == pytest.approx((0.5, -0.5, 10.0 - 4.9), abs=0.011)
    assert motion.linear == pytest.approx((0.0, 0.0, -9.8), abs=1e-3)


def test_gravity_is_that_of_the_scene(open_world, parts, advance):
    ball = parts.prop("ball", Sphere(0.1), mass=2.0)
    world = open_world(Scene((ball,), gravity=(1.0, 0.0, 0.0)))
    advance(world, 0.5)
    assert world.model_motion("ball").linear == pytest.approx((0.5, 0.0, 0.0), abs=1e-6)


def test_a_box_rests_on_the_floor(open_world, parts, advance):
    world = open_world(parts.floor(), parts.prop("box", Box((0.2, 0.2, 0.2)), Pose((0, 0, 0.12)), mass=5.0))
    advance(world, 2.0)
    motion = world.model_motion("box")
    assert motion.pose.position == pytest.approx((0, 0, 0.1), abs=2e-3)
    assert np.linalg.norm(motion.linear) < 1e-3


def test_a_tower_of_boxes_stands(open_world, parts, advance):
    boxes = [
        parts.prop(f"box{i}", Box((0.2, 0.2, 0.2)), Pose((0, 0, 0.1 + 0.2 * i)), mass=1.0) for i in range(3)
    ]
    world = open_world(parts.floor(), *boxes)
    advance(world, 2.0)
    assert world.model_motion("box2").pose.position == pytest.approx((0, 0, 0.5), abs=5e-3)


@pytest.mark.parametrize(("floor", "box"), [(1.0, 0.3), (0.3, 1.0)])
def test_a_sliding_box_is_braked_by_the_more_slippery_surface(open_world, parts, advance, floor, box):
    angle = radians(30)
    slope = Pose.from_rpy((0, 0, 0), 0, angle, 0)  # down along x
    plane = parts.prop("slope", Box((20, 20, 1)), slope @ Pose((0, 0, -0.5)), friction=floor)
    slider = parts.prop("slider", Box((0.4, 0.4, 0.2)), slope @ Pose((0, 0, 0.1)), mass=3.0, friction=box)
    world = open_world(plane, slider)
    advance(world, 1.0)
    speed = np.linalg.norm(world.model_motion("slider").linear)
    assert speed == pytest.approx(9.8 * (sin(angle) - 0.3 * cos(angle)), rel=0.03)


def test_a_pendulum_swings_with_its_period(open_world, parts):
    world = open_world(parts.hanging("continuous", (0, 1, 0), com=(0.05, 0, -0.5)))
    moment = 0.02 + 2.0 * (0.5**2 + 0.05**2)
    period = 2 * pi * sqrt(moment / (2.0 * 9.8 * sqrt(0.5**2 + 0.05**2)))
    turns = []  # times at which the bob turns round
    before = 0.0
    for step in range(1, 2001):
        world.run_until(step * 2_000_000)
        velocity = float(world.joint_states("hanging").velocities[0])
        if before * velocity < 0:
            turns.append(world.now_ns / 1e9)
        before = velocity
    assert (turns[4] - turns[0]) / 2 == pytest.approx(period, rel=0.01)
    assert len(turns) == 5


def test_a_joint_turns_by_the_right_hand_about_its_axis(open_world, parts, advance):
    world = open_world(parts.hanging("continuous", (0, 1, 0), com=(0.5, 0, 0), damping=5.0))
    advance(
        world, 0.1
    )  # the bob, ahead of the joint, begins to fall: x towards -z is a positive turn about y
    angle = float(world.joint_states("hanging").positions[0])
    motion = world.model_motion("hanging")
    assert angle > 0.01
    assert motion.pose.rpy[1] == pytest.approx(angle, rel=1e-6)
    assert motion.angular[1] == pytest.approx(float(world.joint_states("hanging").velocities[0]), rel=1e-6)
    assert motion.pose.position == pytest.approx((0, 0, 2), abs=1e-9)
    assert motion.linear == pytest.approx((0, 0, 0), abs=1e-9)


@pytest.mark.parametrize("damping", [4.0, 400.0, 40_000.0])
def test_damping_brakes_a_joint_exponentially(open_world, parts, advance, damping):
    hanging = parts.hanging("prismatic", (1, 0, 0), com=(0, 0, 0), damping=damping)
    world = open_world(Scene((hanging,), gravity=(9.8, 0, 0)))
    advance(world, 4.0)
    assert world.joint_states("hanging").velocities == pytest.approx([2.0 * 9.8 / damping], rel=1e-3)


@pytest.mark.parametrize(("gravity", "limit"), [((0, 0, -9.8), 0.4), ((0, 0, 9.8), -0.5)])
def test_a_revolute_joint_stops_at_its_limits(open_world, parts, advance, gravity, limit):
    hanging = parts.hanging("revolute", (0, 1, 0), lower=-0.5, upper=0.4, com=(0.5, 0, 0))
    world = open_world(Scene((hanging,), gravity=gravity))
    advance(world, 3.0)
    assert world.joint_states("hanging").positions == pytest.approx([limit], abs=0.02)


@pytest.mark.parametrize(("gravity", "limit"), [((9.8, 0, 0), 0.2), ((-9.8, 0, 0), -0.1)])
def test_a_prismatic_joint_stops_at_its_limits(open_world, parts, advance, gravity, limit):
    hanging = parts.hanging("prismatic", (1, 0, 0), lower=-0.1, upper=0.2)
    world = open_world(Scene((hanging,), gravity=gravity))
    advance(world, 3.0)
    assert world.joint_states("hanging").positions == pytest.approx([limit], abs=0.01)
    assert world.model_motion("hanging").pose.position == pytest.approx((limit, 0, 2), abs=0.01)


def test_joints_come_in_the_order_of_the_file(open_world, parts):
    world = open_world(parts.floor(), parts.husky())
    names = ("back_left", "back_right", "front_left", "front_right")
    assert world.joint_states("husky").names == names
    assert world.joint_states("floor").names == ()


def test_a_chain_of_joints_and_fixed_links_hangs_together(open_world, advance):
    def bar(name: str, x: float) -> Link:
        inertial = Inertial(1.0, Pose((0.25, 0, 0)), (0.01, 0.02, 0.02, 0, 0, 0))
        return Link(name, Pose((x, 0, 0)), inertial)

    model = Model(
        "arm",
        (bar("upper", 0.0), bar("lower", 0.5), bar("tip", 1.0)),
        (
            Joint("shoulder", "continuous", "world", "upper", Pose(), (0, 1, 0), damping=3.0),
            Joint("elbow", "continuous", "upper", "lower", Pose((0.5, 0, 0)), (0, 1, 0), damping=3.0),
            Joint("glue", "fixed", "lower", "tip", Pose((1.0, 0, 0))),
        ),
        pose=Pose((0, 0, 3)),
    )
    world = open_world(model)
    advance(world, 12.0)  # it comes to hang straight down
    assert world.joint_states("arm").positions == pytest.approx([pi / 2, 0.0], abs=0.02)


@pytest.mark.parametrize(
    "with_tail", [True, False]
)  # its mass lies beside that of the body that it is part of
def test_links_are_read_and_pushed_together_as_one_by_one(open_world, advance, with_tail):
    def bar(name: str, x: float) -> Link:
        place = Pose.from_rpy((x, 0.1, 0), 0.3, x, 0.2)
        return Link(name, place, Inertial(1.0, Pose((0.25, 0.1, 0)), (0.01, 0.02, 0.02, 0, 0, 0)))

    names = ("head", "middle", *(["tail"] if with_tail else []))
    model = Model(
        "worm",
        tuple(bar(name, 0.5 * number) for number, name in enumerate(names)),
        (
            Joint("neck", "revolute", "head", "middle", Pose((0.5, 0, 0)), (0.6, 0, 0.8)),
            *([Joint("glue", "fixed", "middle", "tail", Pose((1.0, 0, 0)))] if with_tail else []),
        ),
    )
    rows = np.arange(6.0 * len(names)).reshape(-1, 6) / 10 - 0.5
    found = []
    for together in (True, False):
        world = open_world(model)
        engine = world.engine
        for step in range(5):
            engine.set_wrench("worm", "middle", Wrench((0.1, 0.2, step / 3), (0.3, 0.0, 0.1)), "another")
            if together:
                engine.set_wrenches("worm", names, rows, "one")
            else:
                for name, row in zip(names, rows.tolist(), strict=True):
                    engine.set_wrench("worm", name, Wrench(tuple(row[:3]), tuple(row[3:])), "one")
            advance(world, 0.02)
        found.append([engine.link_motion("worm", name) for name in names])
        moved = engine.link_motions("worm", names)
        np.testing.assert_array_equal(moved.positions, [each.pose.position for each in found[-1]])
        np.testing.assert_array_equal(moved.orientations, [each.pose.orientation for each in found[-1]])
        np.testing.assert_array_equal(moved.velocities, [(each.linear, each.angular) for each in found[-1]])
    assert found[0] == found[1]


def test_a_spinning_body_keeps_its_angular_velocity_in_the_world(open_world, parts, driver):
    world = open_world(parts.floor(), parts.husky(pose=Pose.from_rpy((0, 0, parts.standing), 0, 0, 2.0)))
    driver(world).drive(0.5, 1.0, 0.3)
    motion = world.model_motion("husky")
    assert motion.angular == pytest.approx((0, 0, 1.0), abs=1e-3)
    assert motion.linear[:2] == pytest.approx(
        (0.5 * cos(motion.pose.yaw), 0.5 * sin(motion.pose.yaw)), abs=1e-3
    )


def test_on_a_slope_the_robot_stands_still_and_turns_about_its_own_axis(open_world, parts, driver):
    tilt = Pose.from_rpy((0, 0, 0), 0, radians(15), 0)
    slope = parts.prop("slope", Box((20, 20, 1)), tilt @ Pose((0, 0, -0.5)))
    world = open_world(slope, parts.husky(pose=tilt @ Pose((0, 0, parts.standing))))
    robot = driver(world)
    start = robot.drive(0.0, 0.0, 0.5)
    end = robot.drive(0.0, 0.0, 2.0)
    assert np.linalg.norm(np.subtract(end.position, start.position)) < 0.01
    robot.drive(0.0, 1.0, 1.0)
    assert world.model_motion("husky").angular == pytest.approx(tilt.rotate((0, 0, 1)), abs=0.02)


def test_more_shapes_than_an_engine_takes_at_once_all_touch(open_world, parts, advance):
    pegs = tuple(
        Collision(f"peg{i}", Sphere(0.05), Pose((0.2 * (i % 7), 0.2 * (i // 7), -0.1))) for i in range(40)
    )
    comb = Link(
        "link", inertial=Inertial(5.0, Pose((0.6, 0.5, 0)), (0.5, 0.5, 0.5, 0, 0, 0)), collisions=pegs
    )
    world = open_world(parts.floor(), Model("comb", (comb,), pose=Pose((0, 0, 0.16))))
    advance(world, 1.0)
    pose = world.model_motion("comb").pose
    assert pose.position == pytest.approx((0, 0, 0.15), abs=3e-3)
    assert degrees(abs(pose.rpy[0]) + abs(pose.rpy[1])) < 0.3


def test_a_slippery_foot_slides_though_the_rest_of_its_body_would_not(open_world, parts, advance):
    feet = [(x, y, 0.0 if x > 0 else 1.0) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    table = Link(
        "link",
        inertial=Inertial(
            4.0, Pose((0.199, 0, 0)), (0.2, 0.2, 0.2, 0, 0, 0)
        ),  # all weight on the slippery feet
        collisions=tuple(
            Collision(f"foot{i}", Sphere(0.05), Pose((x, y, -0.1)), mu) for i, (x, y, mu) in enumerate(feet)
        ),
    )
    slope = parts.prop("slope", Box((20, 20, 1)), Pose.from_rpy((0, 0, -0.5), 0, radians(10), 0))
    world = open_world(slope, Model("table", (table,), pose=Pose.from_rpy((0, 0, 0.16), 0, radians(10), 0)))
    advance(world, 1.0)
    assert world.model_motion("table").linear[0] > 1.0


def test_parts_of_one_model_pass_through_each_other(open_world, parts, advance):
    balls = tuple(
        Link(name, Pose((x, 0, 0.2)), Inertial(1.0), collisions=(Collision("c", Sphere(0.2)),))
        for name, x in (("one", 0.0), ("two", 0.2))
    )
    world = open_world(parts.floor(), Model("balls", balls))
    advance(world, 0.5)
    assert world.model_motion("balls").pose.position == pytest.approx((0, 0, 0), abs=5e-3)


def test_a_movable_link_without_mass_is_refused(open_world, golden: Golden):
    with golden.raises(SceneError, match="'feather'.*'bird'"):
        open_world(Model("bird", (Link("feather"),)))


def test_a_box_slides_and_turns_on_a_plane_without_rattling(open_world, parts):
    world = open_world(parts.floor(), parts.prop("box", Box((0.4, 0.3, 0.2)), mass=5.0, friction=0.0))
    world.place("box", ModelMotion(Pose((0.0, 0.0, 0.1)), (0.3, 0.1, 0.0), (0.0, 0.0, 0.4)))
    upwards = []
    for step in range(50, 500):
        world.run_until(step * 2_000_000)
        upwards.append(world.model_motion("box").linear[2])
    assert max(map(abs, upwards)) < 1e-3
