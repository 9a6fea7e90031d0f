"""Cameras, lasers, inertial, contact and force sensors against geometry and Newton's laws.

A camera looks along x of its pose, up is up, left is left, and red is the first channel.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, inf, pi, sin
from typing import Any

import numpy as np
import pytest

from nrp_conformance.world.kit import (
    BLUE,
    CAMERA_HEIGHT,
    CAMERA_HZ,
    GRAVITY,
    GREEN,
    GREY,
    RED,
    WIDTH,
    WorldKit,
    at,
    centre,
    floor,
    paint,
    pendulum,
    prop,
    robot,
    screen,
    where,
)
from nrp_core.errors import CapabilityError
from nrp_core.scene.rigid import Pose
from nrp_core.world import (
    Box,
    Camera,
    ContactSensor,
    ForceTorque,
    Imu,
    Inertial,
    Joint,
    Laser,
    Link,
    Model,
    Rgba,
    Sensor,
    Sphere,
    World,
)

MASS = 2.0
LASER = Laser("laser", "/scan", 50.0, samples=91, angle_min=-pi / 4, angle_max=pi / 4, range_max=9.0)
PIXEL = 2.0 / WIDTH
"""The width of a pixel in image coordinates from -1 to 1."""
OFF_EDGE = 0.4
"""The distance of a board's edge from the centre of a pixel, pixels: a field of view of 2 % more is found."""


def carrier(*sensors: Sensor, pose: Pose = at(0, 0, 0.5), size: float = 0.2) -> Model:
    """Return a box that carries sensors."""
    box = Box((size, size, size))
    body = prop("carrier", box, mass=MASS).links[0]
    link = Link("link", Pose(), body.inertial, body.visuals, body.collisions, sensors)
    return Model("carrier", (link,), pose=pose)


class SensorTests(WorldKit):
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
        ranges = self._measured(world, "/scan").ranges
        angles = np.linspace(-pi / 4, pi / 4, 91) + yaw
        expected = 3.0 / np.cos(angles)
        expected[expected > LASER.range_max] = inf
        assert ranges == pytest.approx(expected, rel=1e-3)

    def test_a_laser_measures_moving_bodies(self) -> None:
        self.require("dynamics")
        self.require("links")
        ball = prop("ball", Sphere(0.5), at(3, 0, 5), mass=1.0)
        world = self.open(ball, carrier(LASER, pose=at(0, 0, 0.5)), floor())
        assert self._measured(world, "/scan", 0.02).ranges[45] == inf
        expected = 3 - (0.5**2 - 0.4**2) ** 0.5  # the laser is now 0.4 m below the centre of the ball
        assert self._measured(world, "/scan", 2.0).ranges[45] == pytest.approx(expected, abs=0.05)

    def test_an_imu_measures_gravity_at_rest_and_nothing_in_free_fall(self) -> None:
        self.require("dynamics")
        self.require("links")
        world = self.open(floor(), carrier(Imu("imu", "/imu", 100.0), pose=at(0, 0, 3)))
        falling = self._measured(world, "/imu", 0.2).linear_acceleration
        assert (falling.x, falling.y, falling.z) == pytest.approx((0, 0, 0), abs=0.05)
        resting = self._measured(world, "/imu", 3.0).linear_acceleration
        assert (resting.x, resting.y, resting.z) == pytest.approx((0, 0, GRAVITY), abs=0.1)

    def test_contacts_report_the_weight_or_are_refused(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), carrier(ContactSensor("bumper", "/bumper", 50.0), pose=at(0, 0, 0.1)))
        if not self.capabilities.contacts:
            with pytest.raises(CapabilityError):
                world.engine.touches()
            return
        (state,) = self._measured(world, "/bumper", 1.0).states
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
        (state,) = self._measured(world, "/bumper", 1.0).states
        force = state.total_wrench.force
        weight = MASS * GRAVITY
        assert (force.x, force.y, force.z) == pytest.approx((-2.0 * MASS, 0.0, weight), abs=0.01 * weight)
        assert all(0.0 <= depth <= 0.002 for depth in state.depths), "a hundredth of the box"

    def test_a_body_that_hangs_free_touches_nothing(self) -> None:
        self.require("dynamics")
        self.require("contacts")
        world = self.open(floor(), carrier(ContactSensor("bumper", "/bumper", 50.0), pose=at(0, 0, 5)))
        assert self._measured(world, "/bumper", 0.1).states == []

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
        wrench = self._measured(world, "/load", 1.0).wrench
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

    def _measured(self, world: World, topic: str, for_s: float = 0.02) -> Any:
        subscription = world.subscribe(topic)
        self.run(world, world.now_ns * 1e-9 + for_s)
        assert subscription.latest is not None
        world.unsubscribe(subscription)
        return subscription.latest.message


