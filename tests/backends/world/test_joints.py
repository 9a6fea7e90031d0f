"""Joints under control: positions, velocities, efforts, and pushes from outside."""

from __future__ import annotations

from dataclasses import replace
from math import exp, pi, sin, sqrt

import numpy as np
import pytest

from nrp_core.messages.base import Duration, Time
from nrp_core.messages.geometry_msgs import Point, Vector3, Wrench
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController, Pid
from nrp_core.scene.model import Inertial, Joint, Link, Model, Scene, Sphere
from nrp_core.scene.rigid import Pose

MASS, ARM, MOMENT = 2.0, 0.5, 0.02
INERTIA = MOMENT + MASS * ARM**2
GRAVITY = 9.8


def arm(*controllers: JointController, axis=(0.0, 0.0, 1.0), **limits: float) -> Model:
    """Return a bob at 0.5 m from a joint that is held by the world; along z gravity does not turn it."""
    bob = Link("bob", inertial=Inertial(MASS, Pose((ARM, 0.0, 0.0)), (MOMENT, MOMENT, MOMENT, 0.0, 0.0, 0.0)))
    joint = Joint("hinge", "revolute", "world", "bob", axis=axis, **limits)
    return Model(
        "arm",
        (bob,),
        (joint,),
        pose=Pose((0.0, 0.0, 1.0)),
        controllers=controllers,
        joint_states_topic="/joints",
    )


def controller(kind: str, *gains: float, **options: float) -> JointController:
    return JointController("hinge", kind, f"/arm/hinge/cmd_{kind}", Pid(*gains), **options)


def command(world, kind: str, value: float) -> None:
    world.advertise(f"/arm/hinge/cmd_{kind}").publish(Float64(value))


def turned(world) -> tuple[float, float]:
    joints = world.joint_states("arm")
    return float(joints.positions[0]), float(joints.velocities[0])


def test_a_position_controller_steps_like_a_damped_oscillator(open_world, advance):
    stiffness, damping = 40.0, 2.0
    world = open_world(arm(controller("position", stiffness, 0.0, damping)))
    command(world, "position", 0.8)
    frequency, decay = sqrt(stiffness / INERTIA), damping / 2 / INERTIA
    damped = sqrt(frequency**2 - decay**2)
    for step in range(1, 40):
        advance(world, 0.02)
        t = 0.02 * step
        expected = 0.8 * (1 - exp(-decay * t) * (np.cos(damped * t) + decay / damped * sin(damped * t)))
        # backward Euler damps by a step's worth of stiffness more
        assert turned(world)[0] == pytest.approx(expected, abs=0.03)


def test_under_gravity_a_joint_sags_by_its_load_over_its_stiffness(open_world, advance):
    stiffness = 200.0
    world = open_world(arm(controller("position", stiffness, 0.0, 20.0), axis=(0.0, 1.0, 0.0)))
    command(world, "position", 0.0)
    advance(world, 4.0)
    sag, speed = turned(world)
    assert stiffness * sag == pytest.approx(MASS * GRAVITY * ARM * np.cos(sag), rel=1e-3)
    assert speed == pytest.approx(0.0, abs=1e-5)
    assert world.joint_states("arm").efforts[0] == pytest.approx(-stiffness * sag, rel=1e-3)


def test_an_integral_takes_the_sag_away(open_world, advance):
    world = open_world(arm(controller("position", 200.0, 400.0, 20.0), axis=(0.0, 1.0, 0.0)))
    command(world, "position", 0.3)
    advance(world, 6.0)
    assert turned(world)[0] == pytest.approx(0.3, abs=2e-3)


@pytest.mark.parametrize("stiffness", [1e3, 1e5, 1e7])
def test_any_stiffness_is_stable(open_world, advance, stiffness):
    world = open_world(arm(controller("position", stiffness, 0.0, 1.0), axis=(0.0, 1.0, 0.0)))
    command(world, "position", 0.5)
    advance(world, 3.0)
    position, speed = turned(world)
    assert position == pytest.approx(0.5, abs=2 * MASS * GRAVITY * ARM / stiffness + 2e-3)
    assert abs(speed) < 1e-2


def test_a_velocity_is_reached_with_the_time_constant_of_its_gain(open_world, advance):
    gain = 5.0
    world = open_world(arm(controller("velocity", gain)))
    command(world, "velocity", 2.0)
    for step in range(1, 20):
        advance(world, 0.02)
        assert turned(world)[1] == pytest.approx(2.0 * (1 - exp(-gain / INERTIA * 0.02 * step)), abs=0.02)


