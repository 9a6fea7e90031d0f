"""Capability: ball, universal and mimic joints move according to mechanics."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from nrp_core.conformance.world.kit import GRAVITY, WorldKit
from nrp_core.conformance.world.scenes import at
from nrp_core.errors import CapabilityError
from nrp_core.world.messages.geometry_msgs import Quaternion
from nrp_core.world.rigid import Pose, rotation_by
from nrp_core.world.scene.devices import JointController
from nrp_core.world.scene.model import Inertial, Joint, Link, Mimic, Model
from nrp_core.world.world import World

MASS_KG, ARM_M, MOMENT = 2.0, 0.5, 0.02
INERTIA = MOMENT + MASS_KG * ARM_M**2
BOB = Inertial(MASS_KG, Pose((0.0, 0.0, -ARM_M)), (MOMENT, MOMENT, MOMENT, 0.0, 0.0, 0.0))
WHILE_S = 0.2
CARRIER = Inertial(1e-9, inertia=(1e-12, 1e-12, 1e-12, 0.0, 0.0, 0.0))
SIDEWAYS = (0.6, -0.4, 0.0)
"""A gravity, m/s^2, that accelerates a hanging bob towards x and to the right."""


def hanging(*joints: Joint, between: tuple[Link, ...] = ()) -> Model:
    """Return a bob that hangs on joints at height 2."""
    return Model("bob", (Link("bob", inertial=BOB), *between), joints, pose=at(0, 0, 2))


def ball() -> Model:
    """Return a bob that hangs on a ball joint."""
    return hanging(Joint("hip", "ball", "world", "bob"))


def gears() -> Model:
    """Return two masses on rails along x; the second moves back twice as far as the first moves ahead."""
    links = [Link(name, inertial=Inertial(mass)) for name, mass in (("first", 1.0), ("second", 0.1))]
    rails = [Joint(f"{link.name}_rail", "prismatic", "world", link.name, axis=(1, 0, 0)) for link in links]
    rails[1] = replace(rails[1], mimic=Mimic("first_rail", -2.0, 0.05))
    return Model("gears", tuple(links), tuple(rails), pose=at(0, 0, 1))


class JointTests(WorldKit):
    """The motion that joints allow, and the loads that they carry."""

    level = "capability"

    def test_a_light_link_between_two_joints_lets_its_child_turn_about_both(self) -> None:
        """A universal joint: the link between its axes has almost no mass."""
        self.require("dynamics")
        first = Joint("first", "continuous", "world", "cross", axis=(1, 0, 0))
        second = Joint("second", "continuous", "cross", "bob", axis=(0, 1, 0))
        world = self.open(
            hanging(first, second, between=(Link("cross", inertial=CARRIER),)), gravity=SIDEWAYS
        )
        _, rates = self._after_a_while(world, "bob")
        assert rates == pytest.approx({"first": -self._rate(0.4), "second": -self._rate(0.6)}, rel=0.05)

    def test_a_spring_swings_about_its_equilibrium(self) -> None:
        """After half a period its displacement from equilibrium is the opposite of the initial one.

        A first-order method damps a swing of the frequency w like a damping ratio of ``w step / 2``.
        """
        self.require("dynamics")
        stiffness, rest = 50.0, 0.1
        spring = Joint("rail", "prismatic", "world", "bob", axis=(0, 0, 1), stiffness=stiffness, rest=rest)
        world = self.open(hanging(spring))
        frequency = sqrt(stiffness / MASS_KG)
        self.run(world, pi / frequency)
        carries = rest - MASS_KG * GRAVITY / stiffness
        damped = abs(carries) * pi * frequency * self.step_s / 2
        assert world.joint_states("bob").positions == pytest.approx([2 * carries], abs=damped)

    def test_a_ball_joint_turns_about_any_axis(self) -> None:
        self._require_balls()
        world = self.open(ball(), gravity=SIDEWAYS)
        angles, rates = self._after_a_while(world, "bob")
        expected = {"hip_x": -self._rate(0.4), "hip_y": -self._rate(0.6), "hip_z": 0.0}
        assert rates == pytest.approx(expected, rel=0.05, abs=1e-4)
        half_s = world.now_ns * 1e-9 / 2
        assert angles == pytest.approx({name: rate * half_s for name, rate in rates.items()}, abs=2e-3)

    def test_the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child(self) -> None:
        """The bob is first rotated about the vertical, by a fifth of a turn."""
        self._require_balls()
        self.require("changes")
        world = self.open(ball(), gravity=SIDEWAYS)
        world.set_joints("bob", {"hip_z": 0.4 * pi})
        states = world.joint_states("bob")
        angles = dict(zip(states.names, states.positions.tolist(), strict=True))
        assert angles == pytest.approx({"hip_x": 0.0, "hip_y": 0.0, "hip_z": 0.4 * pi}, abs=1e-6)
        _, rates = self._after_a_while(world, "bob")
        motion = world.model_motion("bob")
        assert motion.angular == pytest.approx((-self._rate(0.4), -self._rate(0.6), 0.0), rel=0.03, abs=1e-3)
        along = zip(("hip_x", "hip_y", "hip_z"), motion.pose.rotate_back(motion.angular), strict=True)
        assert rates == pytest.approx(dict(along), abs=1e-6)

    def test_a_ball_joint_follows_orientations(self) -> None:
        """It is there within half a second, and held there: the torque is that of gravity."""
        self._require_balls()
        self.require("ball_control")
        turn = (0.8, -0.6, 0.5)
        led = replace(ball(), controllers=(JointController("hip", "position", "/bob/hip", None),))
        world = self.open(led)
        world.advertise("/bob/hip").publish(Quaternion(*rotation_by(turn)))
        angles, _ = self._after_a_while(world, "bob", 0.5)
        assert list(angles.values()) == pytest.approx(turn, abs=0.01)
        self.run(world, 0.5)
        assert world.joint_states("bob").positions == pytest.approx(turn, abs=1e-3)
        centre = BOB.pose.position
        down = Pose(orientation=rotation_by(turn)).rotate_back((0.0, 0.0, -GRAVITY * MASS_KG))
        held = -np.cross(centre, down)
        assert world.joint_states("bob").efforts == pytest.approx(held, rel=0.02, abs=0.02)

    def test_a_mimic_joint_follows_its_leader(self) -> None:
        """By the law of the lever, the first mass carries four times the second one."""
        self._require_coupled()
        pull = 1.4
        world = self.open(gears(), gravity=(pull, 0.0, 0.0))
        places, rates = self._after_a_while(world, "gears", 0.5)
        t_s = world.now_ns * 1e-9
        assert rates["first_rail"] == pytest.approx(pull * (1.0 - 2 * 0.1) / (1.0 + 4 * 0.1) * t_s, rel=0.05)
        assert rates["second_rail"] == pytest.approx(-2 * rates["first_rail"], rel=0.02)
        assert places["second_rail"] == pytest.approx(0.05 - 2 * places["first_rail"], abs=2e-3)

    def test_undeclared_ball_joints_are_refused(self) -> None:
        self.require("dynamics")
        if self.capabilities.ball_joints:
            assert set(self.open(ball()).joint_states("bob").names) == {"hip_x", "hip_y", "hip_z"}
            return
        with pytest.raises(CapabilityError, match="bob/hip"):
            self.open(ball())

    def test_undeclared_mimic_joints_are_refused(self) -> None:
        self.require("dynamics")
        if self.capabilities.coupled_joints:
            assert self.open(gears()).capabilities.coupled_joints
            return
        with pytest.raises(CapabilityError, match="gears/second_rail"):
            self.open(gears())

    def _after_a_while(
        self, world: World, model: str, t_s: float = WHILE_S
    ) -> tuple[dict[str, float], dict[str, float]]:
        """Return the positions and velocities of a model's joints at a time, by name."""
        self.run(world, t_s)
        states = world.joint_states(model)
        positions, velocities = (
            dict(zip(states.names, values.tolist(), strict=True))
            for values in (states.positions, states.velocities)
        )
        return positions, velocities

    def _rate(self, pull: float) -> float:
        """Return the bob's angular velocity after ``WHILE_S`` of the acceleration ``pull``, rad/s."""
        return MASS_KG * pull * ARM_M / INERTIA * self.grid_ns(WHILE_S) * 1e-9

    def _require_balls(self) -> None:
        self.require("dynamics")
        self.require("ball_joints")

    def _require_coupled(self) -> None:
        self.require("dynamics")
        self.require("coupled_joints")
