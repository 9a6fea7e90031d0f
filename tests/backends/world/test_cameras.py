"""Images: flat colours that arrive exactly, left on the left, alike in all engines."""

from __future__ import annotations

from dataclasses import replace
from math import atan, pi, tan

import cv2
import numpy as np
import pytest
from ray_images import ray_image

from nrp_core.dsl.red_pixels import red_colors
from nrp_core.dsl.tf_lib import detect_red
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import (
    Box,
    Capsule,
    Cylinder,
    Joint,
    Link,
    Mesh,
    Model,
    Plane,
    Scene,
    Sphere,
    Visual,
)
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.cameras import SKY, bytes_of
from nrp_core.world.sensors.camera import Camera

RED, GREEN, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
EYE = Pose((-0.16, 0.0, 0.503))  # of the standing robot's camera


def ahead(parts, name, x=0.0, y=0.0, z=0.0, *, geometry=None, rgba=RED, turned=None):
    """Return a thing at a place given in the camera's frame."""
    pose = EYE @ Pose((x, y, z)) @ (turned or Pose())
    return parts.prop(name, geometry or Box((0.2, 0.2, 0.2)), pose, rgba=rgba, solid=False)


def scene_of(*models):
    return Scene(models)


def where(image, color):
    """Return rows and columns of the pixels of a colour, as centres relative to the image's, in -1..1."""
    height, width, _ = image.shape
    rows, columns = np.nonzero((image == color).all(axis=2))
    return (rows + 0.5) * 2 / height - 1, (columns + 0.5) * 2 / width - 1


def test_left_is_left_and_up_is_up(look, parts):
    left, right = ahead(parts, "left", 3, 1, 0, rgba=RED), ahead(parts, "right", 3, -1, 0, rgba=GREEN)
    up = ahead(parts, "up", 3, 0, 1, rgba=BLUE)
    image = look(left, right, up, parts.husky())
    assert where(image, (255, 0, 0))[1].mean() < -0.2
    assert where(image, (0, 255, 0))[1].mean() > 0.2
    assert where(image, (0, 0, 255))[0].mean() < -0.2


def test_a_camera_turns_with_its_robot(look, parts):
    target = ahead(parts, "target", 0.16, 3, 0)  # to the left of the robot
    assert not where(look(target, parts.husky()), (255, 0, 0))[0].size
    turned = Pose.from_rpy((0, 0, parts.standing), 0, 0, pi / 2)
    assert where(look(target, parts.husky(pose=turned)), (255, 0, 0))[0].size


def test_the_horizontal_field_of_view_is_that_of_the_file(look, parts):
    edge = tan(1.0 / 2) * 4  # half the width that 1 rad sees at 4 m
    sides = [
        ahead(parts, n, 4, y, 0, geometry=Box((0.01, 0.3, 0.3)))
        for n, y in (("in", edge - 0.3), ("out", -edge - 0.3))
    ]
    _, columns = where(look(*sides, parts.husky(horizontal_fov=1.0, width=320, height=240)), (255, 0, 0))
    assert columns.size
    assert columns.max() < 0
    assert columns.min() == pytest.approx(-1 + 0.15 / edge, abs=0.02)


def test_pixels_are_square(look, parts):
    image = look(ahead(parts, "ball", 3, geometry=Sphere(0.5)), parts.husky(width=200, height=100))
    rows, columns = np.nonzero((image == (255, 0, 0)).all(axis=2))
    assert np.ptp(rows) == pytest.approx(np.ptp(columns), abs=2)


def test_every_level_of_a_colour_arrives_exactly(backend, parts):
    screen = ahead(parts, "screen", 1, geometry=Box((0.01, 5, 5)))
    options = backend.options()
    with backend.open(scene_of(screen, parts.husky(width=16, height=12)), seed=1, options=options) as world:
        for level in range(256):
            world.engine.set_color("screen/link/visual", (level / 255, 1 - level / 255, 0.2, 1.0))
            image = world.engine.render("husky", "eye", "camera")
            assert image[3, 8].tolist() == [level, 255 - level, 51]


