"""Surfaces that shine, against what is true of any: energy, reciprocity, mirrors, Lambert and Fresnel."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.scene.model import Finish, Light, Plane, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.gloss import STEPS, Gloss, add_gloss, begin_gloss, tabulate, width_of
from nrp_core.world.render.realistic import AMBIENT

FLOOR = Plane((80.0, 80.0))
UP = np.array([0.0, 0.0, 1.0])
RED = (0.9, 0.0, 0.0, 1.0)
GOLD = (1.0, 0.78, 0.34, 1.0)

shares = st.floats(0.0, 1.0)
colors = st.tuples(shares, shares, shares)
slanted = st.builds(
    lambda down, around: direction(cos(down), around), st.floats(0, 1.5), st.floats(0, 2 * pi)
)


def direction(height: float, around: float) -> tuple[float, float, float]:
    across = sqrt(max(1 - height * height, 0.0))
    return across * cos(around), across * sin(around), height


def reflected(finish: Finish, color, towards, view, ambient: float = 0.0):
    """Return what a surface sends to the eye of a lamp whose light shows a white matt one as white."""
    gloss = Gloss([finish])
    row, table = gloss.of(np.array([color]))[0], gloss.tables[0]
    leaving, light = np.empty(4), np.empty(3)
    begin_gloss(row, table, view[2], ambient, leaving, light)
    if towards is not None:
        add_gloss(
            row, table, UP, view[2], np.array(view), tuple(towards), leaving, np.full(3, towards[2]), light
        )
    return light


def sent_to_all_sides(finish: Finish, color, towards):
    """Return the share of a lamp's light that a surface sends anywhere."""
    gloss = Gloss([finish])
    row, table = gloss.of(np.array([color]))[0], gloss.tables[0]
    leaving, light, total = np.empty(4), np.empty(3), np.zeros(3)
    heights, turns = (np.arange(60) + 0.5) / 60, 2 * pi * (np.arange(90) + 0.5) / 90
    for height in heights:
        for turn in turns:
            view = np.array(direction(height, turn))
            begin_gloss(row, table, height, 0.0, leaving, light)
            add_gloss(row, table, UP, height, view, towards, leaving, np.full(3, 1.0), light)
            total += light * height
    return 2 * total / (len(heights) * len(turns))


@settings(max_examples=15, deadline=None)
@given(st.builds(Finish, st.floats(0.3, 1.0), shares, colors), colors, st.floats(0.05, 1.0))
def test_no_surface_sends_more_light_than_falls_on_it(finish, color, height):
    assert sent_to_all_sides(finish, color, direction(height, 0.3)).max() < 1.03  # the sum is over a grid


@pytest.mark.parametrize("metalness", [0.0, 1.0])
@pytest.mark.parametrize("roughness", [0.4, 0.7, 1.0])
@pytest.mark.parametrize("height", [0.3, 0.9])
def test_a_white_surface_sends_all_light_that_falls_on_it(metalness, roughness, height):
    finish = Finish(roughness, metalness)
    assert sent_to_all_sides(finish, (1, 1, 1), direction(height, 0.3)) == pytest.approx(np.ones(3), abs=0.02)


@settings(max_examples=40, deadline=None)
@given(st.builds(Finish, shares, shares, colors), colors, slanted, slanted)
def test_light_paths_are_reversible(finish, color, one, other):
    to, fro = reflected(finish, color, one, other), reflected(finish, color, other, one)
    assert to * other[2] == pytest.approx(fro * one[2], rel=1e-6, abs=1e-9)


@pytest.mark.one_of(6)
@pytest.mark.parametrize("finish", [Finish(r, m) for r in (0.0, 0.3, 1.0) for m in (0.0, 1.0)], ids=str)
def test_a_white_object_is_invisible_in_uniform_light(seen, prop, finish):
    image, _ = seen([], prop("ball", Sphere(1.0), Pose((1.0, 0.3, 1.0)), finish=finish))
    on_ball = image[(image != image[0, 0]).any(axis=2)]
    assert len(on_ball) > 100
    assert np.abs(on_ball.astype(int) - round(255 * AMBIENT)).max() <= 1


