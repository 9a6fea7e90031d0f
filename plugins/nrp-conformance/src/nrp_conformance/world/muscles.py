"""Capability: muscles pull along straight lines by MuJoCo's curves."""

from __future__ import annotations

from math import cos, hypot, sin

import numpy as np
import pytest

from nrp_conformance.world.kit import WorldKit, at
from nrp_core.errors import CapabilityError
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.rigid import Pose
from nrp_core.world import Inertial, Joint, Link, Model, Muscle, ViaPoint, World
from nrp_core.world.engine_kit.muscles import activation_rate, force_length, force_velocity, passive_force

HEIGHT_M, LEVER_M, MASS_KG, CENTRE_M, MOMENT = 0.3, 0.05, 2.0, 0.15, 0.01
INERTIA = MOMENT + MASS_KG * CENTRE_M**2
MUSCLE = Muscle(
    "muscle", "/limb/muscle/cmd",
    (ViaPoint("world", (0.0, 0.0, HEIGHT_M)), ViaPoint("bone", (LEVER_M, 0.0, 0.0))),
    force=40.0, optimal_length=0.2, slack_length=0.1, activation_s=0.1, deactivation_s=0.2,
    state_topic="/limb/muscle/state",
)  # fmt: skip


def limb() -> Model:
    """Return a bone on a hinge along y, and a muscle from above to it."""
    bone = Inertial(MASS_KG, Pose((CENTRE_M, 0.0, 0.0)), (MOMENT, MOMENT, MOMENT, 0.0, 0.0, 0.0))
    hinge = Joint("hinge", "continuous", "world", "bone", axis=(0.0, 1.0, 0.0))
    return Model("limb", (Link("bone", inertial=bone),), (hinge,), (MUSCLE,), pose=at(0.5, 0.2, 1.0, yaw=0.7))


def length_at(angle: float) -> float:
    """Return the length of the muscle's path, m."""
    return hypot(LEVER_M * cos(angle), HEIGHT_M + LEVER_M * sin(angle))


def tension_at(length: float, velocity: float, activation: float) -> float:
    """Return the tension of the muscle, N."""
    relative = (length - MUSCLE.slack_length) / MUSCLE.optimal_length
    active = force_length(relative, MUSCLE.lmin, MUSCLE.lmax)
    active *= force_velocity(velocity / (MUSCLE.optimal_length * MUSCLE.vmax), MUSCLE.fvmax)
    return MUSCLE.force * (active * activation + passive_force(relative, MUSCLE.lmax, MUSCLE.fpmax))


def activation_after(control: float, t_s: float) -> float:
    """Return the activation after a time of constant control, from 0."""
    activation, step_s = 0.0, 1e-5
    for _ in range(round(t_s / step_s)):
        activation += step_s * activation_rate(
            control, activation, MUSCLE.activation_s, MUSCLE.deactivation_s, MUSCLE.smoothing
        )
    return activation


class MuscleTests(WorldKit):
    """The forces, the states and the activation of muscles."""

    level = "capability"

    def test_a_muscle_pulls_its_limb_with_its_tension(self) -> None:
        world = self._open()
        self._command(world, 1.0)
        self.run(world, 0.05)
        angle = float(world.joint_states("limb").positions[0])
        before = float(world.joint_states("limb").velocities[0])
        tension = self._state(world)[2]
        self.run(world, 0.05 + self.step_s)
        after = float(world.joint_states("limb").velocities[0])
        moment = HEIGHT_M * LEVER_M * cos(angle) / length_at(angle)
        assert (after - before) / self.step_s == pytest.approx(-tension * moment / INERTIA, rel=0.05)

    def test_a_muscle_reports_its_state_by_its_curves(self) -> None:
        """While it shortens, and while it is stretched."""
        world = self._open()
        self._command(world, 0.8)
        signs = set()
        for t_s in (0.05, 0.1, 0.2, 0.4, 0.6):
            self.run(world, t_s)
            states = world.joint_states("limb")
            angle, rate = float(states.positions[0]), float(states.velocities[0])
            length, velocity, tension, activation = self._state(world)
            moment = HEIGHT_M * LEVER_M * cos(angle) / length_at(angle)
            assert length == pytest.approx(length_at(angle), rel=1e-4)
            assert velocity == pytest.approx(moment * rate, rel=1e-3, abs=1e-5)
            assert tension == pytest.approx(tension_at(length, velocity, activation), rel=5e-3, abs=1e-3)
            signs.add(velocity > 0)
        assert signs == {True, False}, "the limb does not swing both ways"

    def test_an_activation_follows_its_control_by_its_time_constants(self) -> None:
        world = self._open()
        self._command(world, 0.6)
        for t_s in (0.04, 0.1):
            self.run(world, t_s)
            reached, tolerance = activation_after(0.6, world.now_ns * 1e-9), self.step_s / MUSCLE.activation_s
            assert self._state(world)[3] == pytest.approx(reached, abs=tolerance / 2)

    def test_a_reset_ends_activations_and_controls(self) -> None:
        world = self._open()
        self._command(world, 1.0)
        self.run(world, 0.1)
        world.reset()
        assert self._state(world)[3] == 0.0
        self.run(world, 0.1)
        assert self._state(world)[3] == 0.0

    def test_undeclared_muscles_are_refused(self) -> None:
        self.require("dynamics")
        if self.capabilities.muscles:
            assert self.open(limb()).capabilities.muscles
            return
        with pytest.raises(CapabilityError, match="muscle"):
            self.open(limb())

    def _open(self) -> World:
        self.require("dynamics")
        self.require("muscles")
        return self.open(limb(), gravity=(0.0, 0.0, 0.0))

    def _command(self, world: World, control: float) -> None:
        world.advertise(MUSCLE.command_topic).publish(Float64(control))

    def _state(self, world: World) -> list[float]:
        """Return length, velocity, tension and activation."""
        stamped = world.subscribe(MUSCLE.state_topic).latest
        assert stamped is not None
        state = stamped.message
        values = np.array([state.length, state.velocity, state.force, state.activation])
        assert np.isfinite(values).all()
        return [float(value) for value in values]