def test_a_new_colour_is_seen_in_the_next_image(backend, parts, advance):
    left, right = (ahead(parts, n, 1, y, geometry=Box((0.01, 2, 5))) for n, y in (("left", 1), ("right", -1)))
    scene = scene_of(parts.floor(), left, right, parts.husky())
    with backend.open(scene, seed=1, options=backend.options()) as world:
        images = world.subscribe("/husky/camera")
        advance(world, 0.04)
        assert (images.latest.message.data[4] == (255, 0, 0)).all()
        world.advertise("/right/link/visual/color").publish(ColorRGBA(0, 0, 1, 1))
        image = world.engine.render("husky", "eye", "camera")
        assert (image[4, :32] == (255, 0, 0)).all()
        assert (image[4, 32:] == (0, 0, 255)).all()
        world.reset()
        assert (world.engine.render("husky", "eye", "camera")[4] == (255, 0, 0)).all()


def test_a_pixel_that_nothing_covers_is_sky(look, parts):
    assert (look(parts.husky())[:10] == bytes_of(SKY)).all()


def test_transparent_objects_are_not_seen(look, parts):
    ghost = ahead(parts, "ghost", 1, geometry=Box((0.01, 5, 5)), rgba=(1, 0, 0, 0.0))
    glass = ahead(parts, "glass", 3, geometry=Sphere(0.5), rgba=(0, 0, 1, 0.5))
    image = look(ghost, glass, parts.husky())
    assert not where(image, (255, 0, 0))[0].size
    assert where(image, (0, 0, 255))[0].size


def test_visuals_are_seen_and_collisions_are_not(look, parts):
    base, *links = parts.husky().links
    bare = replace(parts.husky(), links=(replace(base, visuals=()), *links))
    yellow = (230, 204, 26)
    assert where(look(parts.husky()), yellow)[0].min() > 0
    seen = {tuple(color) for color in look(bare).reshape(-1, 3).tolist()}
    assert seen <= {bytes_of(SKY), bytes_of(parts.tyre)}


@pytest.mark.parametrize("size", [0.05, 0.3])
def test_a_camera_does_not_see_the_housing_around_it(look, parts, size):
    robot = parts.husky()
    eye = next(link for link in robot.links if link.name == "eye")
    housed = replace(eye, visuals=(Visual("housing", Box((size, size, size)), rgba=RED),))
    links = tuple(housed if link is eye else link for link in robot.links)
    image = look(replace(robot, links=links))
    assert (image == look(robot)).all()


def test_a_camera_does_not_see_what_is_nearer_than_its_clip_distance(look, parts):
    robot = parts.husky(near=0.5)
    eye = next(link for link in robot.links if link.name == "eye")
    lens = Visual("lens", Box((0.1, 0.1, 0.1)), Pose((0.3, 0, 0)), RED)
    links = tuple(replace(eye, visuals=(lens,)) if link is eye else link for link in robot.links)
    assert not where(look(replace(robot, links=links)), (255, 0, 0))[0].size


def test_a_smaller_image_scale_sees_the_same_with_fewer_pixels(look, parts):
    screen = ahead(parts, "screen", 3, 0.8, 0.4, geometry=Box((0.1, 1, 1)))
    full = look(screen, parts.husky(width=320, height=240))
    small = look(screen, parts.husky(width=320, height=240), image_scale=0.2)
    assert full.shape == (240, 320, 3)
    assert small.shape == (48, 64, 3)
    red = [(image == (255, 0, 0)).all(axis=2) for image in (full, small)]
    assert red[0].mean() == pytest.approx(red[1].mean(), abs=0.01)


def test_images_are_fresh_and_read_only(backend, parts):
    with backend.open(scene_of(parts.husky()), seed=1, options=backend.options()) as world:
        first = world.engine.render("husky", "eye", "camera")
        world.engine.set_color("husky/base_link/chassis", RED)
        assert not (first == world.engine.render("husky", "eye", "camera")).all()
        with pytest.raises(ValueError, match="read-only"):
            first[0, 0] = 0