def test_an_effort_turns_by_the_law_of_newton(open_world, advance):
    world = open_world(arm(controller("effort")))
    command(world, "effort", 0.7)
    advance(world, 1.0)
    assert turned(world)[1] == pytest.approx(0.7 / INERTIA, rel=2e-3)
    assert world.joint_states("arm").efforts[0] == pytest.approx(0.7)


def test_no_effort_exceeds_the_limit_of_the_joint(open_world, advance):
    world = open_world(arm(controller("position", 1e4, 0.0, 10.0), effort=0.5))
    command(world, "position", 3.0)
    advance(world, 1.0)
    assert turned(world)[1] == pytest.approx(0.5 / INERTIA, rel=0.01)


def test_commands_stay_within_the_limits_of_the_joint(open_world, advance):
    world = open_world(arm(controller("position", 100.0, 0.0, 10.0), lower=-0.4, upper=0.4))
    command(world, "position", 9.0)
    advance(world, 3.0)
    assert turned(world)[0] == pytest.approx(0.4, abs=1e-3)


def test_the_first_command_beyond_the_limits_of_a_joint_is_reported(open_world, advance):
    world = open_world(arm(controller("position", 100.0, 0.0, 10.0), lower=-0.4, upper=0.4))
    for value in (0.4, float(np.float32(0.4)), 9.0, -7.0):  # 32 bits are 6e-9 beyond
        command(world, "position", value)
        advance(world, 0.1)
    beyond = [finding.message for finding in world.warnings if finding.code.name == "NRP299"]
    assert len(beyond) == 1
    assert "is 9, beyond the limit of the joint" in beyond[0]
    assert "0.4 is used" in beyond[0]


def test_a_joint_is_free_until_its_first_command_unless_a_start_is_declared(open_world, advance):
    free, held = (
        open_world(arm(controller("position", 500.0, 0.0, 50.0, initial=initial), axis=(0.0, 1.0, 0.0)))
        for initial in (None, 0.0)
    )
    for world in (free, held):
        advance(world, 0.3)
    assert turned(free)[0] > 0.3
    assert turned(held)[0] < 0.05


@pytest.mark.parametrize("kind", ["position", "velocity", "effort"])
def test_a_controlled_joint_goes_on_from_a_snapshot_as_if_nothing_had_been(
    open_world, advance, require_to_go_on, kind
):
    def open_arm():
        return open_world(arm(controller(kind, 30.0, 20.0, 2.0), axis=(0.0, 1.0, 0.0)))

    world, fresh = open_arm(), open_arm()
    advance(world, 0.1)
    command(world, kind, 0.7)
    advance(world, 0.3)
    require_to_go_on(world, fresh, 0.5, turned)


def test_a_joint_that_falls_on_its_stop_hardly_goes_beyond_it(open_world, advance):
    world = open_world(arm(axis=(0.0, 1.0, 0.0), lower=-1.0, upper=0.5))
    largest = 0.0
    for _ in range(30):
        advance(world, 0.02)
        largest = max(largest, turned(world)[0])
    assert 0.5 - 1e-4 < largest < 0.505  # 27 mrad beyond it with the usual stops of MuJoCo
    assert turned(world)[0] == pytest.approx(0.5, abs=1e-4)


def test_both_engines_turn_a_chain_alike(engines, advance):
    """Three links whose gains are stiff for their inertia, as walkers have them."""
    ends = []
    for backend in engines:
        scene = Scene((chain(),))
        with backend.open(scene, seed=1, options=backend.options()) as world:
            for number in range(3):
                world.advertise(f"/chain/j{number}/cmd_pos").publish(Float64(0.4 * (number - 1)))
            for _ in range(30):
                world.run_until(world.now_ns + 20_000_000)
            ends.append(world.joint_states("chain").positions)
    assert ends[0] == pytest.approx(ends[1], abs=2e-3)
    assert ends[0] == pytest.approx([-0.4, 0.0, 0.4], abs=0.1)


def chain() -> Model:
    links = [
        Link(
            f"l{i}",
            Pose((0.2 * i, 0.0, 0.0)),
            Inertial(0.4, Pose((0.1, 0.0, 0.0)), (1e-4, 1e-3, 1e-3, 0, 0, 0)),
        )
        for i in range(3)
    ]
    joints = [
        Joint(f"j{i}", "revolute", f"l{i - 1}" if i else "world", f"l{i}", links[i].pose, (0.0, 1.0, 0.0))
        for i in range(3)
    ]
    control = [
        JointController(f"j{i}", "position", f"/chain/j{i}/cmd_pos", Pid(50.0, 0.0, 1.0)) for i in range(3)
    ]
    return Model("chain", tuple(links), tuple(joints), pose=Pose((0, 0, 2.0)), controllers=tuple(control))


