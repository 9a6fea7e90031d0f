"""Segmentation and wide-angle cameras on both engines, against geometry, an image and OpenCV."""

from __future__ import annotations

from collections.abc import Callable
from math import atan, cos, pi, sin, tan
from pathlib import Path

import cv2
import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_scene
from nrp_core.world.render.cameras import SKY, bytes_of

CAMERA = "<image><width>{0}</width><height>{1}</height></image><clip><near>0.02</near></clip>"
LABEL = '<plugin filename="gz-sim-label-system" name="gz::sim::systems::Label"><label>{}</label></plugin>'
EYE = (
    '<model name="eye"><static>1</static><link name="body"><sensor name="s" type="{0}">'
    "<update_rate>50</update_rate><gz_frame_id>lens</gz_frame_id><camera>{1}</camera></sensor>{2}</link></model>"
)
LENSES: dict[str, tuple[float, float, Callable[[float], float]]] = {
    "equidistant": (pi, 1.2, lambda theta: theta),
    "stereographic": (2.4, 1.1, lambda theta: 2 * tan(theta / 2)),
    "equisolid_angle": (5.0, 2.2, lambda theta: 2 * sin(theta / 2)),  # behind the camera, too
}


def thing(name: str, place: str, shape: str, color: str, *, of_visual: str = "", of_model: str = "") -> str:
    look = f"<material><diffuse>{color}</diffuse></material>"
    visual = f'<visual name="v"><geometry>{shape}</geometry>{look}{of_visual}</visual>'
    link = f'<link name="l"><pose>{place} 0 0 0</pose>{visual}</link>'
    return f'<model name="{name}"><static>1</static>{link}{of_model}</model>'


def scene(folder: Path, *models: str) -> Scene:
    file = folder / "room.world"
    file.write_text(f'<sdf version="1.9"><world name="w">{"".join(models)}</world></sdf>')
    return read_scene(file)


@pytest.fixture
def seen(open_world, advance, tmp_path):
    """Return the first message of each topic of a camera that looks at models."""

    def seen(kind: str, camera: str, *models: str, further: str = "", **topics: str):
        world = open_world(scene(tmp_path, EYE.format(kind, camera, further), *models))
        heard = {name: world.subscribe(f"/eye/body/{topic}") for name, topic in topics.items()}
        advance(world, 0.02)
        return {name: each.latest.message for name, each in heard.items()}

    return seen


@pytest.mark.parametrize("lens", LENSES)
def test_a_point_is_seen_where_the_lens_puts_it(seen, lens: str) -> None:
    fov, theta, mapped = LENSES[lens]
    width, height, turn = 240, 200, 2.3
    direction = cos(theta), -sin(theta) * cos(turn), sin(theta) * sin(turn)  # ahead, left, up
    place = " ".join(f"{2 * part:.12f}" for part in direction)
    camera = (
        f"<horizontal_fov>{fov}</horizontal_fov>{CAMERA.format(width, height)}"
        f"<lens><type>{lens}</type><cutoff_angle>3.1415</cutoff_angle></lens>"
    )
    ball = thing("ball", place, "<sphere><radius>0.08</radius></sphere>", "1 0 0 1")
    found = seen("wideanglecamera", camera, ball, image="s/image", info="s/camera_info")
    image, info = found["image"], found["info"]
    rows, columns = np.nonzero((image.data == (255, 0, 0)).all(axis=2))
    radius = mapped(theta) / mapped(fov / 2) * width / 2
    expected = width / 2 + radius * cos(turn), height / 2 - radius * sin(turn)
    assert (columns.mean() + 0.5, rows.mean() + 0.5) == pytest.approx(expected, abs=1.0)
    assert info.header.frame_id == image.header.frame_id == "eye/lens"
    if theta < pi / 2:  # OpenCV projects only what is in front
        x, y, z = -direction[1], -direction[2], direction[0]
        projected, _ = cv2.fisheye.projectPoints(
            np.array([[[x, y, z]]]), np.zeros(3), np.zeros(3), info.k.reshape(3, 3), info.d
        )
        assert projected.ravel() == pytest.approx(expected, abs=0.5)


