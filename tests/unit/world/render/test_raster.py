"""The shared renderer, against rays cast at boxes one by one."""

from __future__ import annotations

import pickle
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Header
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Box, Inertial, Link, Model, Scene, Visual
from nrp_core.scene.rigid import Pose, matrix_of
from nrp_core.world.render import seen_image
from nrp_core.world.render.cameras import SKY, bytes_of, looking, optics_of
from nrp_core.world.render.raster import RasterCameras
from nrp_core.world.render.seen_image import SeenImage
from nrp_core.world.sensors.camera import Camera

NEAR, FAR = 0.2, 9.0
CAMERA = ("eye", "link", "camera")


def color(number: int) -> tuple[float, float, float, float]:
    return (number / 255, 0.0, 1.0, 1.0)


def eye(pose: Pose = Pose(), *, static: bool = True) -> Model:
    camera = Camera("camera", "/camera", 30.0, 1.2, 40, 30, NEAR, FAR)
    return Model("eye", (Link("link", inertial=Inertial(1.0), sensors=(camera,)),), pose=pose, static=static)


def box(number: int, size: tuple[float, float, float], pose: Pose) -> Model:
    visual = Visual("visual", Box(size), rgba=color(number))
    return Model(f"box{number}", (Link("link", visuals=(visual,)),), pose=pose, static=True)


def cameras(*models: Model, poses: dict[str, Pose] | None = None) -> RasterCameras:
    """Open the renderer on models; ``poses`` tells where moving ones are."""

    def reader(paths):
        def read(frames):
            for frame, (model, _) in zip(frames, paths, strict=True):
                frame[:] = matrix_of((poses or {})[model])

        return read

    scene = Scene(models)
    return RasterCameras({m.name: bodies_of(m) for m in models}, optics_of(scene, 1.0), reader)


def cast(boxes: list[Model], camera: Pose) -> tuple[np.ndarray, np.ndarray]:
    """Return the image made by testing all rays against the slabs of all boxes, and where two are first."""
    optics = optics_of(Scene((eye(),)), 1.0)[CAMERA]
    across, down = np.meshgrid(np.arange(40) + 0.5 - 20, np.arange(30) + 0.5 - 15)
    rays = np.stack([across / optics.focal, -down / optics.focal, -np.ones((30, 40))], axis=-1)
    image = np.tile(np.array(bytes_of(SKY), np.uint8), (30, 40, 1))
    nearest, shared = np.full((30, 40), FAR), np.zeros((30, 40), bool)
    for number, model in enumerate(boxes):
        to_box = matrix_of(model.pose.inverse() @ looking(camera))
        start, directions = to_box[:, 3], rays @ to_box[:, :3].T
        half = np.array(model.links[0].visuals[0].geometry.size) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (-half - start) / directions, (half - start) / directions
        enters, leaves = np.minimum(first, second).max(axis=2), np.maximum(first, second).min(axis=2)
        inside = (enters < leaves) & (enters >= NEAR)
        hit, level = inside & (enters < nearest), inside & np.isclose(enters, nearest, rtol=1e-6)
        shared = level | (shared & ~hit)
        nearest[hit] = enters[hit]
        image[hit] = bytes_of(color(number))
    return image, shared


sizes = st.tuples(*[st.floats(0.2, 2.0)] * 3)
angles = st.floats(-pi, pi)
places = st.builds(
    lambda x, y, z, a, b, c: Pose.from_rpy((x, y, z), a, b, c),
    st.floats(1.0, 8.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), angles, angles, angles,
)  # fmt: skip


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(sizes, places), min_size=1, max_size=5), st.floats(-0.5, 0.5))
def test_every_pixel_shows_the_nearest_box_on_its_ray(boxes, heading):
    camera = Pose.from_rpy((0.1, -0.2, 0.3), 0.1, -0.1, heading)
    models = [box(number, size, pose) for number, (size, pose) in enumerate(boxes)]
    image = cameras(*models, eye(camera)).image(CAMERA)
    expected, shared = cast(models, camera)
    # where a ray passes within rounding of an edge, or two faces nearly share a plane, both answers are right
    assert ((image != expected).any(axis=2) & ~shared).mean() < 0.005


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(sizes, places), min_size=1, max_size=5), st.sets(st.integers(0, 4)), st.data())
def test_colors_are_counted_without_the_image_that_has_them(boxes, meant, data):
    models = [box(number, size, pose) for number, (size, pose) in enumerate(boxes)]
    drawn = cameras(*models, eye(Pose.from_rpy((0.1, -0.2, 0.3), 0.1, -0.1, 0.2)))
    hidden = data.draw(st.integers(0, len(models) - 1))
    drawn.set_color(f"box{hidden}/link/visual", (0.0, 0.0, 1.0, 0.0))
    image = SeenImage.of(Header(), drawn.look(CAMERA))
    chosen = frozenset(bytes_of(color(number)) for number in meant)
    counts = image.count_colors(ChosenColors(chosen))
    found = np.array([[tuple(pixel) in chosen for pixel in row] for row in drawn.image(CAMERA).tolist()])
    assert counts == (found[:, :20].sum(), found[:, 20:].sum())


class ChosenColors:
    """Chooses some colours."""

    def __init__(self, chosen):
        self._chosen = chosen

    def __call__(self, palette):
        return np.array([tuple(each) in self._chosen for each in palette.tolist()])


