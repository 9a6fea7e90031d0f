"""What the parts of a scene do with messages: drives, colours, states."""

from __future__ import annotations

from math import cos, inf, pi, sin
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.errors import TopicError
from nrp_core.messages.gazebo_msgs import WheelSpeeds
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.simulation import State

MS = 1_000_000
FORWARD = Twist(Vector3(x=1.0))
GLASS = "/screen/body/glass/color"


def distance(world: Any) -> float:
    """Return how far the robot came along its first heading."""
    return float((world.engine.x - 1) * cos(0.5) + world.engine.y * sin(0.5))


# -- drives


def test_a_delayed_command_acts_at_the_first_step_after_its_delay(open_world: Any) -> None:
    world = open_world(delay_s=0.0305)
    world.run_until(20 * MS)
    message = Twist(Vector3(x=1.0))
    world.advertise("/husky/cmd_vel").publish(message)
    message.linear.x = 7.0
    world.run_until(50 * MS)
    assert world.engine.velocity.forward == 0
    world.run_until(52 * MS)
    assert (world.engine.velocity.forward, distance(world)) == (1, 0)
    world.run_until(1000 * MS)
    assert distance(world) == pytest.approx(0.1), "its time-out counts from its arrival"


def test_a_snapshot_keeps_commands_that_have_not_arrived_and_a_reset_does_not(open_world: Any) -> None:
    world = open_world(delay_s=0.03)
    world.advertise("/husky/cmd_vel").publish(FORWARD)
    world.run_until(20 * MS)
    saved = world.snapshot()
    world.reset()
    world.run_until(200 * MS)
    assert distance(world) == 0
    world.restore(saved)
    world.run_until(200 * MS)
    assert distance(world) == pytest.approx(0.1)


def test_a_command_moves_the_body_and_turns_it(room: Any) -> None:
    room.advertise("/husky/cmd_vel").publish(Twist(Vector3(x=0.5), Vector3(z=-2)))
    assert (room.engine.velocity.forward, room.engine.velocity.left, room.engine.velocity.turn) == (
        0.5,
        0,
        -2,
    )


@pytest.mark.parametrize("until_ms", [100, 102, 1000])
def test_a_command_ends_after_exactly_its_time_out_however_long_one_advance_is(
    room: Any, until_ms: int
) -> None:
    room.run_until(20 * MS)
    room.advertise("/husky/cmd_vel").publish(FORWARD)
    room.run_until((20 + until_ms) * MS)
    assert distance(room) == pytest.approx(0.1)
    assert room.engine.velocity.forward == 0


def test_until_then_it_holds(room: Any) -> None:
    room.advertise("/husky/cmd_vel").publish(FORWARD)
    room.run_until(98 * MS)
    assert room.engine.velocity.forward == 1
    room.run_until(100 * MS)
    assert room.engine.velocity.forward == 0


def test_a_time_out_between_two_steps_is_kept_at_the_next_one(open_world: Any) -> None:
    world = open_world(timeout=0.0503)
    world.advertise("/husky/cmd_vel").publish(FORWARD)
    world.run_until(1000 * MS)
    assert distance(world) == pytest.approx(0.052)


def test_the_time_out_counts_from_the_last_command(room: Any) -> None:
    command = room.advertise("/husky/cmd_vel")
    for k in range(10):
        command.publish(FORWARD)
        room.run_until((k + 1) * 60 * MS)
    room.run_until(2000 * MS)
    assert distance(room) == pytest.approx(9 * 0.06 + 0.1)


def test_a_drive_without_a_time_out_goes_on(open_world: Any) -> None:
    world = open_world(timeout=inf)
    world.advertise("/husky/cmd_vel").publish(FORWARD)
    world.run_until(3000 * MS)
    assert distance(world) == pytest.approx(3)


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(cuts=st.lists(st.integers(0, 100), max_size=6).map(sorted), turn=st.floats(-5, 5))
def test_how_a_run_is_split_changes_nothing_in_where_it_ends(
    open_world: Any, cuts: list[int], turn: float
) -> None:
    worlds = [open_world(), open_world()]
    for world, stops in zip(worlds, ([], cuts), strict=True):
        world.advertise("/husky/cmd_vel").publish(Twist(Vector3(x=1), Vector3(z=turn)))
        for k in [*stops, 100]:
            world.run_until(k * 2 * MS)
    whole, parts = worlds
    assert (whole.engine.x, whole.engine.y, whole.engine.heading) == (
        parts.engine.x,
        parts.engine.y,
        parts.engine.heading,
    )


