"""What an image is."""

from __future__ import annotations

from math import atan, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.scene.model import Box, Plane
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.cameras import Optics, bytes_of, drawn, flat, looking
from nrp_core.world.sensors.camera import Camera

CAMERA = Camera("camera", "/camera", 30.0, 1.57, 320, 240, 0.1, 50.0)


def test_the_vertical_field_of_view_makes_pixels_square():
    optics = Optics.of(CAMERA.view, 1.0)
    assert (optics.width, optics.height, optics.near, optics.far) == (320, 240, 0.1, 50.0)
    assert tan(optics.vertical_fov / 2) == pytest.approx(tan(1.57 / 2) * 240 / 320)


@given(st.floats(1e-3, 1.0))
def test_a_scaled_image_keeps_its_width_of_view(scale):
    optics = Optics.of(CAMERA.view, scale)
    assert optics.width >= 1
    assert optics.height >= 1
    assert 2 * atan(optics.width / 2 / optics.focal) == pytest.approx(1.57)


def test_a_camera_looks_along_x_with_z_up():
    eye = looking(Pose())
    assert eye.rotate((0, 0, -1)) == pytest.approx((1, 0, 0))
    assert eye.rotate((0, 1, 0)) == pytest.approx((0, 0, 1))
    assert eye.rotate((1, 0, 0)) == pytest.approx((0, -1, 0))


@given(st.tuples(*[st.floats(-1, 2)] * 4))
def test_a_flat_colour_is_one_of_bytes_and_opaque_or_not_there(rgba):
    color = flat(rgba)
    assert color[3] in (0.0, 1.0)
    assert flat(color) == color
    assert color[:3] == tuple(byte / 255 for byte in bytes_of(color))


def test_a_plane_is_drawn_as_a_plate_below_its_surface():
    geometry, pose = drawn(Plane((3.0, 4.0)), Pose((0, 0, 1.0)))
    assert isinstance(geometry, Box)
    assert geometry.size[:2] == (3.0, 4.0)
    assert pose.position[2] + geometry.size[2] / 2 == pytest.approx(1.0)
    assert drawn(Box((1, 1, 1)), Pose()) == (Box((1, 1, 1)), Pose())