def test_all_joints_with_one_topic_obey_its_commands(open_world, advance):
    model = chain()
    shared = tuple(replace(each, topic="/servo_0") for each in model.controllers)
    world = open_world(replace(model, controllers=shared))
    world.advertise("/servo_0").publish(Float64(0.2))
    advance(world, 3.0)
    assert world.joint_states("chain").positions == pytest.approx([0.2] * 3, abs=0.1)
    world.call("/gazebo/delete_model", "chain")
    assert "/servo_0" not in world.topics


# -- pushes


def ball(parts, **keys) -> Model:
    return parts.prop("ball", Sphere(0.1), Pose((0.0, 0.0, 5.0)), mass=2.0, **keys)


def free(model: Model) -> Scene:
    return Scene((model,), gravity=(0.0, 0.0, 0.0))


def test_a_push_lasts_as_long_as_it_was_asked_to(open_world, parts, advance):
    world = open_world(free(ball(parts)))
    world.call(
        "/gazebo/apply_body_wrench",
        "ball::link",
        "world",
        Point(),
        Wrench(Vector3(4.0)),
        duration=Duration(0, 500_000_000),
    )
    advance(world, 1.0)
    motion = world.model_motion("ball")
    assert motion.linear == pytest.approx((1.0, 0.0, 0.0), rel=1e-6)
    assert motion.pose.position[0] == pytest.approx(0.25 + 0.5, rel=0.01)


def test_a_push_can_begin_later_and_be_ended_early(open_world, parts, advance):
    world = open_world(free(ball(parts)))
    asked = {"wrench": Wrench(Vector3(4.0)), "start_time": Time(0, 200_000_000), "duration": Duration(-1)}
    assert world.call("/gazebo/apply_body_wrench", "ball::link", **asked).success
    advance(world, 0.4)
    world.call("/gazebo/clear_body_wrenches", "ball::link")
    advance(world, 0.4)
    assert world.model_motion("ball").linear[0] == pytest.approx(0.4, rel=1e-6)


def test_a_torque_turns_about_the_axes_of_the_world(open_world, advance):
    box = Link("link", inertial=Inertial(1.0, Pose((0.1, 0.0, 0.0)), (0.1, 0.2, 0.3, 0.0, 0.0, 0.0)))
    lying = Pose.from_rpy((0.0, 0.0, 1.0), 0.0, pi / 2, 0.0)  # its x axis points down
    world = open_world(free(Model("box", (box,), pose=lying)))
    world.call(
        "/gazebo/apply_body_wrench",
        "box::link",
        wrench=Wrench(torque=Vector3(0.0, 0.0, 0.05)),
        duration=Duration(-1),
    )
    advance(world, 0.2)
    assert world.model_motion("box").angular == pytest.approx((0.0, 0.0, 0.1), abs=1e-3)


def test_a_push_off_the_centre_turns_as_well(open_world, parts, advance):
    world = open_world(free(ball(parts)))
    world.call(
        "/gazebo/apply_body_wrench",
        "ball::link",
        "world",
        Point(0.0, 0.1, 0.0),
        Wrench(Vector3(1.0)),
        duration=Duration(-1),
    )
    advance(world, 0.1)
    motion = world.model_motion("ball")
    assert motion.linear[0] == pytest.approx(0.05, rel=1e-3)
    assert motion.angular[2] == pytest.approx(-0.1 * 0.1 / 0.02, rel=1e-3)


def test_efforts_on_any_joint_add_up_and_end(open_world, advance):
    world = open_world(arm())
    for effort in (0.5, 0.25):
        world.call("/gazebo/apply_joint_effort", "arm::hinge", effort, duration=Duration(0, 400_000_000))
    advance(world, 1.0)
    assert turned(world)[1] == pytest.approx(0.75 * 0.4 / INERTIA, rel=1e-3)


@pytest.mark.parametrize("effort", [0.05, 0.5, -3.0])
def test_efforts_from_outside_stay_within_the_limit_of_the_joint(open_world, advance, effort):
    world = open_world(arm(effort=0.3))
    for share in (effort, 2 * effort):
        world.call("/gazebo/apply_joint_effort", "arm::hinge", share, duration=Duration(-1))
    advance(world, 0.4)
    world.call("/gazebo/clear_joint_forces", "arm::hinge")
    advance(world, 0.4)
    bounded = min(max(3 * effort, -0.3), 0.3)
    assert turned(world)[1] == pytest.approx(bounded * 0.4 / INERTIA, rel=1e-3)


