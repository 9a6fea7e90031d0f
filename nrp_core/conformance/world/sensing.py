"""Capability: laser, inertial, contact and force sensors agree with geometry and Newton's laws."""

from __future__ import annotations

from dataclasses import replace
from math import cos, inf, pi, sin
from typing import Any

import numpy as np
import pytest

from nrp_core.conformance.world.kit import GRAVITY, WorldKit
from nrp_core.conformance.world.scenes import at, floor, pendulum, prop, robot
from nrp_core.errors import CapabilityError
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import Box, Inertial, Joint, Link, Model, Sphere
from nrp_core.world.sensors.contact import ContactSensor, ForceTorque
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.sensors.navigation import Imu
from nrp_core.world.sensors.sensor import Sensor
from nrp_core.world.world import World

MASS = 2.0
LASER = Laser("laser", "/scan", 50.0, samples=91, angle_min=-pi / 4, angle_max=pi / 4, range_max=9.0)


def carrier(*sensors: Sensor, pose: Pose = at(0, 0, 0.5), size: float = 0.2) -> Model:
    """Return a box that carries sensors."""
    box = Box((size, size, size))
    body = prop("carrier", box, mass=MASS).links[0]
    link = Link("link", Pose(), body.inertial, body.visuals, body.collisions, sensors)
    return Model("carrier", (link,), pose=pose)