class CameraTests(WorldKit):
    """Cameras and colours."""

    @pytest.mark.parametrize(("rgba", "channel"), [(RED, 0), (GREEN, 1), (BLUE, 2)])
    def test_channels_are_red_green_blue(self, rgba: Rgba, channel: int) -> None:
        image = self.image_of(self.open(floor(), robot(), screen("screen", 0.0, rgba)))
        assert where(image, channel).any()
        assert not any(where(image, other).any() for other in {0, 1, 2} - {channel})

    def test_left_is_left(self) -> None:
        image = self.image_of(self.open(floor(), robot(), screen("l", 1.5, RED), screen("r", -1.5, BLUE)))
        assert centre(where(image, 0))[1] == pytest.approx(-0.5, abs=3 * PIXEL)
        assert centre(where(image, 2))[1] == pytest.approx(0.5, abs=3 * PIXEL)

    def test_up_is_up(self) -> None:
        low, high = screen("low", -0.8, RED, z=0.3), screen("high", 0.8, GREEN, z=1.6)
        image = self.image_of(self.open(floor(), robot(), low, high))
        assert centre(where(image, 1))[0] < -0.1 < centre(where(image, 0))[0]

    def test_a_camera_looks_along_the_x_axis_of_its_robot(self) -> None:
        """The screen is on the left of the world's x axis; the robot faces it."""
        beside = prop("beside", Box((1.0, 0.1, 1.0)), at(0, 3, CAMERA_HEIGHT), rgba=RED, solid=False)
        image = self.image_of(self.open(floor(), robot(yaw=pi / 2), beside))
        assert centre(where(image, 0)) == pytest.approx((0.0, 0.0), abs=3 * PIXEL)
        assert not where(self.image_of(self.open(floor(), robot(), beside)), 0).any()

    def test_a_camera_that_is_tilted_down_sees_what_is_ahead_further_up(self) -> None:
        ahead = screen("ahead", 0.0, RED)
        level = self.image_of(self.open(floor(), robot(), ahead))
        tilted = self.image_of(self.open(floor(), robot(tilt=0.3), ahead))
        assert centre(where(tilted, 0))[0] < centre(where(level, 0))[0] - 5 * PIXEL

    def test_an_object_has_the_width_given_by_its_distance_and_the_field_of_view(self) -> None:
        """In a 90 degree pinhole camera, 1 m at 2.95 m covers 1/5.9 of the width, and as many rows."""
        mask = where(self.image_of(self.open(floor(), robot(), screen("screen", 0.0, RED))), 0)
        width = mask.shape[1]
        expected = width / (2 * 2.95)
        assert mask.any(axis=0).sum() == pytest.approx(expected, abs=1.5)
        assert mask.any(axis=1).sum() == pytest.approx(expected, abs=1.5)

    @pytest.mark.parametrize("beyond", [-OFF_EDGE, OFF_EDGE])
    def test_edges_are_in_the_pixels_of_a_pinhole(self, beyond: float) -> None:
        """A board just covers a pixel's centre or just does not; the focal length is half the width."""
        height, width, _ = self.image_of(self.open(floor(), robot())).shape
        columns, rows = width * 5 // 12, height // 3
        ahead, across, up = 0.5, columns + 0.5 + beyond, rows + 0.5 + beyond
        metre = ahead / (width / 2)  # of a pixel, at that distance
        board = Box((0.01, 2 * across * metre, 2 * up * metre))
        place = at(ahead + 0.005, 0, CAMERA_HEIGHT)
        mask = where(
            self.image_of(self.open(floor(), robot(), prop("board", board, place, rgba=RED, solid=False))), 0
        )
        seen_across, seen_up = columns + (beyond > 0), rows + (beyond > 0)
        expected = np.zeros_like(mask)
        middle_row, middle = height // 2, width // 2
        expected[middle_row - seen_up : middle_row + seen_up, middle - seen_across : middle + seen_across] = (
            True
        )
        assert np.array_equal(mask, expected)

    def test_a_near_object_hides_those_behind_it(self) -> None:
        near, far = screen("near", 0.0, BLUE, x=2.0), screen("far", 0.0, RED, x=4.0)
        image = self.image_of(self.open(floor(), robot(), far, near))
        assert where(image, 2).any()
        assert not where(image, 0).any()

    def test_turning_left_moves_what_is_ahead_to_the_right(self) -> None:
        world = self.open(floor(), robot(), screen("screen", 0.0, RED))
        before = centre(where(self.image_of(world), 0))[1]
        self.drive(world, 0.0, 0.5, 0.6)
        assert centre(where(self.image_of(world), 0))[1] > before + 3 * PIXEL

    def test_a_nearer_object_is_larger(self) -> None:
        world = self.open(floor(), robot(), screen("screen", 0.0, RED))
        before = where(self.image_of(world), 0).sum()
        self.drive(world, 0.8, 0.0, 1.5)
        assert where(self.image_of(world), 0).sum() > 1.5 * before

    def test_a_new_colour_is_seen_within_one_period(self) -> None:
        self.require_camera()
        world = self.open(floor(), robot(), screen("screen", 0.0, BLUE))
        subscription = world.subscribe("/robot/camera")
        self.run(world, 0.1)
        paint(world, "screen/link/visual", RED)
        self.run(world, 0.1 + 1 / CAMERA_HZ)
        assert subscription.latest is not None
        image = np.asarray(subscription.latest.message.data, dtype=np.int64)
        assert where(image, 0).any()
        assert not where(image, 2).any()

    def test_a_colour_changes_only_its_visual_and_can_be_read_back(self) -> None:
        self.require_camera()
        world = self.open(floor(), robot(), screen("l", 1.5, GREY), screen("r", -1.5, GREY))
        paint(world, "l/link/visual", RED)
        assert centre(where(self.image_of(world), 0))[1] == pytest.approx(-0.5, abs=3 * PIXEL)
        for name, expected in (("l", RED), ("r", GREY)):
            latest = world.subscribe(f"/{name}/link/visual/color").latest
            assert latest is not None
            color_message = latest.message
            assert (color_message.r, color_message.g, color_message.b, color_message.a) == pytest.approx(
                expected
            )

    def test_an_image_shows_the_moment_of_its_stamp(self) -> None:
        """A turning robot sees the same as one that took the same path without reading images."""
        self.require_camera()
        self.require_repeatable()
        scene = floor(), robot(), screen("screen", 0.0, RED)
        watched, other = self.open(*scene), self.open(*scene)
        subscription = watched.subscribe("/robot/camera")
        for world in (watched, other):
            self.drive(world, 0.2, 0.8, 0.4)
        assert subscription.latest is not None
        assert subscription.latest.t_ns == other.now_ns
        served = np.asarray(subscription.latest.message.data, dtype=np.int64)
        expected = np.asarray(other.engine.render("robot", "eye", "camera"), dtype=np.int64)
        assert centre(where(served, 0)) == pytest.approx(centre(where(expected, 0)), abs=PIXEL / 2)

    def test_a_camera_has_its_pose_in_its_link(self) -> None:
        model = robot()
        eye = model.link("eye")
        (camera,) = eye.sensors
        assert isinstance(camera, Camera)
        moved = replace(eye, sensors=(replace(camera, pose=Pose((0.5, 0.6, 0.4))),))
        links = tuple(moved if link is eye else link for link in model.links)
        image = self.image_of(
            self.open(floor(), replace(model, links=links), screen("screen", 0.0, RED, x=3.5))
        )
        row, column = centre(where(image, 0))
        assert column == pytest.approx(0.6 / 3, abs=3 * PIXEL), (
            "the camera is left of the robot: objects must move right"
        )
        assert row > 0.1, "the camera is higher: objects must move down"

    def test_a_visual_has_its_pose_in_its_link(self) -> None:
        """A high slab that is rotated about x and moved to the left lies on its side there."""
        slab = screen("slab", 0.0, RED)
        (link,) = slab.links
        lying = Pose.from_rpy((0.0, 0.9, 0.0), pi / 2, 0.0, 0.0)
        visual = replace(link.visuals[0], geometry=Box((0.1, 0.3, 1.5)), pose=lying)
        image = self.image_of(
            self.open(floor(), robot(), replace(slab, links=(replace(link, visuals=(visual,)),)))
        )
        mask = where(image, 0)
        assert centre(mask)[1] == pytest.approx(-0.3, abs=3 * PIXEL)
        assert mask.any(axis=0).sum() > 2 * mask.any(axis=1).sum()

    def test_every_visual_of_a_link_is_rendered(self) -> None:
        (link,) = screen("screen", 0.0, RED).links
        (red,) = link.visuals
        blue = replace(red, name="second", rgba=BLUE, pose=Pose((0.0, -1.5, 0.0)))
        both = replace(screen("screen", 0.0, RED), links=(replace(link, visuals=(red, blue)),))
        image = self.image_of(self.open(floor(), robot(), both))
        assert where(image, 0).any()
        assert centre(where(image, 2))[1] > 0.2, "the second visual is to the right"

    def test_each_robot_sees_with_its_own_camera(self) -> None:
        turned = robot("b", y=-4.0, yaw=pi)
        behind = prop("behind", Box((0.1, 1.0, 1.0)), at(-3, -4, CAMERA_HEIGHT), rgba=BLUE, solid=False)
        world = self.open(floor(), robot("a"), turned, screen("screen", 0.0, RED), behind)
        first, second = self.image_of(world, "a"), self.image_of(world, "b")
        assert where(first, 0).any()
        assert where(second, 2).any()
        assert not where(first, 2).any()
        assert not where(second, 0).any()
