"""Gazebo's own renderer: it draws the scene of this moment, in the colours and light of this moment."""

from dataclasses import replace
from math import atan2, tan

import numpy as np
import pytest
from nrp_conformance.world.kit import BLUE, GREEN, RED, centre, floor, robot, screen, where
from nrp_world_gazebo import GazeboBackend

from nrp_core.world import Light, ModelMotion, Pose, Scene

pytestmark = [pytest.mark.heavy, pytest.mark.usefixtures("gazebo")]
SUN = Light("sun", casts_shadows=False)
AHEAD, ASIDE = 2.95, 1.5  # m, of the front of a screen
EYE = ("robot", "eye", "camera")


@pytest.fixture(scope="module")
def world():
    backend = GazeboBackend()
    options = backend.options(renderer="gazebo")
    models = floor(), robot(), screen("l", ASIDE, RED), screen("r", -ASIDE, BLUE)
    with backend.open(Scene(models, lights=(SUN,)), seed=1, options=options) as opened:
        yield opened


def look(world):
    return np.asarray(world.engine.render(*EYE), dtype=np.int64)


def column(bearing):
    """Return where a camera with a field of view of 90 degrees sees a bearing, from -1 (left) to 1."""
    return -tan(bearing)


def test_left_is_left_and_a_screen_is_as_wide_as_a_pinhole_shows_it(world):
    image = look(world)
    assert centre(where(image, 0))[1] == pytest.approx(column(atan2(ASIDE, AHEAD)), abs=0.05)
    assert centre(where(image, 2))[1] == pytest.approx(column(atan2(-ASIDE, AHEAD)), abs=0.05)
    width = image.shape[1]
    assert where(image, 0).any(axis=0).sum() == pytest.approx(width / (2 * AHEAD), abs=1.5)


def test_an_image_shows_the_bodies_where_they_are_now(world):
    for yaw in (0.2, -0.2):
        world.engine.place("robot", ModelMotion(turned(world, yaw)))
        seen = centre(where(look(world), 0))[1]
        assert seen == pytest.approx(column(atan2(ASIDE, AHEAD) - yaw), abs=0.08)
    world.reset()


def turned(world, yaw):
    height = world.model_motion("robot").pose.position[2]
    return Pose.from_rpy((0.0, 0.0, height), 0.0, 0.0, yaw)


def test_colours_are_those_that_were_set(world):
    world.engine.set_color("l/link/visual", GREEN)
    image = look(world)
    assert centre(where(image, 1))[1] < 0
    assert not where(image, 0).any()
    world.engine.set_color("l/link/visual", RED)


def test_light_falls_on_the_scene(world):
    bright = look(world).mean()
    world.engine.set_lights((replace(SUN, diffuse=(0.0, 0.0, 0.0, 1.0)),))
    dark = look(world).mean()
    world.engine.set_lights((SUN,))
    assert dark < 0.9 * bright
    assert look(world).mean() == pytest.approx(bright, abs=0.5)


def test_a_scene_without_cameras_needs_no_renderer():
    backend = GazeboBackend()
    with backend.open(Scene((floor(),)), seed=1, options=backend.options(renderer="gazebo")) as opened:
        opened.run_until(20_000_000)


def test_an_image_is_drawn_without_leaving_the_moment(world):
    before = world.model_motion("robot")
    assert np.array_equal(look(world), look(world))
    assert world.model_motion("robot") == before
