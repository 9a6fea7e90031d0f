"""An image of a scene from outside: everything is in it, and shapes can be told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nrp_core.scene.model import Box, Inertial, Joint, Link, Model, Plane, Scene, Sphere, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.portrait import Moment, portrait

RED, GREEN = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0)


def prop(geometry, pose=Pose(), rgba=RED, name="thing"):
    return Model(name, (Link("l", visuals=(Visual("v", geometry, rgba=rgba),)),), pose=pose, static=True)


def drawn(image):
    """Return which pixels are coloured: background, grid and shadows are grey."""
    return np.ptp(image, axis=2) > 40


@pytest.mark.parametrize("scale", [0.01, 1.0, 30.0])
@pytest.mark.parametrize("place", [(0, 0, 0), (100, -50, 3)])
def test_a_thing_of_any_size_anywhere_fills_the_image_and_is_not_cut(scale, place):
    seen = drawn(portrait(Scene((prop(Box((scale, 2 * scale, scale)), Pose(place)),)), 120, 90))
    rows, columns = np.nonzero(seen)
    assert rows.min() > 0
    assert columns.min() > 0
    assert rows.max() < 89
    assert columns.max() < 119
    assert max(np.ptp(rows) / 90, np.ptp(columns) / 120) > 0.7
    assert abs(rows.mean() - 44.5) < 9
    assert abs(columns.mean() - 59.5) < 12


def test_endless_ground_does_not_make_the_rest_small():
    ground = prop(Plane((100, 100)), name="ground", rgba=GREEN)
    image = portrait(Scene((ground, prop(Sphere(0.5), Pose((0, 0, 0.5))))), 120, 90)
    assert ((image[:, :, 0] > 80) & (image[:, :, 1] < 20)).sum() > 0.15 * 120 * 90


def test_the_faces_of_a_box_differ_in_brightness():
    robot = Link("base", inertial=Inertial(1.0), visuals=(Visual("v", Box((1, 1, 1)), rgba=RED),))
    image = portrait(Scene((Model("robot", (robot,)),)), 120, 90)
    values, counts = np.unique(image[:, :, 0][drawn(image) & (image[:, :, 1] < 5)], return_counts=True)
    assert len(values[counts > 500]) == 3


def test_a_robot_that_hangs_on_the_world_fills_the_image():
    arm = Link("arm", inertial=Inertial(1.0), visuals=(Visual("v", Box((1, 1, 1)), rgba=RED),))
    robot = Model("robot", (arm,), (Joint("j", "revolute", "world", "arm"),))
    rows, columns = np.nonzero(drawn(portrait(Scene((robot,)), 120, 90)))
    assert max(np.ptp(rows) / 90, np.ptp(columns) / 120) > 0.7


def test_links_are_where_their_joints_put_them():
    ball = Link("ball", Pose((0, 0, 3)), Inertial(1.0), (Visual("v", Sphere(0.5), rgba=GREEN),))
    base = Link("base", inertial=Inertial(1.0), visuals=(Visual("v", Sphere(0.5), rgba=RED),))
    joint = Joint("j", "revolute", "base", "ball", Pose((0, 0, 3)), lower=-1, upper=1)
    model = Model("robot", (base, ball), (joint,))
    for posed in (model, replace(model, pose=Pose((7, 8, 9)))):
        image = portrait(Scene((posed,)), 90, 120).astype(int)
        green, red = image[:, :, 1] - image[:, :, 0] > 50, image[:, :, 0] - image[:, :, 1] > 50
        assert np.nonzero(green)[0].mean() < 45
        assert np.nonzero(red)[0].mean() > 75


@pytest.mark.parametrize(
    ("kind", "axis", "start", "place"),
    [
        ("prismatic", (0, 0, 1), 1.0, (0, 0, 4)),
        ("revolute", (1, 0, 0), np.pi / 2, (0, -3, 0)),
        ("revolute", (0, 1, 0), -np.pi / 2, (-3, 0, 0)),
    ],
)
def test_joints_are_where_they_start(kind, axis, start, place):
    base = Link("base", inertial=Inertial(1.0), visuals=(Visual("v", Sphere(0.5), rgba=RED),))

    def robot(at, starts=()):
        box = Link("box", Pose(at), Inertial(1.0), (Visual("v", Box((1, 1, 1)), rgba=GREEN),))
        joint = Joint("j", kind, "base", "box", axis=axis, lower=-2, upper=2)
        return Scene((Model("robot", (base, box), (joint,), starts=starts, pose=Pose((1, 2, 0))),))

    started, placed = portrait(robot((0, 0, 3), (("j", start),)), 90, 90), portrait(robot(place), 90, 90)
    assert (started != placed).any(axis=2).mean() < 0.01
    assert (started != portrait(robot((0, 0, 3)), 90, 90)).any(axis=2).mean() > 0.05


def test_nothing_is_an_image_of_nothing():
    assert not drawn(portrait(Scene(()), 40, 30)).any()


def test_a_model_is_drawn_where_it_is_now_in_its_present_colour():
    robot = Link("base", inertial=Inertial(1.0), visuals=(Visual("v", Box((1, 1, 1)), rgba=RED),))
    wall = prop(Box((0.1, 8, 8)), Pose((-8, 0, 4)), rgba=GREEN, name="wall")
    scene = Scene((Model("robot", (robot,)), wall))

    def frames(paths, rows):
        assert list(paths) == [("robot", 0)]
        rows[:] = np.column_stack([np.eye(3), (5, 0, 0)])

    moment = Moment(frames, colors={"robot/base/v": (0.0, 0.0, 1.0, 1.0)})
    whole = portrait(scene, 120, 90, moment=moment)
    seen = (whole[:, :, 2] > 90) & (whole[:, :, 0] < 20)
    assert 0 < seen.sum() < 0.1 * seen.size
    image = portrait(scene, 120, 90, moment=moment, of=["robot"])
    rows, columns = np.nonzero((image[:, :, 2] > 90) & (image[:, :, 0] < 20))
    assert 0.5 < max(np.ptp(rows) / 90, np.ptp(columns) / 120) < 0.7
    assert abs(columns.mean() - 59.5) < 8


def test_a_wall_before_the_model_that_fills_the_image_is_left_out():
    robot = Link("base", inertial=Inertial(1.0), visuals=(Visual("v", Box((1, 1, 1)), rgba=RED),))
    around = [
        prop(Box((0.1, 4, 9) if x else (4, 0.1, 9)), Pose((x, y, 0)), GREEN, f"wall {x} {y}")
        for x, y in ((2, 0), (-2, 0), (0, 2), (0, -2))
    ]
    scene = Scene((Model("robot", (robot,)), *around))
    whole, image = portrait(scene, 120, 90), portrait(scene, 120, 90, of=["robot"])
    red, hidden = (((each[:, :, 0] > 80) & (each[:, :, 1] < 20)).sum() for each in (image, whole))
    assert red > 800
    assert hidden == 0
