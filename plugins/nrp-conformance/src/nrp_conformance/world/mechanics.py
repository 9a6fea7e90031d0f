"""Accuracy: forces, servos, joints and shapes against closed forms.

A first-order method with the declared step may displace a motion by two steps. Bodies in contact, and joints
at a limit, may give way by a hundredth of their size. Effort and friction have a precision of a hundredth.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest

from nrp_conformance.world.capability import ARM_KG, ARM_M, INERTIA, arm
from nrp_conformance.world.kit import GRAVITY, WorldKit, at, floor, pendulum, prop, robot, rubbing
from nrp_conformance.world.motion import PENETRATION
from nrp_core.clock import seconds
from nrp_core.messages.base import Duration
from nrp_core.messages.geometry_msgs import Vector3, Wrench
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.world import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    JointController,
    Link,
    Model,
    Pid,
    Sphere,
    World,
)

PRECISION = 0.01
"""The allowed relative error of an effort or a friction."""
WEIGHTLESS: Vector = (0.0, 0.0, 0.0)
HALF_SIZE = 0.3
SHAPES = [Box((0.6, 0.6, 0.6)), Cylinder(0.1, 0.6), Capsule(0.2, 0.2), Sphere(HALF_SIZE)]
"""Shapes whose lowest point is :data:`HALF_SIZE` below their centre."""


class MechanicsTests(WorldKit):
    """Mechanics with a closed-form solution."""

    level = "accuracy"

    @pytest.mark.parametrize("geometry", SHAPES)
    def test_a_shape_has_its_exact_size(self, geometry: Geometry) -> None:
        """The body is lowered along a rail until it touches the ground."""
        self.require("dynamics")
        link = Link("link", inertial=Inertial(1.0), collisions=(Collision("shape", geometry),))
        rail = Joint("rail", "prismatic", "world", "link", axis=(0.0, 0.0, 1.0), damping=20.0)
        world = self.open(floor(), Model("lift", (link,), (rail,), pose=at(0, 0, HALF_SIZE + 0.05)))
        self.run(world, 1.5)
        lowered = float(world.joint_states("lift").positions[0])
        assert lowered == pytest.approx(-0.05, abs=PENETRATION * HALF_SIZE)

    def test_a_link_stands_on_any_of_its_shapes(self) -> None:
        """The second shape of a link is its lowest one."""
        self.require("dynamics")
        shapes = Collision("small", Sphere(0.05)), Collision("large", Box((0.2, 0.2, 2 * HALF_SIZE)))
        rail = Joint("rail", "prismatic", "world", "link", axis=(0.0, 0.0, 1.0), damping=20.0)
        link = Link("link", inertial=Inertial(1.0), collisions=shapes)
        world = self.open(floor(), Model("lift", (link,), (rail,), pose=at(0, 0, HALF_SIZE + 0.05)))
        self.run(world, 1.5)
        lowered = float(world.joint_states("lift").positions[0])
        assert lowered == pytest.approx(-0.05, abs=PENETRATION * HALF_SIZE)

    def test_a_joint_without_limits_counts_its_turns(self) -> None:
        self.require("joint_control")
        world = self._free_arm("effort", Pid())
        world.advertise("/arm/cmd").publish(Float64(0.5))
        self.run(world, 5.0)
        t_s, acceleration = seconds(world.now_ns), 0.5 / INERTIA
        angle = acceleration * t_s * t_s / 2
        assert angle > 2 * pi
        allowed = acceleration * t_s * 2 * self.step_s + PRECISION * angle
        assert world.joint_states("arm").positions[0] == pytest.approx(angle, abs=allowed)

    def test_a_sliding_body_is_slowed_by_the_friction_of_its_shape(self) -> None:
        self.require("dynamics")
        box = rubbing(prop("box", Box((0.6, 0.6, 0.1)), at(0, 0, 0.05), mass=1.0), 0.3)
        pull = 0.4 * GRAVITY
        world = self.open(rubbing(floor(), 1.0), box, gravity=(pull, 0.0, -GRAVITY))
        self.run(world, 1.0)
        braking, t_s = 0.3 * GRAVITY, seconds(world.now_ns)
        allowed = 2 * self.step_s * pull + PRECISION * braking * t_s
        assert world.model_motion("box").linear[0] == pytest.approx((pull - braking) * t_s, abs=allowed)

    def test_a_robot_falls_like_everything_else(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), replace(robot(), pose=at(0, 0, 1.0)))
        self.run(world, 0.3)
        t_s = seconds(world.now_ns)
        fallen = 1.0 - GRAVITY * t_s * t_s / 2
        height = world.model_motion("robot").pose.position[2]
        assert height == pytest.approx(fallen, abs=GRAVITY * t_s * self.step_s)

    @pytest.mark.parametrize(("effort", "limit"), [(0.5, 0.6), (-0.5, -0.5)])
    def test_a_joint_stops_at_its_limit(self, effort: float, limit: float) -> None:
        self.require("joint_control")
        model = pendulum()
        control = JointController("joint", "effort", "/cmd", Pid())
        world = self.open(replace(model, controllers=(control,)), gravity=WEIGHTLESS)
        world.advertise("/cmd").publish(Float64(effort))
        self.run(world, 6.0)
        assert world.joint_states("pendulum").positions == pytest.approx([limit], rel=PRECISION)

    def test_a_joint_turns_once_its_friction_is_overcome(self) -> None:
        self.require("joint_control")
        for effort, moving in ((0.4, 0.0), (0.8, 0.3)):
            world = self._free_arm("effort", Pid(), friction=0.5)
            world.advertise("/arm/cmd").publish(Float64(effort))
            self.run(world, 1.0)
            expected = moving * seconds(world.now_ns) / INERTIA
            allowed = 2 * self.step_s * effort / INERTIA + PRECISION * effort / INERTIA
            assert world.joint_states("arm").velocities[0] == pytest.approx(expected, abs=allowed)

    def test_a_velocity_servo_reaches_its_velocity_by_its_gain(self) -> None:
        self.require("joint_control")
        world = self._free_arm("velocity", Pid(2.0))
        world.advertise("/arm/cmd").publish(Float64(-0.8))
        rate = 2.0 / INERTIA
        for t_s in (0.25, 4.0):
            self.run(world, t_s)
            expected = -0.8 * (1 - exp(-rate * seconds(world.now_ns)))
            allowed = 0.8 * rate * 2 * self.step_s * exp(-rate * t_s) + 0.8 * 1e-3
            assert world.joint_states("arm").velocities[0] == pytest.approx(expected, abs=allowed)

    def test_a_position_servo_swings_by_its_gains(self) -> None:
        """An underdamped oscillator under a step of its target."""
        self.require("joint_control")
        p, d, target = 5.0, 1.0, 0.4
        world = self._free_arm("position", Pid(p, 0.0, d))
        world.advertise("/arm/cmd").publish(Float64(target))
        frequency = sqrt(p / INERTIA)
        decay = d / INERTIA / 2
        swing = sqrt(frequency**2 - decay**2)
        for t_s in (0.6, pi / swing, 1.8):
            self.run(world, t_s)
            now = seconds(world.now_ns)
            remaining = exp(-decay * now) * (cos(swing * now) + decay / swing * sin(swing * now))
            allowed = 2 * self.step_s * target * frequency
            found = float(world.joint_states("arm").positions[0])
            assert found == pytest.approx(target * (1 - remaining), abs=allowed)

    def test_a_position_servo_sags_by_load_over_gain(self) -> None:
        self.require("joint_control")
        world = self.open(arm())
        world.advertise("/arm/cmd").publish(Float64(-0.4))
        self.run(world, 3.0)
        expected = -0.4
        for _ in range(20):  # the load depends on the angle
            expected = -0.4 + ARM_KG * GRAVITY * ARM_M * cos(expected) / 200.0
        assert float(world.joint_states("arm").positions[0]) == pytest.approx(expected, abs=1e-4)

    def test_a_servo_obeys_the_effort_limit_of_its_joint(self) -> None:
        self.require("joint_control")
        world = self._free_arm("position", Pid(200.0, 0.0, 0.0), effort=0.5)
        world.advertise("/arm/cmd").publish(Float64(50.0))
        self.run(world, 1.0)
        self._check_velocity(world, 0.5)

    def test_an_effort_on_a_joint_accelerates_it_by_effort_over_inertia(self) -> None:
        self.require("joint_control")
        world = self._free_arm("effort", Pid())
        world.call("/gazebo/apply_joint_effort", "arm::joint", effort=-0.5, duration=Duration(5))
        self.run(world, 1.0)
        self._check_velocity(world, -0.5)

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_inertia_has_its_principal_axes_where_the_file_puts_them(self, axis: int) -> None:
        """The moments of a link, given about axes that are rotated against those of the link."""
        self.require("joint_control")
        turn = np.array([[cos(0.6), -sin(0.6), 0.0], [sin(0.6), cos(0.6), 0.0], [0.0, 0.0, 1.0]])
        moments = np.array([[0.2, 0.05, 0.0], [0.05, 0.4, 0.0], [0.0, 0.0, 0.3]])
        own = Inertial(2.0, Pose.from_rpy((0.0, 0.0, 0.0), 0.0, 0.0, 0.6), (0.2, 0.4, 0.3, 0.05, 0.0, 0.0))
        model = prop("box", Box((0.2, 0.2, 0.2)), at(0, 0, 5), mass=2.0)
        world = self.open(replace(model, links=(replace(model.links[0], inertial=own),)), gravity=WEIGHTLESS)
        torque = 0.02 * np.eye(3)[axis]  # so small that what turns does not wobble
        wrench = Wrench(torque=Vector3(*torque.tolist()))
        world.call("/gazebo/apply_body_wrench", "box::link", wrench=wrench, duration=Duration(5))
        self.run(world, 0.5)
        t_s = seconds(world.now_ns)
        expected = np.linalg.solve(turn @ moments @ turn.T, torque) * t_s
        allowed = float(np.abs(expected).max()) * (PRECISION + 2 * self.step_s / t_s)
        assert world.model_motion("box").angular == pytest.approx(expected.tolist(), abs=allowed)

    def _free_arm(self, kind: str, gains: Pid, **limits: float) -> World:
        """Open an arm that turns freely, without gravity."""
        model = arm(kind)
        joint = replace(model.joints[0], kind="continuous", **limits)  # type: ignore[arg-type]
        controller = replace(model.controllers[0], gains=gains)
        return self.open(replace(model, joints=(joint,), controllers=(controller,)), gravity=WEIGHTLESS)

    def _check_velocity(self, world: World, effort: float) -> None:
        """Check the velocity of an arm under a constant effort since time 0."""
        t_s, acceleration = seconds(world.now_ns), effort / INERTIA
        allowed = abs(acceleration) * (2 * self.step_s + PRECISION * t_s)
        assert world.joint_states("arm").velocities[0] == pytest.approx(acceleration * t_s, abs=allowed)
