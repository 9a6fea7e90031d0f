"""Pictures for people: the sun's shadow, and the grid on the floor, are where geometry puts them."""

from __future__ import annotations

from math import radians, tan

import numpy as np
import pytest

from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Box, Inertial, Light, Link, Model, Plane, Sphere, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of
from nrp_core.world.render.shaded import BACKGROUND, ShadedView, sun_of

GREY = (0.5, 0.5, 0.5, 1.0)
HEIGHT_M, FOV, SIZE = 20.0, radians(40), 201
PIXEL_M = 2 * HEIGHT_M * tan(FOV / 2) / SIZE


def from_above(*models, sun=(0.0, 0.0, 1.0)):
    bodies = {model.name: bodies_of(model) for model in models}
    numbers = frames_of(bodies)
    view = ShadedView(SceneMesh(bodies, numbers), SIZE, SIZE, vertical_fov=FOV, samples=2, sun=sun)
    frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))
    for (name, _), number in numbers.items():
        frames[number, :, 3] = next(m.pose.position for m in models if m.name == name)
    return view.draw(frames, np.column_stack([np.eye(3), (0.0, 0.0, HEIGHT_M)]), away_m=HEIGHT_M).astype(int)


def thing(name, size, pose, *, static=True, shape=Box):
    link = Link("l", visuals=(Visual("v", shape(size), rgba=GREY),), inertial=Inertial(1.0))
    return Model(name, (link,), pose=pose, static=static)


def pixel(image, x_m, y_m=0.0):
    return image[round(SIZE / 2 - y_m / PIXEL_M - 0.5), round(SIZE / 2 + x_m / PIXEL_M - 0.5)]


@pytest.mark.parametrize("slope", [-0.75, 0.75])
def test_a_shadow_falls_where_light_along_its_direction_puts_it(slope):
    floor = thing("floor", (12, 12), Pose(), shape=Plane)
    box = thing("box", (1, 1, 0.2), Pose((0, 0, 1.1)), static=False)
    sun = sun_of([Light("sun", direction=(slope, 0.0, -1.0))])
    image = from_above(floor, box, sun=sun)
    lit, shadow = pixel(image, -slope, 0.3), pixel(image, 1.1 * slope, 0.3)
    assert lit.tolist() == pixel(image, 3.3, 0.3).tolist()
    assert (shadow < 0.8 * lit).all()


def test_a_ceiling_over_all_that_moves_casts_no_shadow():
    floor, box = thing("floor", (12, 12), Pose(), shape=Plane), thing("b", (1, 1, 1), Pose(), static=False)
    lamp = thing("ceiling", (2, 2, 0.1), Pose((0, 0, 2)))
    sun = (-1.0, 0.0, 1.0)  # it would fall from 1 m to 3 m
    assert (from_above(floor, box, lamp, sun=sun)[:, 140:] == from_above(floor, box, sun=sun)[:, 140:]).all()


def test_a_dome_around_the_room_neither_darkens_it_nor_moves_its_grid():
    box = thing("b", (1, 1, 1), Pose(), static=False)
    dome = thing("dome", 200.0, Pose(), shape=Sphere)
    assert (from_above(box, dome) == from_above(box)).all()


def test_the_grid_has_lines_at_multiples_of_its_step_of_metres():
    """The image is 14.6 m wide, so the step is 2 m, the largest round one that fits five times."""
    image = from_above()
    for at_m in (-4.0, -2.0, 2.0, 4.0, 6.0):
        assert (pixel(image, at_m, 1.0) < BACKGROUND).all()
        assert pixel(image, at_m + 1.0, 1.0).tolist() == list(BACKGROUND)


@pytest.mark.parametrize("place", [(0, 0, -0.5), (0, 0, -30)])
def test_a_scene_without_a_floor_stands_on_the_grid(place):
    box = thing("box", (1, 1, 1), Pose(place), static=False)
    image = from_above(box, sun=(-1.0, 0.0, 1.0))
    assert pixel(image, 0.0).max() < 160  # the box
    assert (image != BACKGROUND).any(axis=2).sum() > 2 * (1 / PIXEL_M) ** 2 * (place[2] > -1)
