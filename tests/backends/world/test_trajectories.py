"""Joints that follow trajectories, on both engines, against closed forms."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import TopicError
from nrp_core.messages.base import Duration, Time
from nrp_core.messages.std_msgs import Float64, Header
from nrp_core.messages.trajectory_msgs import JointTrajectory, JointTrajectoryPoint
from nrp_core.scene.devices import JointController, Pid, TrajectoryController
from nrp_core.scene.model import Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose

NAMES = ("turn", "lift")
COMMAND, STATE = "/arm/arm_controller/command", "/arm/arm_controller/state"
CLOSE = 5e-3  # a joint lags its acceleration times the square of its time constant, 0.04 s


def arm(*, turn: str = "revolute", **options) -> Model:
    """Return an arm that turns about z and is drawn in and out, both across gravity."""
    links = [
        Link(name, inertial=Inertial(1.0, Pose((0.3, 0.0, 0.0)), (0.02, 0.02, 0.02, 0.0, 0.0, 0.0)))
        for name in ("upper", "hand")
    ]
    joints = (
        Joint("turn", turn, "world", "upper", lower=-7.0, upper=7.0),
        Joint("lift", "prismatic", "upper", "hand", axis=(1.0, 0.0, 0.0)),
    )
    return Model(
        "arm",
        tuple(links),
        joints,
        pose=Pose((0.0, 0.0, 1.0)),
        controllers=(JointController("turn", "position", "/arm/turn/cmd_pos", None),),
        trajectory_controllers=(
            TrajectoryController("arm_controller", COMMAND, NAMES, state_topic=STATE, **options),
        ),
        joint_states_topic="/arm/joint_states",
    )


def span(time_s: float, kind: type = Duration):
    return kind(*divmod(round(time_s * 1e9), 10**9))


def trajectory(*points: tuple, joints: tuple[str, ...] = NAMES, stamp_s: float = 0.0) -> JointTrajectory:
    """Return a trajectory of points ``(time_s, positions, velocities, accelerations)``."""
    made = [JointTrajectoryPoint(*values, time_from_start=span(time_s)) for time_s, *values in points]
    return JointTrajectory(Header(span(stamp_s, Time)), list(joints), made)


@pytest.fixture
def world(open_world):
    return open_world(arm())


def send(world, *points, **options) -> None:
    world.advertise(COMMAND).publish(trajectory(*points, **options))


def positions(world) -> np.ndarray:
    return world.joint_states("arm").positions


@pytest.mark.parametrize(
    ("rest", "shape"),
    [
        ((), lambda s: s),
        (([0.0, 0.0],), lambda s: 3 * s**2 - 2 * s**3),
        (([0.0, 0.0], [0.0, 0.0]), lambda s: 10 * s**3 - 15 * s**4 + 6 * s**5),
    ],
    ids=["positions", "and velocities", "and accelerations"],
)
def test_joints_pass_between_points_as_their_polynomials_do(world, advance, rest, shape):
    end = np.array([1.5, -0.4])
    send(world, (2.0, end, *rest))
    for step in range(1, 125):
        advance(world, 0.02)
        expected = shape(min(step * 0.02 / 2.0, 1.0)) * end
        # a line begins and ends with a jerk, which takes the servo some time constants
        near = CLOSE if rest or 10 < step < 99 or step > 115 else 0.02
        assert positions(world) == pytest.approx(expected, abs=near)


def test_points_are_passed_at_their_times_and_the_last_one_is_held(world, advance):
    send(world, (0.5, [0.4, 0.01]), (1.5, [-0.6, 0.03]), (2.5, [0.2, 0.0]))
    for time_s, expected in ((1.0, [-0.1, 0.02]), (2.0, [-0.2, 0.015]), (4.0, [0.2, 0.0])):
        advance(world, time_s - world.now_ns / 1e9)
        assert positions(world) == pytest.approx(expected, abs=CLOSE)


def test_a_newer_trajectory_takes_over_at_its_stamp_and_from_where_the_joints_are_to_be(world, advance):
    send(world, (2.0, [1.0, 0.2], [0.0, 0.0]))
    advance(world, 0.3)
    send(world, (1.0, [0.0, 0.0], [0.0, 0.0]), stamp_s=1.0)
    advance(world, 0.7)
    assert positions(world) == pytest.approx([0.5, 0.1], abs=CLOSE)
    speed = 0.75  # of the first one, where it is left
    advance(world, 0.5)
    assert positions(world)[0] == pytest.approx(0.5 * 0.5 + speed / 8, abs=CLOSE)
    advance(world, 1.0)
    assert positions(world) == pytest.approx([0.0, 0.0], abs=CLOSE)


def test_joints_that_a_newer_one_does_not_name_go_on(world, advance):
    send(world, (1.0, [1.0, 0.3], [0.0, 0.0]))
    advance(world, 0.5)
    send(world, (0.5, [-0.2]), joints=("turn",))
    advance(world, 1.5)
    assert positions(world) == pytest.approx([-0.2, 0.3], abs=CLOSE)


def test_one_without_points_stops_the_joints(world, advance):
    send(world, (1.0, [1.0, 0.2]))
    advance(world, 0.5)
    send(world, joints=())
    advance(world, 1.5)
    assert positions(world) == pytest.approx([0.5, 0.1], abs=CLOSE)


def test_a_point_at_once_is_aimed_at_and_points_of_the_past_are_left_out(world, advance):
    send(world, (0.0, [0.5, 0.1]))
    advance(world, 1.0)
    assert positions(world) == pytest.approx([0.5, 0.1], abs=1e-3)
    send(world, (0.2, [9.0, 9.0]), (1.5, [0.0, 0.0]), stamp_s=0.5)
    advance(world, 0.5)
    assert positions(world) == pytest.approx([0.25, 0.05], abs=CLOSE)


def test_a_new_command_ends_the_trajectory_of_a_joint(world, advance):
    send(world, (1.0, [1.0, 0.3]))
    advance(world, 0.5)
    world.advertise("/arm/turn/cmd_pos").publish(Float64(-0.5))
    advance(world, 1.5)
    assert positions(world) == pytest.approx([-0.5, 0.3], abs=CLOSE)
    send(world, (1.0, [0.5, 0.0]))
    advance(world, 0.5)
    assert positions(world) == pytest.approx([0.0, 0.15], abs=CLOSE)


def test_a_joint_without_limits_turns_in_the_shorter_direction(open_world, advance):
    world = open_world(arm(turn="continuous"))
    send(world, (1.0, [2 * pi - 0.5, 0.0]))
    advance(world, 2.0)
    assert positions(world)[0] == pytest.approx(-0.5, abs=CLOSE)


def test_gains_of_the_file_are_those_of_a_controller_of_positions(open_world, advance):
    follower = {"gains": (("turn", Pid(20.0, 0.0, 4.0)),), "initial": (("turn", 0.3),)}
    world = open_world(arm(**follower))
    advance(world, 0.1)
    joints = world.joint_states("arm")
    wanted = 20.0 * (0.3 - joints.positions[0]) - 4.0 * joints.velocities[0]
    assert joints.efforts[0] == pytest.approx(wanted, abs=0.02)
    advance(world, 3.0)
    assert positions(world)[0] == pytest.approx(0.3, abs=1e-3)


def test_its_state_has_the_desired_and_the_actual_point_and_the_error(world, advance):
    state = world.subscribe(STATE)
    send(world, (2.0, [1.0, 0.2]))
    advance(world, 1.0)
    told = state.latest.message
    assert told.joint_names == list(NAMES)
    assert told.desired.positions == pytest.approx([0.5, 0.1])
    assert told.desired.velocities == pytest.approx([0.5, 0.1])
    assert told.actual.positions == pytest.approx(positions(world))
    assert told.error.positions == pytest.approx(told.desired.positions - told.actual.positions)


@pytest.mark.parametrize(
    ("points", "options"),
    [
        (((1.0, [0.1]),), {"joints": ("trun",)}),
        (((1.0, [0.1]),), {"joints": ("turn", "turn")}),
        (((1.0, [0.1]),), {"joints": ()}),
        (((1.0, [0.1]),), {}),
        (((1.0, []),), {}),
        (((1.0, [0.1, np.nan]),), {}),
        (((1.0, [0.1, 1e300]),), {}),
        (((1.0, [0.1, 0.1], [1.0]),), {}),
        (((1.0, [0.1, 0.1]), (1.0, [0.2, 0.2])), {}),
        (((1e20, [0.1, 0.1]),), {}),
        (((0.2, [0.1, 0.1]),), {"stamp_s": 0.1}),
    ],
)  # fmt: skip
def test_a_trajectory_that_cannot_be_followed_is_refused_without_side_effects(
    world, advance, points, options, golden: Golden
):
    advance(world, 0.5)
    send(world, (0.5, [0.2, 0.1]))
    with golden.raises(TopicError):
        send(world, *points, **options)
    advance(world, 1.0)
    assert positions(world) == pytest.approx([0.2, 0.1], abs=CLOSE)


@pytest.mark.parametrize("junk", [None, 1.0, "x", [None], ["x"], [1.0], {}, np.array([1.0]), Duration("x")])
@pytest.mark.parametrize("field", ["joint_names", "points", "positions", "velocities", "time_from_start"])
def test_a_message_of_anything_else_is_refused_in_words(world, advance, field, junk):
    message = trajectory((1.0, [0.1, 0.1]))
    setattr(message if field in ("joint_names", "points") else message.points[0], field, junk)
    with pytest.raises(TopicError, match=COMMAND):
        world.advertise(COMMAND).publish(message)
    advance(world, 0.02)


def test_a_snapshot_goes_on_and_a_reset_forgets(world, advance):
    send(world, (1.0, [1.0, 0.3], [0.0, 0.0]))
    send(world, (1.0, [-1.0, 0.0], [0.0, 0.0]), stamp_s=0.8)
    advance(world, 0.5)
    middle = world.snapshot()
    advance(world, 2.0)
    end = positions(world)
    world.restore(middle)
    advance(world, 2.0)
    assert np.array_equal(positions(world), end)
    world.reset()
    advance(world, 1.0)
    assert positions(world) == pytest.approx([0.0, 0.0], abs=1e-9)