def test_pixels_outside_the_field_of_a_lens_are_black(seen) -> None:
    camera = f"<horizontal_fov>3</horizontal_fov>{CAMERA.format(80, 80)}<lens><type>equidistant</type></lens>"
    image = seen("wide_angle_camera", camera, image="s/image")["image"].data
    dark = (image == 0).all(axis=2)
    down, right = np.mgrid[:80, :80] + 0.5 - 40
    shown = np.hypot(down, right) * 3 / 80 <= pi / 2  # the default of <cutoff_angle>
    assert (dark == ~shown).mean() > 0.99
    assert dark[0, 0]
    assert not dark[40, 40]


@pytest.mark.parametrize("kind", ["semantic", "panoptic"])
def test_labels_are_those_of_what_is_seen_at_each_pixel(seen, kind: str) -> None:
    box = "<box><size>0.4 0.4 0.4</size></box>"
    models = (
        thing("near", "2 0.6 0", box, "1 0 0 1", of_model=LABEL.format(5)),
        thing("far", "3 -0.2 0.1", box, "0 1 0 1", of_model=LABEL.format(5)),
        thing("other", "2 -0.6 0", box, "0 0 1 1", of_visual=LABEL.format(9), of_model=LABEL.format(5)),
        thing("bare", "2.5 0.2 0.5", box, "1 1 0 1"),
    )
    camera = f"<segmentation_type>{kind}</segmentation_type>{CAMERA.format(64, 48)}"
    beside = f'<sensor name="c" type="camera"><camera>{CAMERA.format(64, 48)}</camera></sensor>'
    topics = {"labels": "s/segmentation/labels_map", "colors": "s/segmentation/colored_map"}
    found = seen("segmentation", camera, *models, further=beside, image="c/image", **topics)
    labels, colors, image = (found[name].data for name in ("labels", "colors", "image"))
    # low byte of the instance, its high byte, label: gz-sim's layout
    expected = {
        (255, 0, 0): (1, 0, 5),
        (0, 255, 0): (2, 0, 5),
        (0, 0, 255): (1, 0, 9),
        (255, 255, 0): (0, 0, 0),
        bytes_of(SKY): (0, 0, 0),
    }
    looks = set()
    for color, (low, high, label) in expected.items():
        shown = (image == color).all(axis=2)
        assert shown.any()
        assert (labels[shown] == ((low, high, label) if kind == "panoptic" else (label,) * 3)).all()
        (look,) = np.unique(colors[shown], axis=0)
        looks.add(tuple(look.tolist()))
    assert (0, 0, 0) in looks
    assert len(looks) == (4 if kind == "panoptic" else 3)
    assert found["labels"].encoding == "rgb8"


@pytest.mark.parametrize(
    ("kind", "camera", "words"),
    [
        ("segmentation", "<segmentation_type>panoptik</segmentation_type>", "'panoptic'"),
        ("wideanglecamera", "<lens><type>fisheye</type></lens>", "'fisheye'.*<lens>"),
        ("wideanglecamera", "<horizontal_fov>7</horizontal_fov>", ""),
        (
            "wideanglecamera",
            "<horizontal_fov>6.2</horizontal_fov><lens><type>gnomonical</type></lens>",
            "<horizontal_fov>.*6.2",
        ),
    ],
)
def test_a_camera_that_cannot_be_is_refused(
    tmp_path: Path, kind: str, camera: str, words: str, golden: Golden
) -> None:
    with golden.raises(SceneError, match=words):
        scene(tmp_path, EYE.format(kind, camera, ""))


def test_a_label_of_more_than_a_byte_is_refused(tmp_path: Path, golden: Golden) -> None:
    box = "<box><size>1 1 1</size></box>"
    with golden.raises(SceneError, match="<label>.*255.*256"):
        scene(tmp_path, thing("big", "0 0 0", box, "1 0 0 1", of_model=LABEL.format(256)))


def test_the_focal_length_of_a_camera_may_be_given_in_pixels(tmp_path: Path, golden: Golden) -> None:
    given = "<intrinsics><fx>{0}</fx><fy>50</fy><cx>40</cx><cy>30</cy><s>0</s></intrinsics>"
    bent = "<distortion><k1>0.0</k1><p2>-0</p2></distortion>"
    camera = f"{CAMERA.format(80, 60)}{bent}<lens>{{}}</lens>"
    read = scene(tmp_path, EYE.format("camera", camera.format(given.format(50)), ""))
    assert read.models[0].links[0].sensors[0].horizontal_fov == pytest.approx(2 * atan(40 / 50))  # type: ignore[attr-defined]
    assert read.warnings == ()
    (warning,) = scene(tmp_path, EYE.format("camera", camera.format(given.format(80)), "")).warnings
    golden(str(warning))