def test_odometry_starts_at_0_and_moves_in_the_frame_of_the_body(room: Any) -> None:
    odometry = room.subscribe("/husky/odom", depth=100)
    room.advertise("/husky/cmd_vel").publish(Twist(Vector3(x=1), Vector3(z=0.5)))
    room.run_until(50 * MS)
    first, last = odometry.messages[0].message, odometry.messages[-1].message
    assert (first.pose.pose.position.x, first.pose.pose.position.y) == pytest.approx((0, 0))
    assert last.pose.pose.position.x == pytest.approx(0.05, rel=1e-3)
    assert last.pose.pose.orientation.z == pytest.approx(sin(0.025 / 2))
    assert (last.twist.twist.linear.x, last.twist.twist.linear.y) == pytest.approx((1, 0), abs=1e-12)
    assert last.twist.twist.angular.z == pytest.approx(0.5)
    assert (last.header.frame_id, last.child_frame_id) == ("husky/odom", "husky/base_link")


def test_wheel_speeds_are_ground_speeds(room: Any) -> None:
    speeds = room.subscribe("/husky/wheel_speeds", depth=10)
    room.advertise("/husky/cmd_vel").publish(Twist(Vector3(x=1), Vector3(z=2)))
    room.run_until(10 * MS)
    wheels = speeds.latest.message
    assert (wheels.back_left, wheels.front_left) == pytest.approx((0.5, 0.5))
    assert (wheels.back_right, wheels.front_right) == pytest.approx((1.5, 1.5))


@pytest.mark.parametrize(("left", "right"), [((0.5, 0.5), (1.5, 1.5)), ((0.2, 0.8), (1.0, 2.0))])
def test_wheel_speeds_command_what_the_velocity_of_the_body_does(
    room: Any, left: tuple[float, float], right: tuple[float, float]
) -> None:
    message = WheelSpeeds(left[0], right[0], left[1], right[1])
    room.advertise("/husky/wheel_speeds").publish(message)
    room.run_until(10 * MS)
    motion = room.model_motion("husky")
    separation = room.scene.model("husky").drives[0].separation
    assert np.hypot(*motion.linear[:2]) == pytest.approx(1.0)
    assert motion.angular[2] == pytest.approx((1.5 - 0.5) / separation)


# -- states


def test_joint_states_come_in_the_order_of_the_file(room: Any) -> None:
    room.advertise("/husky/cmd_vel").publish(FORWARD)
    states = room.subscribe("/husky/joint_states").latest.message
    assert states.name == ["left_joint", "right_joint"]
    assert states.velocity == pytest.approx([5, 5])


def test_model_states_hold_every_model_with_its_pose_now(room: Any) -> None:
    states = room.subscribe("/gazebo/model_states")
    room.advertise("/husky/cmd_vel").publish(Twist(Vector3(x=1)))
    room.run_until(100 * MS)
    message = states.latest.message
    assert message.name == ["husky", "screen"]
    husky, screen = message.pose
    assert (screen.position.x, screen.position.y) == (0, 2)
    assert husky.position.x == pytest.approx(1 + 0.1 * cos(0.5))
    assert states.latest.t_ns == 100 * MS


# -- colours


def test_a_colour_is_set_and_read_at_once(room: Any) -> None:
    color = room.subscribe(GLASS)
    assert color.latest.message == ColorRGBA(0, 0, 1, 1)
    room.advertise(GLASS).publish(ColorRGBA(1, 0, 0, 1))
    assert color.latest.message == ColorRGBA(1, 0, 0, 1)
    assert room.engine.colors == {"screen/body/glass": (1, 0, 0, 1)}


def test_every_visual_has_a_colour(room: Any) -> None:
    assert {name for name in room.topics if name.endswith("/color")} == {GLASS, "/husky/base_link/deck/color"}


@pytest.mark.parametrize("color", [ColorRGBA(255, 0, 0), ColorRGBA(0, -0.1, 0), ColorRGBA(a=pi)])
def test_a_colour_outside_0_to_1_is_refused_without_side_effects(
    room: Any, color: ColorRGBA, golden: Golden
) -> None:
    with golden.raises(TopicError):
        room.advertise(GLASS).publish(color)
    assert room.state is State.READY
    assert room.subscribe(GLASS).latest.message == ColorRGBA(0, 0, 1, 1)