def test_an_image_that_is_drawn_later_shows_its_moment():
    poses = {"thing": Pose((3.0, 0.0, 0.0))}
    thing = box(0, (1.0, 1.0, 1.0), Pose())
    links = (replace(thing.links[0], inertial=Inertial(1.0)),)
    thing = replace(thing, name="thing", links=links, static=False)
    drawn = cameras(thing, eye(), poses=poses)
    before = drawn.image(CAMERA)
    image, other = (SeenImage.of(Header(), drawn.look(CAMERA)) for _ in range(2))
    poses["thing"] = Pose((2.0, 0.5, 0.0))
    drawn.set_color("thing/link/visual", (0.0, 1.0, 0.0, 1.0))
    assert (drawn.image(CAMERA) != before).any()
    assert (image.data == before).all()
    assert not image.data.flags.writeable
    loaded = pickle.loads(pickle.dumps(other))
    assert type(loaded) is Image
    assert (loaded.data == before).all()
    assert repr(loaded) == repr(image)
    assert (loaded.height, loaded.width, loaded.encoding, loaded.step) == (30, 40, "rgb8", 120)
    again = drawn.copy(lambda _: lambda frames: None)
    assert again.look(CAMERA).palette.tolist() == image_palette(before)


def test_an_image_that_another_thread_is_drawing_has_its_pixels(monkeypatch):
    plain, found = seen_image._data, []

    class ReadFirst:
        """Stores data, and reads them just before, as another thread may."""

        __get__ = plain.__get__

        def __set__(self, image, data):
            if not found:
                found.append(None)
                found[0] = image.data.shape
            plain.__set__(image, data)

    image = SeenImage.of(Header(), cameras(eye()).look(CAMERA))
    monkeypatch.setattr(seen_image, "_data", ReadFirst())
    assert image.data.shape == (30, 40, 3)
    assert found == [(30, 40, 3)]


def image_palette(image):
    """Return the colours of the only visual and of the sky."""
    return [image[15, 20].tolist(), list(bytes_of(SKY))]


def test_every_pixel_of_boxes_with_faces_in_one_plane_shows_one_of_them():
    turned = Pose.from_rpy((1.0, 0.0, 0.0), 1.0, 0.0, 0.0)
    camera = Pose.from_rpy((0.1, -0.2, 0.3), 0.1, -0.1, 0.0)
    models = [
        box(number, (1.0, 1.0, 1.0), turned if number == 2 else Pose((1.0, 0.0, 0.0))) for number in range(3)
    ]
    expected, shared = cast(models, camera)
    image = cameras(*models, eye(camera)).image(CAMERA)
    seen = {tuple(pixel) for pixel in image[shared].tolist()}
    assert shared.any()
    assert seen <= {tuple(bytes_of(color(number))) for number in range(3)}
    assert ((image != expected).any(axis=2) & ~shared).mean() < 0.005


def test_neighbouring_triangles_leave_no_gap():
    wall = box(0, (0.1, 30.0, 30.0), Pose.from_rpy((3.0, 0.0, 0.0), 0.3, 0.1, 0.2))
    assert (cameras(wall, eye()).image(CAMERA) == bytes_of(color(0))).all()


def test_a_floor_that_passes_below_the_camera_is_cut_at_the_near_plane():
    floor = box(0, (100.0, 100.0, 1.0), Pose((0.0, 0.0, -1.0)))
    image = cameras(floor, eye()).image(CAMERA)
    assert (image[-5:] == bytes_of(color(0))).all()
    assert (image[:15] == bytes_of(SKY)).all()


def test_objects_beyond_the_clip_distance_are_not_seen():
    wall = box(0, (1.0, 30.0, 30.0), Pose((FAR + 0.6, 0.0, 0.0)))
    assert (cameras(wall, eye()).image(CAMERA) == bytes_of(SKY)).all()


def test_a_box_is_not_seen_from_inside():
    around = box(0, (5.0, 5.0, 5.0), Pose())
    assert (cameras(around, eye()).image(CAMERA) == bytes_of(SKY)).all()


def test_colours_change_and_things_vanish_at_once():
    renderer = cameras(box(0, (0.1, 30.0, 30.0), Pose((3.0, 0, 0))), eye())
    renderer.set_color("box0/link/visual", (1.0, 0.0, 0.0, 1.0))
    assert (renderer.image(CAMERA) == (255, 0, 0)).all()
    renderer.set_color("box0/link/visual", (1.0, 0.0, 0.0, 0.0))
    assert (renderer.image(CAMERA) == bytes_of(SKY)).all()


def test_a_moving_camera_is_read_before_each_image():
    poses = {"eye": Pose()}
    renderer = cameras(box(0, (0.1, 30.0, 30.0), Pose((3.0, 0, 0))), eye(static=False), poses=poses)
    assert (renderer.image(CAMERA) == bytes_of(color(0))).all()
    poses["eye"] = Pose.from_rpy((0, 0, 0), 0, 0, pi)
    assert (renderer.image(CAMERA) == bytes_of(SKY)).all()


def test_a_scene_without_visuals_is_all_sky():
    assert (cameras(eye()).image(CAMERA) == bytes_of(SKY)).all()


def test_an_unknown_visual_has_no_colour_to_set():
    with pytest.raises(KeyError):
        cameras(eye()).set_color("no/such/visual", (1.0, 0.0, 0.0, 1.0))
