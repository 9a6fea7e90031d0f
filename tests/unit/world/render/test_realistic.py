"""Light on surfaces, against Lambert's law and shadows cast ray by ray."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.scene.model import Box, Light, Plane, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.cameras import SKY, bytes_of
from nrp_core.world.render.realistic import AMBIENT

EYE = (-2.0, 0.3, 2.5)  # where the camera of these images is, as long as they do not say
FLOOR = Plane((80.0, 80.0))  # so large that it is scenery: shadow maps show what is smaller
HALF = 0.4


directions = st.builds(
    lambda around, down: (cos(around) * sin(down), sin(around) * sin(down), -cos(down)),
    st.floats(0, 2 * pi),
    st.floats(0, 1.3),
)


@settings(max_examples=40, deadline=None)
@given(directions, st.floats(0.05, 0.55))
def test_a_floor_is_as_bright_as_its_angle_to_the_sun_says_and_has_no_spots(
    seen, prop, floor_points, direction, strength
):
    sun = Light("sun", direction=direction, diffuse=(strength, strength / 2, 0.0, 1.0))
    image, rays = seen([sun], prop("floor", FLOOR))
    on_floor = np.nanmax(np.abs(floor_points(rays)), axis=-1) < 20
    expected = 255 * (AMBIENT + np.array(sun.diffuse[:3]) * -direction[2])
    assert np.abs(image[on_floor] - expected).max() <= 1


@settings(max_examples=40, deadline=None)
@given(directions, st.floats(0.3, 1.5), st.sampled_from(["directional", "point", "spot"]))
def test_a_box_throws_the_shadow_that_rays_to_the_light_find(
    seen, prop, floor_points, direction, height, kind
):
    middle = np.array([1.0, 0.0, height])
    lamp = Light("lamp", kind, Pose(tuple(middle - 4 * np.array(direction))), direction, cone=(2.5, 2.6))
    box = prop("box", Box((2 * HALF,) * 3), Pose(tuple(middle)))
    image, rays = seen([lamp], prop("floor", FLOOR), box)
    points = floor_points(rays).reshape(-1, 3)
    away = np.tile(-np.array(direction), (len(points), 1))
    if kind != "directional":
        away = np.array(lamp.pose.position) - points
    gap_to_box = [_enters(points, away, middle, HALF + margin) for margin in (-0.06, 0.06)]
    shadow, maybe = gap_to_box
    hidden = _enters(np.tile(EYE, (len(points), 1)), points - EYE, middle, HALF + 0.05)
    visible = ~np.isnan(points[:, 0]) & ~hidden & (np.abs(points).max(axis=1) < 6)
    bright = image.reshape(-1, 3)[:, 0].astype(int)
    dark = round(255 * AMBIENT)
    assert (bright[visible & shadow] == dark).all()
    facing = away[:, 2] / np.linalg.norm(away, axis=1) > 0.1
    in_cone = (
        (away @ -np.array(direction)) / np.linalg.norm(away, axis=1) > cos(1.2) if kind == "spot" else True
    )
    assert (bright[visible & ~maybe & facing & in_cone] > dark).all()


def _enters(starts, ways, middle, half):
    """Tell which rays meet a cube."""
    with np.errstate(all="ignore"):
        one, other = (middle - half - starts) / ways, (middle + half - starts) / ways
    first, last = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    return (last >= first) & (last > 0)


def test_a_ball_is_shaded_smoothly_and_a_box_is_not(seen, prop):
    sun = Light("sun", direction=(1.0, 0.0, -1.0), diffuse=(0.6, 0.6, 0.6, 1.0))
    ball, rays = seen([sun], prop("ball", Sphere(1.0), Pose((1.0, 0.3, 1.0))))
    middle, eye = np.array([1.0, 0.3, 1.0]), np.array(EYE)
    ways = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    b = ways @ (eye - middle)
    root = b**2 - ((eye - middle) @ (eye - middle) - 1.0)
    hit = root > 0.15  # not at the rim
    normals = eye + ways * (-b - np.sqrt(np.maximum(root, 0)))[..., None] - middle
    slope = np.maximum(normals @ np.array([-1.0, 0.0, 1.0]) / 2**0.5, 0)
    away_from_night = hit & (slope > 0.1)
    expected = 255 * np.minimum(1, AMBIENT + 0.6 * slope)
    assert np.abs(ball[..., 0] - expected)[away_from_night].max() < 4
    turned = Pose.from_rpy((1.0, 0.3, 1.0), 0.0, 0.0, radians(20))
    box, _ = seen([sun], prop("box", Box((1.0, 1.0, 1.0)), turned))
    shades = {tuple(color) for color in box.reshape(-1, 3).tolist()} - {bytes_of(SKY)}
    assert 2 <= len(shades) <= 3  # one for each side


@pytest.mark.parametrize("distance", [1.0, 2.0, 4.0])
def test_a_lamp_gets_weaker_with_distance_as_it_says(seen, prop, distance):
    lamp = Light(
        "lamp", "point", Pose((1.0, 0.3, distance)), attenuation=(3.0, 2.0, 0.5, 0.25), casts_shadows=False
    )
    eye = Pose.from_rpy((1.0, 0.3, 5.0), 0, pi / 2, 0)
    image, _ = seen([lamp], prop("floor", FLOOR), eye=eye)
    strength = 1 / (2.0 + 0.5 * distance + 0.25 * distance**2) if distance < 3 else 0.0
    assert image[22, 30, 0] == pytest.approx(255 * (AMBIENT + strength), abs=1.5)


def test_without_lights_there_is_ambient_light_only_and_a_black_light_is_off(seen, prop):
    floor = prop("floor", FLOOR)
    dark, _ = seen([], floor)
    off, _ = seen([Light("sun", diffuse=(0.0, 0.0, 0.0, 1.0))], floor)
    assert dark[-1, 0].tolist() == [round(255 * AMBIENT)] * 3
    assert (dark == off).all()


def test_a_scene_without_anything_to_see_is_sky(seen):
    image, _ = seen([Light("sun")])
    assert (image == bytes_of(SKY)).all()
