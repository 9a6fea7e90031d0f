"""Images on surfaces are seen where they are, in every renderer of ours."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.sdf import read_scene
from nrp_core.world.backends import worlds
from nrp_core.world.render.portrait import portrait
from nrp_core.world.world import World

RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
QUADRANTS = np.array([[RED, GREEN], [BLUE, WHITE]], np.uint8)
"""Red and green above blue and white."""
SQUARE = """mtllib a.mtl\nusemtl poster\nv 0 .5 -.5\nv 0 -.5 -.5\nv 0 -.5 .5\nv 0 .5 .5
vt 0 0\nvt {n} 0\nvt {n} {n}\nvt 0 {n}\nf 1/1 2/2 3/3 4/4\n"""
PBR = (
    "<material><pbr><metal><albedo_map>poster.png</albedo_map><metalness>0</metalness></metal></pbr>"
    "</material>"
)
BOX = f'<visual name="v"><geometry><box><size>1 1 1</size></box></geometry>{PBR}</visual>'
MESH = '<visual name="v"><geometry><mesh><uri>{}</uri></mesh></geometry></visual>'
WALL = '<model name="wall"><static>1</static><pose>{} 0 0 0 0 0</pose><link name="l">{}</link></model>'
EYE = (
    '<model name="eye"><static>1</static><link name="l"><sensor name="c" type="camera">'
    "<update_rate>50</update_rate><topic>/seen</topic><camera><horizontal_fov>0.4</horizontal_fov>"
    "<image><width>40</width><height>40</height></image></camera></sensor></link></model>"
)
MS = 1_000_000
ENGINES = pytest.mark.parametrize("engine", ["mujoco", "pybullet"])


@pytest.fixture
def home(tmp_path: Path) -> Path:
    large = cv2.resize(QUADRANTS[..., ::-1], (64, 64), interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(tmp_path / "poster.png"), large)
    (tmp_path / "a.mtl").write_text("newmtl poster\nmap_Kd poster.png\n")
    (tmp_path / "once.obj").write_text(SQUARE.format(n=1))
    (tmp_path / "twice.obj").write_text(SQUARE.format(n=2))
    return tmp_path


def room(home: Path, visual: str, x: float = 3.0) -> Path:
    file = home / "room.sdf"
    file.write_text(f'<sdf version="1.9"><world name="w">{WALL.format(x, visual)}{EYE}</world></sdf>')
    return file


def opened(file: Path, renderer: str = "raster", engine: str = "mujoco") -> World:
    backend = worlds().load(engine)
    return backend.open(read_scene(file), seed=1, options=backend.options(renderer=renderer))


def seen(world: World) -> npt.NDArray[np.uint8]:
    heard = world.subscribe("/seen")
    world.run_until(world.now_ns + 20 * MS)
    assert heard.latest is not None
    image: npt.NDArray[np.uint8] = heard.latest.message.data
    return image


def quarters(image: npt.NDArray[np.uint8], low: int, high: int) -> list[list[tuple[int, ...]]]:
    """Return the pixels in the middles of the quarters of a part of an image."""
    at = [low + (high - low) // 4, low + 3 * (high - low) // 4]
    return [[tuple(image[row, column].tolist()) for column in at] for row in at]


@pytest.mark.parametrize(("visual", "x"), [(BOX, 3.5), (MESH.format("once.obj"), 3.0)], ids=["box", "mesh"])
@ENGINES
def test_an_image_is_upright_and_not_mirrored(home: Path, visual: str, x: float, engine: str) -> None:
    with opened(room(home, visual, x), engine=engine) as world:
        image = seen(world)
    assert quarters(image, 4, 36) == [[RED, GREEN], [BLUE, WHITE]]


def test_light_falls_on_images_as_on_colours(home: Path) -> None:
    with opened(room(home, BOX, 3.5), "realistic") as world:
        (upper_left, upper_right), (lower_left, white) = quarters(seen(world), 4, 36)
    assert 20 < white[0] == white[1] == white[2]  # grey light
    assert (upper_left[0], upper_right[1], lower_left[2]) == pytest.approx((white[0],) * 3, abs=white[0] / 3)
    assert upper_left[0] > 3 * upper_left[1]  # beside the plain reflection of its finish


def test_places_beyond_an_image_repeat_it(home: Path) -> None:
    with opened(room(home, MESH.format("twice.obj"))) as world:
        image = seen(world)
    quarter = [[RED, GREEN], [BLUE, WHITE]]
    left, right = image[4:20], image[20:36]
    assert quarters(np.ascontiguousarray(left[:, 4:20]), 0, 16) == quarter
    assert quarters(np.ascontiguousarray(right[:, 20:36]), 0, 16) == quarter


@ENGINES
def test_another_colour_covers_the_image_until_its_own_comes_back(home: Path, engine: str) -> None:
    with opened(room(home, BOX, 3.5), engine=engine) as world:
        own = world.subscribe("/wall/l/v/color").latest
        paint = world.advertise("/wall/l/v/color")
        paint.publish(ColorRGBA(1.0, 0.0, 1.0, 1.0))
        assert quarters(seen(world), 4, 36) == [[(255, 0, 255)] * 2] * 2
        assert own is not None
        paint.publish(own.message)
        assert quarters(seen(world), 4, 36) == [[RED, GREEN], [BLUE, WHITE]]


@ENGINES
def test_an_image_is_hidden_by_what_is_in_front_of_it(home: Path, engine: str) -> None:
    before = (
        "<visual name='left'><pose>-1 .25 0 0 0 0</pose><geometry><box><size>.1 .4 2</size></box></geometry>"
    )
    before += "<material><diffuse>1 0 1 1</diffuse></material></visual>"
    with opened(room(home, BOX + before, 3.5), engine=engine) as world:
        assert quarters(seen(world), 4, 36) == [[(255, 0, 255), GREEN], [(255, 0, 255), WHITE]]


def test_a_far_image_is_its_mean_and_does_not_flicker(home: Path) -> None:
    fine = np.indices((256, 256)).sum(axis=0) % 2 * 255  # a board of single pixels
    cv2.imwrite(str(home / "poster.png"), fine.astype(np.uint8))
    with opened(room(home, BOX, 3.5)) as world:
        near = seen(world)[8:32, 8:32]
    assert np.abs(near.astype(int) - 127.5).max() < 10


def test_a_portrait_shows_images(home: Path) -> None:
    image = portrait(read_scene(room(home, BOX)), 200, 150).reshape(-1, 3).astype(int)
    for channel in range(3):
        others = np.delete(image, channel, axis=1).max(axis=1)
        assert (image[:, channel] - others > 80).sum() > 50


def test_an_image_that_vanished_leaves_its_mean(home: Path) -> None:
    scene = read_scene(room(home, BOX, 3.5))
    (home / "poster.png").unlink()
    backend = worlds().load("mujoco")
    with backend.open(scene, seed=1, options=backend.options(renderer="raster")) as world:
        image = seen(world)
    assert quarters(image, 4, 36) == [[(128, 128, 128)] * 2] * 2
