"""Contract: a camera looks along x of its pose, up is up, left is left, red is the first channel."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from nrp_core.conformance.world.kit import WorldKit, centre, paint, where
from nrp_core.conformance.world.scenes import (
    BLUE,
    CAMERA_HEIGHT,
    CAMERA_HZ,
    GREEN,
    GREY,
    RED,
    WIDTH,
    at,
    floor,
    prop,
    robot,
    screen,
)  # fmt: skip
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import Box, Rgba
from nrp_core.world.sensors.camera import Camera

PIXEL = 2.0 / WIDTH
OFF_EDGE = 0.4
"""The distance of a board's edge from the centre of a pixel, pixels: a field of view of 2 % more is found."""
"""The width of a pixel in image coordinates from -1 to 1."""


class SeeingTests(WorldKit):
    """Cameras and colours."""

    @pytest.mark.parametrize(("rgba", "channel"), [(RED, 0), (GREEN, 1), (BLUE, 2)])
    def test_channels_are_red_green_blue(self, rgba: Rgba, channel: int) -> None:
        image = self.look(self.open(floor(), robot(), screen("screen", 0.0, rgba)))
        assert where(image, channel).any()
        assert not any(where(image, other).any() for other in {0, 1, 2} - {channel})

    def test_left_is_left(self) -> None:
        seen = self.look(self.open(floor(), robot(), screen("l", 1.5, RED), screen("r", -1.5, BLUE)))
        assert centre(where(seen, 0))[1] == pytest.approx(-0.5, abs=3 * PIXEL)
        assert centre(where(seen, 2))[1] == pytest.approx(0.5, abs=3 * PIXEL)

    def test_up_is_up(self) -> None:
        low, high = screen("low", -0.8, RED, z=0.3), screen("high", 0.8, GREEN, z=1.6)
        seen = self.look(self.open(floor(), robot(), low, high))
        assert centre(where(seen, 1))[0] < -0.1 < centre(where(seen, 0))[0]

    def test_a_camera_looks_along_the_x_axis_of_its_robot(self) -> None:
        """The screen is on the left of the world's x axis; the robot faces it."""
        beside = prop("beside", Box((1.0, 0.1, 1.0)), at(0, 3, CAMERA_HEIGHT), rgba=RED, solid=False)
        seen = self.look(self.open(floor(), robot(yaw=pi / 2), beside))
        assert centre(where(seen, 0)) == pytest.approx((0.0, 0.0), abs=3 * PIXEL)
        assert not where(self.look(self.open(floor(), robot(), beside)), 0).any()

    def test_a_camera_that_is_tilted_down_sees_what_is_ahead_further_up(self) -> None:
        ahead = screen("ahead", 0.0, RED)
        level = self.look(self.open(floor(), robot(), ahead))
        tilted = self.look(self.open(floor(), robot(tilt=0.3), ahead))
        assert centre(where(tilted, 0))[0] < centre(where(level, 0))[0] - 5 * PIXEL

    def test_an_object_has_the_width_given_by_its_distance_and_the_field_of_view(self) -> None:
        """In a 90 degree pinhole camera, 1 m at 2.95 m covers 1/5.9 of the width, and as many rows."""
        mask = where(self.look(self.open(floor(), robot(), screen("screen", 0.0, RED))), 0)
        width = mask.shape[1]
        expected = width / (2 * 2.95)
        assert mask.any(axis=0).sum() == pytest.approx(expected, abs=1.5)
        assert mask.any(axis=1).sum() == pytest.approx(expected, abs=1.5)

    @pytest.mark.parametrize("beyond", [-OFF_EDGE, OFF_EDGE])
    def test_edges_are_in_the_pixels_of_a_pinhole(self, beyond: float) -> None:
        """A board just covers a pixel's centre or just does not; the focal length is half the width."""
        height, width, _ = self.look(self.open(floor(), robot())).shape
        columns, rows = width * 5 // 12, height // 3
        ahead, across, up = 0.5, columns + 0.5 + beyond, rows + 0.5 + beyond
        metre = ahead / (width / 2)  # of a pixel, at that distance
        board = Box((0.01, 2 * across * metre, 2 * up * metre))
        place = at(ahead + 0.005, 0, CAMERA_HEIGHT)
        mask = where(
            self.look(self.open(floor(), robot(), prop("board", board, place, rgba=RED, solid=False))), 0
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
        seen = self.look(self.open(floor(), robot(), far, near))
        assert where(seen, 2).any()
        assert not where(seen, 0).any()

    def test_turning_left_moves_what_is_ahead_to_the_right(self) -> None:
        world = self.open(floor(), robot(), screen("screen", 0.0, RED))
        before = centre(where(self.look(world), 0))[1]
        self.drive(world, 0.0, 0.5, 0.6)
        assert centre(where(self.look(world), 0))[1] > before + 3 * PIXEL

    def test_a_nearer_object_is_larger(self) -> None:
        world = self.open(floor(), robot(), screen("screen", 0.0, RED))
        before = where(self.look(world), 0).sum()
        self.drive(world, 0.8, 0.0, 1.5)
        assert where(self.look(world), 0).sum() > 1.5 * before

    def test_a_new_colour_is_seen_within_one_period(self) -> None:
        self.require_camera()
        world = self.open(floor(), robot(), screen("screen", 0.0, BLUE))
        heard = world.subscribe("/robot/camera")
        self.run(world, 0.1)
        paint(world, "screen/link/visual", RED)
        self.run(world, 0.1 + 1 / CAMERA_HZ)
        assert heard.latest is not None
        seen = np.asarray(heard.latest.message.data, dtype=np.int64)
        assert where(seen, 0).any()
        assert not where(seen, 2).any()

    def test_a_colour_changes_only_its_visual_and_can_be_read_back(self) -> None:
        self.require_camera()
        world = self.open(floor(), robot(), screen("l", 1.5, GREY), screen("r", -1.5, GREY))
        paint(world, "l/link/visual", RED)
        assert centre(where(self.look(world), 0))[1] == pytest.approx(-0.5, abs=3 * PIXEL)
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
        heard = watched.subscribe("/robot/camera")
        for world in (watched, other):
            self.drive(world, 0.2, 0.8, 0.4)
        assert heard.latest is not None
        assert heard.latest.t_ns == other.now_ns
        served = np.asarray(heard.latest.message.data, dtype=np.int64)
        expected = np.asarray(other.engine.render("robot", "eye", "camera"), dtype=np.int64)
        assert centre(where(served, 0)) == pytest.approx(centre(where(expected, 0)), abs=PIXEL / 2)

    def test_a_camera_has_its_pose_in_its_link(self) -> None:
        model = robot()
        eye = model.link("eye")
        (camera,) = eye.sensors
        assert isinstance(camera, Camera)
        moved = replace(eye, sensors=(replace(camera, pose=Pose((0.5, 0.6, 0.4))),))
        links = tuple(moved if link is eye else link for link in model.links)
        seen = self.look(self.open(floor(), replace(model, links=links), screen("screen", 0.0, RED, x=3.5)))
        row, column = centre(where(seen, 0))
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
        seen = self.look(
            self.open(floor(), robot(), replace(slab, links=(replace(link, visuals=(visual,)),)))
        )
        mask = where(seen, 0)
        assert centre(mask)[1] == pytest.approx(-0.3, abs=3 * PIXEL)
        assert mask.any(axis=0).sum() > 2 * mask.any(axis=1).sum()

    def test_every_visual_of_a_link_is_rendered(self) -> None:
        (link,) = screen("screen", 0.0, RED).links
        (red,) = link.visuals
        blue = replace(red, name="second", rgba=BLUE, pose=Pose((0.0, -1.5, 0.0)))
        both = replace(screen("screen", 0.0, RED), links=(replace(link, visuals=(red, blue)),))
        seen = self.look(self.open(floor(), robot(), both))
        assert where(seen, 0).any()
        assert centre(where(seen, 2))[1] > 0.2, "the second visual is to the right"

    def test_each_robot_sees_with_its_own_camera(self) -> None:
        turned = robot("b", y=-4.0, yaw=pi)
        behind = prop("behind", Box((0.1, 1.0, 1.0)), at(-3, -4, CAMERA_HEIGHT), rgba=BLUE, solid=False)
        world = self.open(floor(), robot("a"), turned, screen("screen", 0.0, RED), behind)
        first, second = self.look(world, "a"), self.look(world, "b")
        assert where(first, 0).any()
        assert where(second, 2).any()
        assert not where(first, 2).any()
        assert not where(second, 0).any()
