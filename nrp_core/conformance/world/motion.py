"""Contract: SI units, x forward, y left, z up, quaternions x, y, z, w; bodies fall, rest and push.

Tolerances: a first-order method with the declared step has an error of ``g t step`` for a freely falling
body; bodies in contact may penetrate by a hundredth of their size.
"""

from __future__ import annotations

from math import pi, sqrt

import pytest

from nrp_core.conformance.world.kit import GRAVITY, WorldKit, states
from nrp_core.conformance.world.scenes import at, floor, pendulum, prop, robot
from nrp_core.world.rigid import Pose, Vector
from nrp_core.world.scene.model import Box, Sphere

HALF = sqrt(0.5)
AXES: list[tuple[Vector, Vector]] = [
    ((pi / 2, 0.0, 0.0), (1, 0, 0)), ((0.0, pi / 2, 0.0), (0, 1, 0)), ((0.0, 0.0, pi / 2), (0, 0, 1)),
]  # fmt: skip


class MotionTests(WorldKit):
    """The motion of bodies."""

    @pytest.mark.parametrize("direction", [(0, 0, -1), (1, 0, 0), (0, -1, 0)])
    def test_a_body_falls_along_gravity_by_half_g_t_squared(self, direction: Vector) -> None:
        self.require("dynamics")
        ball = prop("ball", Sphere(0.1), at(0, 0, 10), mass=1.0)
        world = self.open(ball, gravity=tuple(GRAVITY * d for d in direction))  # type: ignore[arg-type]
        self.run(world, 0.5)
        t = world.now_ns * 1e-9
        motion = world.model_motion("ball")
        fallen = [GRAVITY * t * t / 2 * d for d in direction]
        moved = [p - q for p, q in zip(motion.pose.position, (0, 0, 10), strict=True)]
        assert moved == pytest.approx(fallen, abs=GRAVITY * t * self.step_s)
        speed = [GRAVITY * t * d for d in direction]
        assert motion.linear == pytest.approx(speed, abs=GRAVITY * self.step_s)

    def test_without_gravity_nothing_moves(self) -> None:
        self.require("dynamics")
        world = self.open(prop("ball", Sphere(0.1), at(0, 0, 1), mass=1.0), gravity=(0.0, 0.0, 0.0))
        self.run(world, 0.5)
        assert world.model_motion("ball").pose.position == pytest.approx((0, 0, 1), abs=1e-9)

    def test_a_body_at_rest_stays_at_rest(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), prop("box", Box((0.4, 0.4, 0.4)), at(1, -2, 0.2), mass=5.0))
        self.run(world, 1.0)
        motion = world.model_motion("box")
        assert motion.pose.position == pytest.approx((1, -2, 0.2), abs=4e-3)
        assert motion.linear == pytest.approx((0, 0, 0), abs=0.01)

    def test_a_static_body_does_not_fall(self) -> None:
        self.require("dynamics")
        world = self.open(
            prop("shelf", Box((1, 1, 0.1)), at(0, 0, 3)), prop("b", Sphere(0.1), at(5, 5, 9), mass=1)
        )
        self.run(world, 0.5)
        assert world.model_motion("shelf").pose.position == pytest.approx((0, 0, 3), abs=1e-9)

    @pytest.mark.parametrize(("rpy", "axis"), AXES)
    def test_a_quarter_turn_is_reported_as_x_y_z_w(self, rpy: Vector, axis: Vector) -> None:
        self.require("dynamics")
        turned = prop("box", Box((0.2, 0.3, 0.4)), Pose.from_rpy((0, 0, 5), *rpy), mass=1.0)
        world = self.open(turned, gravity=(0.0, 0.0, 0.0))
        expected = (*(HALF * a for a in axis), HALF)
        for _ in range(2):
            x, y, z, w = world.model_motion("box").pose.orientation
            sign = 1 if w > 0 else -1
            assert (sign * x, sign * y, sign * z, sign * w) == pytest.approx(expected, abs=1e-6)
            self.run(world, 0.02)

    def test_a_rotated_box_has_its_sides_in_the_right_places(self) -> None:
        """A long box, rotated upright, stands on its end: the height of its centre is half its length."""
        self.require("dynamics")
        upright = Pose.from_rpy((0, 0, 0.52), 0.0, pi / 2, 0.0)
        world = self.open(floor(), prop("box", Box((1.0, 0.5, 0.5)), upright, mass=4.0))
        self.run(world, 1.0)
        assert world.model_motion("box").pose.position[2] == pytest.approx(0.5, abs=0.01)

    def test_a_robot_pushes_obstacles(self) -> None:
        self.require("dynamics")
        box = prop("box", Box((0.3, 0.3, 0.3)), at(0.8, 0, 0.15), mass=0.5)
        world = self.open(floor(), robot(), box)
        self.drive(world, 0.5, 0.0, 1.5)
        x, y, _ = world.model_motion("box").pose.position
        robot_x = world.model_motion("robot").pose.position[0]
        assert x - robot_x == pytest.approx(0.55, abs=0.1)
        assert x > 0.95
        assert abs(y) < 0.15

    def test_a_wall_stops_a_robot(self) -> None:
        world = self.open(floor(), robot(), prop("wall", Box((0.2, 6, 2)), at(1.1, 0, 1)))
        self.drive(world, 0.6, 0.0, 2.0)
        assert world.model_motion("wall").pose.position == pytest.approx((1.1, 0, 1), abs=1e-9)
        assert 0.4 < world.model_motion("robot").pose.position[0] < 0.65

    def test_an_object_without_collision_shapes_does_not_stop_a_robot(self) -> None:
        ghost = prop("ghost", Box((0.2, 6, 2)), at(1.1, 0, 1), solid=False)
        world = self.open(floor(), robot(), ghost)
        self.drive(world, 0.6, 0.0, 2.0)
        assert world.model_motion("robot").pose.position[0] > 0.9

    def test_a_joint_turns_by_the_right_hand_about_its_axis_until_its_limit(self) -> None:
        """The mass is ahead of the joint; falling from x to -z is a positive rotation about y."""
        self.require("dynamics")
        world = self.open(pendulum())
        self.run(world, 0.1)
        falling = world.joint_states("pendulum")
        assert float(falling.positions[0]) > 0.01
        assert float(falling.velocities[0]) > 0.1
        pitch = world.model_motion("pendulum").pose.rpy[1]
        assert pitch == pytest.approx(float(falling.positions[0]), abs=1e-6)
        self.run(world, 3.0)
        assert world.joint_states("pendulum").positions == pytest.approx([0.6], abs=0.03)

    def test_distant_bodies_do_not_disturb_each_other(self) -> None:
        self.require("dynamics")
        ball = prop("ball", Sphere(0.2), at(0, 0, 0.5), mass=1.0)
        alone = self.open(floor(), ball)
        together = self.open(floor(), ball, robot("robot", 9.0, 9.0))
        self.run(alone, 0.6)
        self.drive(together, 0.5, 1.0, 0.6)
        expected = alone.model_motion("ball").pose.position
        assert states(together)["ball"].pose.position == pytest.approx(expected, abs=5e-3)
