"""Videos of a recording."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from itertools import product
from math import tan
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from golden import Golden
from hypothesis import example, given
from hypothesis import strategies as st

from nrp_core.dsl.testing import MockBrain
from nrp_core.errors import ExperimentError
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.recording.figures.room import Bounds
from nrp_core.recording.figures.story import Story, Track
from nrp_core.recording.folder.recording_folder import lights_data
from nrp_core.recording.layout import Images, Role
from nrp_core.recording.recording import Recording
from nrp_core.recording.video import Renderer, VideoOptions, ViewKind, check_target, video
from nrp_core.recording.video.file import times_of, write_video
from nrp_core.recording.video.views import (
    FIELD_OF_VIEW,
    Follower,
    _follower,
    drawn_frames,
    free,
    from_above,
    look_at,
    recorded_lights,
)
from nrp_core.recording.writing.recorder import McapRecorder
from nrp_core.scene.model import Box, Light, Link, Model, Scene, Texture, Visual
from nrp_core.scene.rigid import Pose

NOTHING = np.empty((0, 2, 3))
coordinates = st.floats(-10.0, 10.0)
points = st.tuples(coordinates, coordinates, coordinates)


@pytest.fixture
def recording(make_rig: Any) -> Recording:
    """Half a second in which the glass turns green."""
    rig = make_rig(Images.EXACT)
    for step in range(25):
        rig.step(forward=2.0, turn=0.0)
        if step == 12:
            rig.world.advertise("/wall/body/glass/color").publish(ColorRGBA(g=1.0))
    rig.recorder.close()
    return Recording(rig.folder)


def frames(path: Path) -> list[Any]:
    capture = cv2.VideoCapture(str(path))
    read = []
    while (image := capture.read())[0]:
        read.append(image[1])
    return read


@pytest.mark.one_of(3)
@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_a_video_has_the_size_the_length_and_the_codec_that_browsers_play(
    recording: Recording, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"run{suffix}"
    count = video(recording, path, VideoOptions(width=160, height=120, speed=0.5, rate_hz=20.0))
    capture = cv2.VideoCapture(str(path))
    assert count == 21 == len(frames(path))
    assert capture.get(cv2.CAP_PROP_FPS) == 20.0
    codec = int(capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").lower()
    assert codec in ((b"vp80", b"vp08") if suffix == ".webm" else (b"h264", b"avc1"))
    assert frames(path)[0].shape == (120, 160, 3)


@pytest.mark.one_of(2)
@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_equal_images_of_odd_sides_are_equal_files(tmp_path: Path, suffix: str) -> None:
    images = [np.full((31, 47, 3), (8 * i, 200, 40), np.uint8) for i in range(12)]
    first, second = (tmp_path / f"{name}{suffix}" for name in ("first", "second"))
    for path in (first, second):
        assert write_video(path, iter(images), 25.0, len(images), None) == 12 == len(frames(path))
    assert first.read_bytes() == second.read_bytes()
    drawn, read = np.stack(images)[..., ::-1].astype(int), np.stack(frames(first)).astype(int)
    assert np.abs(read[:, :31, :47] - drawn).max() < 12


def test_a_video_without_its_library_names_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ExperimentError, match=r"nrp-core\[video\]"):
        check_target(tmp_path / "run.mp4")


def test_a_visual_that_turns_green_is_green_in_the_video(recording: Recording) -> None:
    options = VideoOptions(
        view=ViewKind.FREE, eye=(0.0, 0.0, 1.0), target=(3.0, 0.0, 1.0), width=64, height=64
    )
    images = list(drawn_frames(recording, np.array([0.1, 0.4]), options))
    before, after = (image[32, 32].astype(int) for image in images)
    assert before[2] > 100 > before[1]
    assert after[1] > 100 > after[2]


@pytest.mark.heavy
@pytest.mark.usefixtures("site")
def test_a_realistic_video_has_the_lights_of_the_recording(recording: Recording) -> None:
    lights = (
        Light("sun", direction=(0.0, 0.6, -0.8), diffuse=(1.0, 0.5, 0.25, 1.0)),
        Light("lamp", "spot", Pose((1, 2, 3)), (0, 0, -1), cone=(0.4, 0.8), attenuation=(5, 1, 0, 0.1)),
    )
    kept = json.loads(json.dumps({"world": {"lights": lights_data(Scene((), lights))}}))
    for light, read in zip(lights, recorded_lights(kept), strict=True):
        assert (read.kind, read.direction, read.diffuse) == (light.kind, light.direction, light.diffuse)
        assert (read.pose, read.cone, read.attenuation) == (light.pose, light.cone, light.attenuation)
    options = VideoOptions(width=80, height=60, view=ViewKind.ABOVE)
    shaded = next(drawn_frames(recording, np.array([0.4]), options))
    lit = next(drawn_frames(recording, np.array([0.4]), replace(options, renderer=Renderer.REALISTIC)))
    assert lit.shape == shaded.shape
    assert (lit != shaded).any()


def test_an_image_on_a_wall_is_seen_upright_and_not_mirrored_in_the_video(
    brain: MockBrain, tmp_path: Path
) -> None:
    """Red and green are above blue and white."""
    from experiment_fakes import DiscBackend, DiscOptions

    quadrants = np.array([[(0, 0, 255), (0, 255, 0)], [(255, 0, 0), (255, 255, 255)]], np.uint8)
    cv2.imwrite(str(tmp_path / "q.png"), cv2.resize(quadrants, (64, 64), interpolation=cv2.INTER_NEAREST))
    picture = Visual("picture", Box((0.1, 2.0, 2.0)), texture=Texture(tmp_path / "q.png", content="q"))
    scene = Scene((Model("wall", (Link("body", visuals=(picture,)),), static=True),))
    with DiscBackend().open(scene, seed=1, options=DiscOptions()) as world:
        recorder = McapRecorder(brain, world, tmp_path, period_ns=20_000_000)
        brain.run_until(20_000_000)
        world.run_until(20_000_000)
        recorder.step()
        recorder.close()
    options = VideoOptions(
        view=ViewKind.FREE, eye=(-3.0, 0.0, 0.0), target=(0.0, 0.0, 0.0), width=64, height=64
    )
    (image,) = drawn_frames(Recording(tmp_path), np.array([0.0]), options)
    expected = {(24, 24): {0}, (24, 40): {1}, (40, 24): {2}, (40, 40): {0, 1, 2}}
    for (row, column), brightest in expected.items():  # red, green and blue
        assert {n for n, value in enumerate(image[row, column].tolist()) if value > 100} == brightest


def test_a_robot_moves_through_the_view_from_above(recording: Recording) -> None:
    options = VideoOptions(view=ViewKind.ABOVE, width=120, height=60)
    first, last = drawn_frames(recording, np.array([0.0, 0.5]), options)
    changed = np.argwhere(np.any(first != last, axis=2))
    assert np.ptp(changed[:, 1]) > 10


def test_a_camera_s_images_are_shown_as_they_were(
    recording: Recording, tmp_path: Path, golden: Golden
) -> None:
    assert video(recording, tmp_path / "eye.mp4", VideoOptions(camera="camera")) == 13
    assert frames(tmp_path / "eye.mp4")[0].shape == (2, 2, 3)
    with golden.raises(ExperimentError, match="'camra'.*'camera'"):
        video(recording, tmp_path / "other.mp4", VideoOptions(camera="camra"))


@pytest.mark.heavy
def test_shells_complete_the_cameras_of_a_recording(recording: Recording) -> None:
    (topic,) = recording.with_role(Role.CAMERA)
    named = [topic.name, *sorted(topic.name.strip("/").split("/"))]
    for before, expected in ((recording.file.parent, named), ("no_recording", [])):
        words = ["nrp", "video", str(before), "--camera"]
        environment = {
            **os.environ, "_NRP_COMPLETE": "complete_bash", "COMP_WORDS": " ".join([*words, ""]),
            "COMP_CWORD": str(len(words)),
        }  # fmt: skip
        done = subprocess.run(
            [sys.executable, "-m", "nrp_core"], env=environment, capture_output=True, text=True
        )
        assert done.stdout.split() == expected


def test_a_robot_that_stands_is_followed_rather_than_a_thing_that_swings(recording: Recording) -> None:
    story = Story.of(recording)
    story.tracks["pendulum"] = Track([0.0, 0.5], [0.0, 9.0], [0.0, 0.0], [0.0, 0.0])
    story.first_poses["pendulum"] = Pose((50.0, 0.0, 0.0))
    for robots, at_m in (({"husky": {}}, 0.0), ({}, 50.0)):
        recording.run["settings"] = {"world": {"robots": robots}}
        eye = _follower(story, None, recording).eye(0.0, story.first_poses)
        assert eye[0, 3] == pytest.approx(at_m, abs=10.0)


def test_an_impossible_video_is_refused(recording: Recording, tmp_path: Path, golden: Golden) -> None:
    with golden.raises(ExperimentError, match=r"0\.5"):
        times_of(recording, VideoOptions(begin_s=7.0))
    with golden.raises(ExperimentError, match="'huskey'.*'husky'"):
        next(drawn_frames(recording, np.array([0.0]), VideoOptions(robot="huskey")))
    with pytest.raises(ExperimentError, match=r"not 'run\.avi'"):
        check_target(tmp_path / "run.avi")
    with golden.raises(ExperimentError):
        check_target(tmp_path / "nowhere" / "run.mp4")


@given(points, points)
@example((0.0, 0.0, 1.0), (0.0, -8e-9, 0.0))  # straight down but for rounding
def test_a_camera_that_looks_at_a_point_has_it_in_its_middle(
    eye: tuple[float, float, float], target: tuple[float, float, float]
) -> None:
    if np.linalg.norm(np.subtract(eye, target)) < 0.01:
        return
    pose = look_at(eye, target)
    turn = pose[:, :3]
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    x, y, z = turn.T @ np.subtract(target, eye)
    assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert z < 0  # graphics look along -z
    assert turn[2, 1] >= -1e-6  # upright


def test_the_view_from_above_holds_its_bounds() -> None:
    pose = from_above(Bounds(-1.0, 3.0, -2.0, 2.0), 2.0).eye(0.0, {})
    half = pose[2, 3] * tan(FIELD_OF_VIEW / 2)
    assert (pose[0, 3], pose[1, 3]) == (1.0, 0.0)
    assert half == pytest.approx(2.0)


def test_a_follower_is_behind_its_robot_and_rises_where_something_hides_it() -> None:
    poses = {"car/base": Pose((1.0, 2.0, 0.1))}
    x, y, z = Follower("car/base", 1.0, NOTHING).eye(0.0, poses)[:, 3]
    assert x < 1.0 - 2.0
    assert y == pytest.approx(2.0)
    assert z > 1.0
    raised = Follower("car/base", 1.0, NOTHING, (0.0, 0.0, 0.5)).eye(0.0, poses)[:, 3]
    assert raised == pytest.approx((x, y, z + 0.5))
    wall = np.array([[(-0.2, -5.0, 0.0), (0.0, 5.0, 2.0)]])
    *_, risen = Follower("car/base", 1.0, wall).eye(0.0, poses)[:, 3]
    assert risen > z + 0.5


def test_a_robot_of_any_size_fills_the_same_share_of_the_image() -> None:
    def distance(size_m: float) -> float:
        return float(np.linalg.norm(Follower("it/base", size_m, NOTHING).eye(0.0, {"it/base": Pose()})[:, 3]))

    for size_m in (0.0025, 0.14, 30.0):
        assert distance(size_m) == pytest.approx(size_m * distance(1.0))
    assert distance(0.0) == distance(0.5)  # no shape is known


@given(
    left=coordinates,
    bottom=coordinates,
    wide=st.floats(0.01, 50),
    deep=st.floats(0.01, 50),
    top=st.floats(0, 5),
)
def test_the_free_camera_has_all_that_moves_in_its_image(
    left: float, bottom: float, wide: float, deep: float, top: float
) -> None:
    eye = free(Bounds(left, left + wide, bottom, bottom + deep), top, 4 / 3, None, None).eye(0.0, {})
    corners = np.array(list(product((left, left + wide), (bottom, bottom + deep), (0.0, top))))
    x, y, z = ((corners - eye[:, 3]) @ eye[:, :3]).T
    high = np.abs(y / -z).max() / tan(FIELD_OF_VIEW / 2)
    across = np.abs(x / -z).max() / tan(FIELD_OF_VIEW / 2) * 3 / 4
    assert (z < 0).all()
    assert 0.7 < max(high, across) < 0.9