class SensingTests(WorldKit):
    """The values of sensors."""

    level = "capability"

    def test_link_poses_are_reported_or_refused(self) -> None:
        self.require("dynamics")
        world = self.open(pendulum())
        self.run(world, 0.3)
        if self.capabilities.links:
            angle = float(world.joint_states("pendulum").positions[0])
            motion = world.link_motion("pendulum", "bob")
            assert motion.pose.position == pytest.approx((0.0, 0.0, 2.0), abs=1e-6)
            ahead = motion.pose.rotate((1.0, 0.0, 0.0))
            assert ahead == pytest.approx((cos(angle), 0.0, -sin(angle)), abs=1e-3)
        else:
            with pytest.raises(CapabilityError):
                world.link_motion("pendulum", "bob")

    @pytest.mark.parametrize("yaw", [0.0, 0.6])
    def test_a_laser_measures_the_distance_to_a_wall(self, yaw: float) -> None:
        self.require("links")
        wall = prop("wall", Box((0.2, 20.0, 2.0)), at(3.1, 0, 1))
        held = replace(carrier(LASER, pose=at(0, 0, 0.5, yaw=yaw)), static=not self.capabilities.dynamics)
        world = self.open(wall, held, gravity=(0.0, 0.0, 0.0))
        ranges = self._sensed(world, "/scan").ranges
        angles = np.linspace(-pi / 4, pi / 4, 91) + yaw
        expected = 3.0 / np.cos(angles)
        expected[expected > LASER.range_max] = inf
        assert ranges == pytest.approx(expected, rel=1e-3)

    def test_a_laser_measures_moving_bodies(self) -> None:
        self.require("dynamics")
        self.require("links")
        ball = prop("ball", Sphere(0.5), at(3, 0, 5), mass=1.0)
        world = self.open(ball, carrier(LASER, pose=at(0, 0, 0.5)), floor())
        assert self._sensed(world, "/scan", 0.02).ranges[45] == inf
        expected = 3 - (0.5**2 - 0.4**2) ** 0.5  # the laser is now 0.4 m below the centre of the ball
        assert self._sensed(world, "/scan", 2.0).ranges[45] == pytest.approx(expected, abs=0.05)

    def test_an_imu_measures_gravity_at_rest_and_nothing_in_free_fall(self) -> None:
        self.require("dynamics")
        self.require("links")
        world = self.open(floor(), carrier(Imu("imu", "/imu", 100.0), pose=at(0, 0, 3)))
        falling = self._sensed(world, "/imu", 0.2).linear_acceleration
        assert (falling.x, falling.y, falling.z) == pytest.approx((0, 0, 0), abs=0.05)
        resting = self._sensed(world, "/imu", 3.0).linear_acceleration
        assert (resting.x, resting.y, resting.z) == pytest.approx((0, 0, GRAVITY), abs=0.1)

    def test_contacts_report_the_weight_or_are_refused(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), carrier(ContactSensor("bumper", "/bumper", 50.0), pose=at(0, 0, 0.1)))
        if not self.capabilities.contacts:
            with pytest.raises(CapabilityError):
                world.engine.touches()
            return
        (state,) = self._sensed(world, "/bumper", 1.0).states
        names = state.collision1_name, state.collision2_name
        assert names == ("carrier::link::collision", "floor::link::collision")
        force = state.total_wrench.force
        assert (force.x, force.y, force.z) == pytest.approx((0.0, 0.0, MASS * GRAVITY), abs=0.3)
        assert all(normal.z == pytest.approx(1.0, abs=0.01) for normal in state.contact_normals)
        places = np.array([(place.x, place.y, place.z) for place in state.contact_positions])
        assert places[:, 2] == pytest.approx(0.0, abs=0.01)
        assert np.abs(places[:, :2]) == pytest.approx(np.full((len(places), 2), 0.1), abs=0.02), "its corners"

    def test_contacts_report_the_forces_on_a_box_on_a_slope(self) -> None:
        """Gravity is tilted; friction holds the box."""
        self.require("dynamics")
        self.require("contacts")
        box = carrier(ContactSensor("bumper", "/bumper", 50.0), pose=at(0, 0, 0.1))
        world = self.open(floor(), box, gravity=(2.0, 0.0, -GRAVITY))
        (state,) = self._sensed(world, "/bumper", 1.0).states
        force = state.total_wrench.force
        weight = MASS * GRAVITY
        assert (force.x, force.y, force.z) == pytest.approx((-2.0 * MASS, 0.0, weight), abs=0.01 * weight)
        assert all(0.0 <= depth <= 0.002 for depth in state.depths), "a hundredth of the box"

    def test_a_body_that_hangs_free_touches_nothing(self) -> None:
        self.require("dynamics")
        self.require("contacts")
        world = self.open(floor(), carrier(ContactSensor("bumper", "/bumper", 50.0), pose=at(0, 0, 5)))
        assert self._sensed(world, "/bumper", 0.1).states == []

    def test_the_load_on_a_joint_is_the_weight_below_it_or_is_refused(self) -> None:
        self.require("dynamics")
        sensor = ForceTorque("load", "/load", 50.0, "wrist")
        moment = (0.01, 0.01, 0.01, 0.0, 0.0, 0.0)
        arm = Link("arm", Pose(), Inertial(1.0, inertia=moment))
        hand = Link("hand", Pose(), Inertial(MASS, Pose((0.2, 0.0, 0.0)), moment), sensors=(sensor,))
        joints = (
            Joint("mount", "prismatic", "world", "arm", Pose(), (1.0, 0.0, 0.0)),
            Joint("wrist", "fixed", "arm", "hand"),
        )
        world = self.open(Model("scale", (arm, hand), joints, pose=at(0, 0, 2)))
        if not self.capabilities.joint_wrenches:
            with pytest.raises(CapabilityError):
                world.engine.joint_wrench("scale", "wrist")
            return
        wrench = self._sensed(world, "/load", 1.0).wrench
        force, torque = wrench.force, wrench.torque
        assert (force.x, force.y, force.z) == pytest.approx((0.0, 0.0, -MASS * GRAVITY), abs=0.1)
        assert (torque.x, torque.y, torque.z) == pytest.approx((0.0, 0.2 * MASS * GRAVITY, 0.0), abs=0.05)

    def test_depth_is_the_distance_along_the_line_of_sight(self) -> None:
        self.require_camera()
        wall = prop("wall", Box((0.2, 8.0, 6.0)), at(3.1, 0, 1))
        world = self.open(wall, robot())
        try:
            depth = world.engine.depth("robot", "eye", "camera")
        except CapabilityError:
            return  # a renderer may draw colours only
        assert depth[depth.shape[0] // 2] == pytest.approx(np.full(depth.shape[1], 3.0), abs=0.02)

    def _sensed(self, world: World, topic: str, for_s: float = 0.02) -> Any:
        heard = world.subscribe(topic)
        self.run(world, world.now_ns * 1e-9 + for_s)
        assert heard.latest is not None
        world.unsubscribe(heard)
        return heard.latest.message