@settings(max_examples=40, deadline=None)
@given(slanted.filter(lambda way: way[2] > 0.3), slanted.filter(lambda way: way[2] > 0.5), colors)
def test_rough_plastic_is_as_lambert_says_within_what_fresnel_takes(towards, view, color):
    matt = np.multiply(color, towards[2])
    light = reflected(Finish(1.0), color, towards, view)
    assert (light >= 0.85 * matt).all()
    assert (light <= matt + 0.06).all()


def test_the_smoothest_surface_reflects_by_schlicks_form_of_fresnels_law():
    table = np.empty((STEPS + 1, 2))
    tabulate(width_of(0.0), table)
    rest = (1 - np.linspace(0, 1, STEPS + 1)) ** 5
    steep = slice(STEPS // 8, None)  # at grazing angles even the smallest slopes hide each other
    assert table[steep] == pytest.approx(np.column_stack([1 - rest, rest])[steep], abs=0.01)


@pytest.mark.parametrize("metalness", [0.0, 1.0])
def test_a_highlight_is_where_a_mirror_would_show_the_lamp(seen, prop, floor_points, metalness):
    lamp, eye = np.array([2.0, 0.3, 2.0]), np.array([-2.0, 0.3, 2.5])
    light = Light("lamp", "point", Pose(tuple(lamp)), diffuse=(0.2, 0.2, 0.2, 1.0), casts_shadows=False)
    floor = prop("floor", FLOOR, rgba=(0.3, 0.3, 0.3, 1.0), finish=Finish(0.25, metalness))
    image, rays = seen([light], floor)
    brightness = image.sum(axis=2)
    peak = floor_points(rays)[brightness == brightness.max()].mean(axis=0)
    mirrored = eye + (lamp * (1, 1, -1) - eye) * eye[2] / (eye[2] + lamp[2])
    assert peak == pytest.approx(mirrored, abs=0.15)


def test_the_rougher_the_wider_is_a_highlight_and_the_weaker(seen, prop):
    sun = Light("sun", direction=(0.5, 0.0, -0.6), diffuse=(0.05, 0.05, 0.05, 1.0))
    widths, peaks = [], []
    for roughness in (0.2, 0.3, 0.4, 0.5):
        ball = prop("ball", Sphere(1.0), Pose((1.0, 0.3, 1.0)), GOLD, Finish(roughness, 1.0))
        lit, dark = (seen(lights, ball)[0][..., 0].astype(int) for lights in ([sun], []))
        added = lit - dark
        widths.append((added > added.max() / 2).sum())
        peaks.append(added.max())
    assert widths == sorted(set(widths))
    assert peaks == sorted(peaks, reverse=True)


def test_metal_has_no_colour_from_within_and_plastic_shines_in_the_colour_of_the_lamp():
    towards, aside, mirror = direction(0.7, 0.0), direction(0.7, 0.3), direction(0.7, pi)
    metal = reflected(Finish(0.2, 1.0), RED[:3], towards, aside)
    assert metal[0] < 0.01  # beside its highlight: nothing, though it is red
    red, green, _ = reflected(Finish(0.2, 1.0), RED[:3], towards, mirror)
    assert red > 20 * green > 0
    red, green, blue = reflected(Finish(0.2, 0.0), RED[:3], towards, mirror)
    within = reflected(Finish(0.2, 0.0), RED[:3], towards, aside)
    assert red - within[0] == pytest.approx(green, rel=0.02)
    assert green == blue


def test_shadows_fall_on_glossy_surfaces(seen, prop):
    sun = Light("sun", diffuse=(0.4, 0.4, 0.4, 1.0))
    floor, roof = prop("floor", FLOOR, finish=Finish(0.4)), prop("roof", Sphere(0.8), Pose((1.0, 0.3, 3.0)))
    images = [seen(lights, *models)[0] for lights in ([], [sun]) for models in ([floor], [floor, roof])]
    dark, dark_below, lit, below = (image[22, 30].tolist() for image in images)
    assert below == dark == dark_below
    assert lit[0] > dark[0] + 50
