"""Capability: declared features and changes at run time work, and others are refused."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import pytest
from pydantic import ValidationError

from nrp_conformance.base import skip_undeclared
from nrp_conformance.world.kit import (
    GRAVITY,
    RED,
    WorldKit,
    at,
    floor,
    pendulum,
    prop,
    robot,
    screen,
    states,
)
from nrp_core.errors import CapabilityError, DivergedError, LifecycleError
from nrp_core.messages.base import Duration
from nrp_core.messages.gazebo_msgs import ModelState
from nrp_core.messages.geometry_msgs import Point, Pose, Quaternion, Twist, Vector3, Wrench
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.rigid import Pose as ScenePose
from nrp_core.scene.rigid import Wrench as Push
from nrp_core.world import Box, Inertial, Joint, JointController, Link, Model, Pid, Sphere, World

ARM_KG, ARM_M = 2.0, 0.5
HALF = sqrt(0.5)
INERTIA = 0.02 + ARM_KG * ARM_M**2


def arm(kind: str = "position") -> Model:
    """Return a pendulum bob on a controlled joint along y at height 2, its mass ahead of the joint."""
    inertial = Inertial(ARM_KG, ScenePose((ARM_M, 0.0, 0.0)), (0.02, 0.02, 0.02, 0.0, 0.0, 0.0))
    joint = Joint("joint", "revolute", "world", "bob", ScenePose(), (0, 1, 0), -2.0, 2.0)
    control = JointController("joint", kind, "/arm/cmd", Pid(200.0, 0.0, 20.0))  # type: ignore[arg-type]
    return Model("arm", (Link("bob", inertial=inertial),), (joint,), pose=at(0, 0, 2), controllers=(control,))


class RuntimeChangeTests(WorldKit):
    """Changes to a running world."""

    level = "capability"

    def test_a_joint_reaches_its_target_except_for_its_sag_or_refuses(self) -> None:
        self.require("dynamics")
        world = self.open(arm())
        command = world.advertise("/arm/cmd")
        if not self.capabilities.joint_control:
            with pytest.raises(CapabilityError):
                command.publish(Float64(-0.4))
            return
        command.publish(Float64(-0.4))
        self.run(world, 3.0)
        angle = float(world.joint_states("arm").positions[0])
        assert angle == pytest.approx(-0.4 + ARM_KG * GRAVITY * ARM_M / 200.0, abs=0.01)

    def test_an_effort_accelerates_a_joint(self) -> None:
        self.require("joint_control")
        world = self.open(arm("effort"), gravity=(0.0, 0.0, 0.0))
        world.advertise("/arm/cmd").publish(Float64(-0.5))
        self.run(world, 0.5)
        states = world.joint_states("arm")
        assert states.velocities[0] == pytest.approx(-0.25 / INERTIA, rel=0.02)
        assert states.efforts[0] == pytest.approx(-0.5, rel=0.01)

    def test_a_snapshot_keeps_joint_commands(self) -> None:
        self.require("joint_control")
        self.require_snapshot()
        self.require_repeatable()
        world, fresh = self.open(arm()), self.open(arm())
        world.advertise("/arm/cmd").publish(Float64(-0.4))
        self.run(world, 0.1)
        snapshot = world.snapshot()
        expected = self._states_later(world)
        world.advertise("/arm/cmd").publish(Float64(0.4))
        self.run(world, 1.0)
        for again in (world, fresh):
            again.restore(snapshot)
            assert self._states_later(again) == expected

    def test_a_snapshot_keeps_forces_and_targets(self) -> None:
        self.require_snapshot()
        world, fresh = self._world_with_forces(), self._world_with_forces(only_opened=True)
        snapshot = world.snapshot()
        expected = self._states_later(world)
        for again in (world, fresh):
            again.restore(snapshot)
            assert self._states_later(again) == expected

    def test_a_reset_ends_forces_and_targets(self) -> None:
        world, fresh = self._world_with_forces(), self._world_with_forces(only_opened=True)
        world.reset()
        assert self._states_later(world) == self._states_later(fresh)

    def _world_with_forces(self, *, only_opened: bool = False) -> World:
        """Return a world with a force on a body, a torque on a joint, and a target of another joint."""
        self.require("joint_control")
        self.require_repeatable()
        ball = prop("ball", Sphere(0.1), at(3, 0, 5), mass=2.0)
        free = replace(arm(), name="free", pose=at(0, 3, 2), controllers=())
        world = self.open(floor(), ball, arm(), free, robot(x=-3.0))
        if only_opened:
            return world
        wrench = Wrench(Vector3(3.0), Vector3(0.0, 0.0, 0.1))
        world.call("/gazebo/apply_body_wrench", "ball::link", wrench=wrench, duration=Duration(5))
        world.call("/gazebo/apply_joint_effort", "free::joint", effort=0.5, duration=Duration(5))
        world.advertise("/arm/cmd").publish(Float64(-0.4))
        self.drive(world, 0.5, 0.3, 0.2)
        return world

    def test_a_push_changes_a_velocity_by_force_times_time_over_mass_or_is_refused(self) -> None:
        self.require("dynamics")
        world = self.open(prop("ball", Sphere(0.1), at(0, 0, 5), mass=2.0), gravity=(0.0, 0.0, 0.0))
        if not self.capabilities.joint_control:
            with pytest.raises(CapabilityError):
                world.engine.set_wrench("ball", "link", Push((1.0, 0.0, 0.0)))
            return
        asked = {"wrench": Wrench(Vector3(0.0, 3.0)), "duration": Duration(0, 400_000_000)}
        world.call("/gazebo/apply_body_wrench", "ball::link", **asked)
        self.run(world, 1.0)
        assert world.model_motion("ball").linear == pytest.approx((0.0, 0.6, 0.0), abs=0.02)

    def test_models_can_be_moved_or_that_is_refused(self) -> None:
        ball = prop("ball", Sphere(0.1), at(0, 2, 5), mass=1.0)
        world = self.open(floor(), robot(), *self.movable(ball))
        turned = Pose(Point(1.0, 2.0, 3.0), Quaternion(0.0, 0.0, HALF, HALF))
        state = ModelState("ball", turned, Twist(Vector3(0.5), Vector3(0.0, 0.0, 1.0)))
        answer = world.call("/gazebo/set_model_state", state)
        assert answer.success == (self.capabilities.changes and self.capabilities.dynamics)
        if answer.success:
            self.run(world, 0.1)
            motion = world.model_motion("ball")
            assert motion.pose.position == pytest.approx((1.05, 2.0, 3.0 - GRAVITY * 0.005), abs=0.02)
            assert motion.pose.rpy == pytest.approx((0.0, 0.0, pi / 2 + 0.1), abs=0.01)
            assert motion.angular == pytest.approx((0.0, 0.0, 1.0), abs=0.01)
            assert world.model_motion("robot").pose.position[:2] == pytest.approx((0, 0), abs=0.01)

    def test_models_can_be_added_and_removed_without_effect_on_others_or_that_is_refused(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), robot(), pendulum())
        self.drive(world, 0.5, 0.2, 0.5)
        before = states(world)
        ball = prop("ball", Sphere(0.2), at(0, 3, 1), mass=1.0)
        if not self.capabilities.changes:
            with pytest.raises(CapabilityError):
                world.spawn(ball)
            return
        angle = float(world.joint_states("pendulum").positions[0])
        world.spawn(ball)
        now = states(world)
        for name, motion in before.items():
            assert now[name].pose.position == pytest.approx(motion.pose.position, abs=1e-6)
            assert now[name].linear == pytest.approx(motion.linear, abs=1e-6)
        assert world.joint_states("pendulum").positions[0] == pytest.approx(angle, abs=1e-6)
        self.run(world, world.now_ns * 1e-9 + 2.0)
        assert world.model_motion("ball").pose.position == pytest.approx((0, 3, 0.2), abs=0.03)
        world.delete("ball")
        assert "ball" not in states(world)
        assert "/ball/link/visual/color" not in world.topics

    def test_a_spawned_robot_drives_and_sees(self) -> None:
        self.require("changes")
        world = self.open(floor())
        world.spawn(robot("late", yaw=pi / 2))
        self.drive(world, 0.5, 0.0, 1.0, robot="late")
        x, y, _ = world.model_motion("late").pose.position
        assert (x, y) == pytest.approx((0.0, 0.5), abs=0.05)
        if self.capabilities.renderers:
            assert self.image_of(world, "late").any()

    def test_a_reset_restores_the_first_scene(self) -> None:
        self.require("dynamics")
        self.require("changes")
        self.require_repeatable()
        models = floor(), robot(), prop("box", Box((0.3, 0.3, 0.3)), at(1, 1, 0.2), mass=1.0)
        world, fresh = self.open(*models), self.open(*models)
        world.delete("box")
        world.spawn(prop("ball", Sphere(0.2), at(0, 3, 1), mass=1.0))
        self.run(world, 0.2)
        world.reset()
        assert self._states_later(world) == self._states_later(fresh)

    def test_a_snapshot_keeps_spawned_models(self) -> None:
        self.require("dynamics")
        self.require("changes")
        self.require_snapshot()
        self.require_repeatable()
        world, fresh = self.open(floor(), robot()), self.open(floor(), robot())
        world.spawn(prop("ball", Sphere(0.2), at(0, 3, 1), mass=1.0))
        self.run(world, 0.2)
        snapshot = world.snapshot()
        expected = self._states_later(world)
        fresh.restore(snapshot)
        assert self._states_later(fresh) == expected

    def _states_later(self, world: World) -> object:
        self.run(world, world.now_ns * 1e-9 + 0.3)
        return states(world)


class CapabilityTests(WorldKit):
    """The declaration of capabilities is correct, in both directions."""

    level = "capability"

    def test_capabilities_are_the_same_at_every_call(self) -> None:
        declared = self.capabilities
        assert self.backend.capabilities(self.chosen) == declared
        assert self.open(floor(), robot()).capabilities == declared
        assert declared.step_ns > 0
        assert len(set(declared.renderers)) == len(declared.renderers)

    def test_undeclared_cameras_are_refused(self) -> None:
        if self.capabilities.renderers:
            assert self.image_of(self.open(floor(), robot(), screen("screen", 0.0, RED))).any()
        else:
            with pytest.raises(CapabilityError):
                self.open(floor(), robot()).engine.render("robot", "eye", "camera")

    def test_undeclared_snapshots_are_refused(self) -> None:
        world = self.open(floor(), robot())
        self.run(world, 0.1)
        if self.capabilities.snapshot:
            assert world.snapshot().t_ns == world.now_ns
        else:
            with pytest.raises(CapabilityError):
                world.snapshot()

    def test_experiments_that_need_gravity_are_refused_without_it(self) -> None:
        ball = prop("ball", Sphere(0.1), at(0, 0, 5), mass=1.0)
        if self.capabilities.dynamics:
            assert self.open(ball).capabilities.dynamics
            return
        with pytest.raises(CapabilityError, match="ball"):
            self.open(ball)
        with pytest.raises(CapabilityError):
            self.open(floor(), robot()).joint_states("robot")

    def test_each_declared_renderer_can_be_chosen(self) -> None:
        self.require_camera()
        if "renderer" not in self.backend.options.model_fields:
            skip_undeclared("a choice of renderers")
        for renderer in self.capabilities.renderers:
            options = self.backend.options.model_validate({**self.options, "renderer": renderer})
            assert self.backend.capabilities(options).renderers[0] == renderer

    def test_unknown_options_are_refused(self) -> None:
        with pytest.raises(ValidationError):
            self.backend.options.model_validate({**self.options, "no_such_option": 1})

    def test_a_world_that_is_not_finite_is_reported_and_a_reset_repairs_it(self) -> None:
        self.require("dynamics")
        ball = prop("ball", Sphere(0.1), at(0, 0, 5), mass=1.0)
        world = self.open(ball, gravity=(0.0, 0.0, float("nan")))
        with pytest.raises(DivergedError):
            self.run(world, 1.0)
        with pytest.raises(LifecycleError):
            self.run(world, 2.0)
        world.reset()
        assert world.model_motion("ball").pose.position == pytest.approx((0, 0, 5))