def test_a_push_goes_on_after_a_snapshot(open_world, parts, advance, require_to_go_on):
    def open_ball():
        return open_world(free(ball(parts)))

    world, fresh = open_ball(), open_ball()
    world.call("/gazebo/apply_body_wrench", "ball::link", wrench=Wrench(Vector3(1.0)), duration=Duration(1))
    advance(world, 0.3)
    require_to_go_on(world, fresh, 1.5, lambda each: each.model_motion("ball"))


def test_a_reset_ends_all_pushes(open_world, parts, advance):
    world = open_world(free(ball(parts)))
    world.call("/gazebo/apply_body_wrench", "ball::link", wrench=Wrench(Vector3(1.0)), duration=Duration(-1))
    advance(world, 0.2)
    world.reset()
    advance(world, 0.2)
    assert world.model_motion("ball").linear == (0.0, 0.0, 0.0)


def test_without_gains_a_joint_follows_at_once(open_world, advance):
    control = JointController("hinge", "position", "/arm/hinge/cmd_position", gains=None)
    world = open_world(arm(control))
    command(world, "position", 0.6)
    advance(world, 0.4)
    assert turned(world)[0] == pytest.approx(0.6, abs=0.01)


@pytest.mark.parametrize("kind", ["position", "velocity", "effort"])
def test_a_reset_joint_moves_as_a_fresh_one(open_world, advance, kind):
    def opened():
        return open_world(arm(controller(kind, 30.0, 20.0, 2.0), axis=(0.0, 1.0, 0.0)))

    fresh, world = opened(), opened()
    command(world, kind, 0.7)
    advance(world, 0.3)
    world.reset()
    for each in (fresh, world):
        advance(each, 0.3)
    assert turned(world) == turned(fresh)


def test_a_push_on_a_jointed_link_acts_along_the_axes_of_the_world(open_world, advance):
    lying = replace(arm(), pose=Pose.from_rpy((0.0, 0.0, 1.0), pi / 2, 0.0, 0.7))
    axis = lying.pose.rotate((0.0, 0.0, 1.0))
    for wrench in (Wrench(torque=Vector3(*(0.2 * x for x in axis))), Wrench(Vector3(z=0.4))):
        world = open_world(Scene((lying,), gravity=(0.0, 0.0, 0.0)))
        world.call("/gazebo/apply_body_wrench", "arm::bob", wrench=wrench, duration=Duration(-1))
        advance(world, 0.2)
        # the bob is 0.5 m ahead along the model's x axis, so a force upwards turns it about the hinge
        assert turned(world)[1] == pytest.approx(0.2 * 0.2 / INERTIA, rel=0.01)


@pytest.mark.parametrize("kinds", [("position", "velocity"), ("velocity", "position")], ids="-then-".join)
def test_of_two_controllers_of_a_joint_the_one_commanded_last_is_in_force_after_a_restore(
    open_world, advance, kinds
):
    first, last = kinds
    both = controller("position", 40.0, 0.0, 4.0), controller("velocity", 5.0)
    world = open_world(arm(*both))
    command(world, first, 0.5)
    advance(world, 0.1)
    command(world, last, 0.5)
    advance(world, 0.1)
    snapshot = world.snapshot()
    advance(world, 3.0)
    gone_on = turned(world)
    assert gone_on[("position", "velocity").index(last)] == pytest.approx(0.5, abs=1e-3)
    world.restore(snapshot)
    advance(world, 3.0)
    assert turned(world) == gone_on


def test_a_controller_that_integrates_leaves_the_joint_to_another_that_is_commanded(open_world, advance):
    world = open_world(arm(controller("position", 40.0, 5.0, 4.0, initial=0.0), controller("velocity", 5.0)))
    advance(world, 0.1)
    command(world, "velocity", 0.5)
    advance(world, 3.0)
    assert turned(world)[1] == pytest.approx(0.5, abs=1e-3)


def test_how_a_joint_moved_before_its_servo_rested_does_not_matter(open_world, advance):
    efforts = []
    for before in (0.0, 1e-9):
        falling = arm(controller("effort"), controller("position", 40.0, 0.0, 2.0), axis=(0.0, 1.0, 0.0))
        world = open_world(falling)
        command(world, "effort", before)
        advance(world, 0.02)
        command(world, "effort", 0.0)
        advance(world, 0.18)
        command(world, "position", 0.0)
        world.run_until(world.now_ns + 2_000_000)
        efforts.append(world.joint_states("arm").efforts[0])
    assert efforts[0] == pytest.approx(efforts[1], rel=1e-6)