def test_a_camera_on_a_moving_joint_looks_where_the_joint_stands(backend, parts, advance):
    neck = Joint("neck", "revolute", "world", "head", Pose((0, 0, 1)), (0, 0, 1), -0.1, 1.2)
    camera = Camera("camera", "/head/camera", 30, 1.2, 64, 48)
    moment = (0.1, 0.1, 0.1, 0, 0, 0)
    inertial = replace(parts.husky().links[0].inertial, mass=1.0, pose=Pose((0, -0.3, 0)), inertia=moment)
    head = Model("head", (Link("head", Pose((0, 0, 1)), inertial, sensors=(camera,)),), (neck,))
    target = parts.prop("target", Sphere(0.3), Pose((1.0, 2.6, 1.0)), rgba=RED)  # at about 1.2 rad
    scene = replace(scene_of(head, target), gravity=(9.8, 0.0, 0.0))  # turns the head left, up to its limit
    with backend.open(scene, seed=1, options=backend.options()) as world:
        assert not where(world.engine.render("head", "head", "camera"), (255, 0, 0))[0].size
        advance(world, 3.0)
        _, columns = where(world.engine.render("head", "head", "camera"), (255, 0, 0))
        assert columns.mean() == pytest.approx(tan(1.2 - atan(2.6)) / tan(0.6), abs=0.05)


def test_all_shapes_look_as_ray_casts_of_mujoco_see_them(look, parts, tmp_path):
    mesh = tmp_path / "pyramid.stl"
    corners = np.array([(1, 1, 0), (-1, 1, 0), (-1, -1, 0), (1, -1, 0), (0, 0, 1)], float)
    write_stl(mesh, corners[[(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (3, 2, 1), (3, 1, 0)]])
    round_ones = [Sphere(0.3), Cylinder(0.2, 0.6), Capsule(0.15, 0.4)]
    shapes = [Box((0.3, 0.6, 0.4)), *round_ones, Mesh(mesh, (0.3, 0.3, 0.6)), Plane((0.5, 0.8))]
    turned = Pose.from_rpy((0, 0, 0), 0.4, -0.8, 0.3)
    things = [
        ahead(
            parts,
            f"thing{i}",
            3,
            1.8 - 0.7 * i,
            0.3,
            geometry=shape,
            rgba=(0.1 + 0.15 * i, 0.5, 0.3, 1),
            turned=turned,
        )
        for i, shape in enumerate(shapes)
    ]
    models = (parts.floor(), *things, parts.husky(width=320, height=240))
    reference = ray_image(models, EYE, 320, 240, 1.57)
    for i in range(len(shapes)):
        color = bytes_of((0.1 + 0.15 * i, 0.5, 0.3, 1))
        assert (reference == color).all(axis=2).sum() > 100, f"{shapes[i]} is seen"
    assert (look(*models) == reference).all(axis=2).mean() > 0.99


def test_as_much_red_is_left_and_right_as_ray_casts_of_mujoco_see(look, parts):
    screen = ahead(parts, "screen", 2.5, 1.0, 0.6, geometry=Box((0.015, 1.96, 1.1)))
    models = (parts.floor(), parts.wall(3.0), screen, parts.husky(width=320, height=240))
    seen, wanted = (share_of_red(each) for each in (look(*models), ray_image(models, EYE, 320, 240, 1.57)))
    assert wanted[0] > 0.1
    assert seen == pytest.approx(wanted, abs=0.0025)


def share_of_red(image):
    """Return the shares of red pixels in both halves of an image."""
    hsv = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2HSV)
    red = cv2.inRange(hsv, np.array([0, 30, 30]), np.array([0, 255, 255])) > 0
    return red[:, :160].mean(), red[:, 160:].mean()


def test_images_of_two_worlds_opened_at_once_do_not_mix(backend, parts):
    options = backend.options()
    scenes = [
        scene_of(ahead(parts, "s", 1, geometry=Box((0.01, 5, 5)), rgba=c), parts.husky()) for c in (RED, BLUE)
    ]
    with (
        backend.open(scenes[0], seed=1, options=options) as one,
        backend.open(scenes[1], seed=1, options=options) as two,
    ):
        for world, color in ((one, (255, 0, 0)), (two, (0, 0, 255)), (one, (255, 0, 0))):
            assert (world.engine.render("husky", "eye", "camera")[4] == color).all()


def test_red_is_counted_without_an_image_as_in_it(open_world, parts):
    red, hider = ahead(parts, "red", 3, 0.3, 0), ahead(parts, "hider", 2, 0.1, 0, rgba=BLUE)
    with open_world(scene_of(red, hider, parts.husky())) as world:
        camera = world.subscribe("/husky/camera")
        world.run_until(200_000_000)
        image = camera.latest.message
        shares = detect_red(image)
        assert image.count_colors(red_colors) is not None, "no image was drawn"
        assert shares == detect_red(replace(image, data=image.data))
        assert 0 < shares.left > shares.right
