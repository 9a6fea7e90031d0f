"""The figure, and the story it is drawn from."""

import json
import re
import sys
from itertools import combinations
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from nrp_core.errors import ExperimentError
from nrp_core.recording.figures import check_target, plot
from nrp_core.recording.figures.labels import keep_apart
from nrp_core.recording.figures.page import draw_page
from nrp_core.recording.figures.room import footprint
from nrp_core.recording.figures.story import Coloured, StepSeries, Story, moments, numbers_in, pictures
from nrp_core.recording.figures.style import style
from nrp_core.recording.figures.traces import by_unit, groups, moving, short_labels
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, Pictures, Role
from nrp_core.recording.reading.recording import Recorded, RecordedTopic, Recording
from nrp_core.recording.writing.scenery import markers
from nrp_core.recording.writing.writer import McapFile
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Box, Capsule, Cylinder, Link, Mesh, Model, Scene, Visual

GLASS = "/wall/body/glass/color"
RED, BLUE = ColorRGBA(1.0), ColorRGBA(b=1.0)


@pytest.fixture
def recording(rig: Any) -> Recording:
    """Twenty steps, in which the glass is red from 0.1 to 0.2 s and again from 0.3 s on."""
    for step in range(1, 21):
        rig.step()
        if step in (5, 10, 15):
            rig.world.advertise(GLASS).publish(BLUE if step == 10 else RED)
    rig.recorder.close()
    told = {
        "experiment": "driving", "seed": 3, "state": "finished", "aliases": {"/glass/color": GLASS},
        "brain": {
            "backend": "mock", "populations": {"eyes": {"size": 3}, "wheels": {"size": 2}},
            "views": {"all_eyes": {"eyes": [[0, 3]]}, "left_eye": {"eyes": [[0, 1]]}},
        },
        "world": {"backend": "disc"},
        "result": {"criteria": {"near": {"passed": True}, "far": {"passed": None}}},
    }  # fmt: skip
    (rig.folder / RUN_NAME).write_text(json.dumps(told))
    return Recording(rig.folder)


def texts(figure: Any) -> set[str]:
    return {text.get_text() for text in figure.findobj(mpl.text.Text)}


def test_the_story_is_gathered_from_the_recording_alone(recording: Recording) -> None:
    story = Story.of(recording)
    assert story.end_s == pytest.approx(0.4)
    assert list(story.tracks) == ["husky"]
    assert len(story.tracks["husky"].xs) == 21
    assert {label for label, parts in story.spikes.items() if parts} == {"eyes", "wheels"}
    assert [one.unit for one in story.sinks.values()] == ["mV"]
    assert story.commands["/husky/cmd_vel.linear.x"].values == [0.5] * 20
    assert story.commands["/husky/cmd_vel.angular.z"].unit == "rad/s"


def test_times_of_another_colour_begin_and_end_with_its_changes(recording: Recording) -> None:
    story = Story.of(recording)
    assert story.coloured() == [
        Coloured("wall/body/glass", 0.1, 0.2, (1.0, 0.0, 0.0)),
        Coloured("wall/body/glass", 0.3, 0.4, (1.0, 0.0, 0.0)),
    ]
    assert story.name_of("wall/body/glass") == "glass"
    assert story.name_of("a_lamp/body/bulb") == "a lamp"


def test_the_page_names_everything_it_shows(recording: Recording) -> None:
    story = Story.of(recording)
    shown = texts(draw_page(story, pictures(recording, moments(story, 4))))
    times, dash = "\N{MULTIPLICATION SIGN}", "\N{EN DASH}"
    assert shown >= {
        "driving", f"mock {times} disc   ·   0.4 s   ·   seed 3", "✓ near", "? far", "Room from above",
        "Spikes", "left_eye", "all_eyes (other)", "wheels", "Devices (mV)", "Commands (m/s)",
        "Commands (rad/s)", "husky 0 s and 0.4 s", f"glass: 0.1{dash}0.2 s, 0.3{dash}0.4 s",
        "simulated time (s)",
    }  # fmt: skip


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_equal_recordings_give_equal_files(recording: Recording, tmp_path: Path, suffix: str) -> None:
    first, second = tmp_path / f"first{suffix}", tmp_path / f"second{suffix}"
    for path in (first, second):
        plot(recording, path)
    assert first.read_bytes() == second.read_bytes()


def test_a_recording_that_was_cut_is_drawn_as_far_as_it_goes(recording: Recording, tmp_path: Path) -> None:
    whole = recording.file.read_bytes()
    for part in (1, 2, 3):
        recording.file.write_bytes(whole[: len(whole) * part // 4])
        plot(Recording(recording.folder), tmp_path / "figure.png")


def test_a_recording_of_nothing_is_an_almost_empty_page(tmp_path: Path) -> None:
    McapFile(tmp_path / MCAP_NAME).close()
    shown = texts(draw_page(Story.of(Recording(tmp_path)), []))
    assert {"recording", "0 s"} <= shown


def test_a_brain_without_a_moving_body_is_drawn(make_rig: Any, tmp_path: Path) -> None:
    rig = make_rig(Pictures.OFF)
    rig.step(forward=0.0, turn=0.0)
    rig.recorder.close()
    story = Story.of(Recording(rig.folder))
    story.tracks.clear()
    story.markers.clear()
    assert "Room from above" not in texts(draw_page(story, []))


def test_pictures_are_taken_at_moments_that_matter_and_the_gaps_between() -> None:
    story = Story({}, end_s=40.0)
    story.colours["a/b/c"] = [(0.0, (0, 0, 1)), (5.0, (1, 0, 0)), (7.1, (0, 0, 1))]
    assert moments(story, 6) == pytest.approx([0.0, 6.05, 7.0, 18.0, 29.0, 40.0])
    assert moments(Story({}, end_s=8.0), 3) == [0.0, 4.0, 8.0]
    assert moments(Story({}), 3) == [0.0]


def test_there_are_no_more_pictures_than_the_camera_took(recording: Recording) -> None:
    taken = pictures(recording, [0.0, 0.001, 0.2, 9.0])
    assert [round(one.t_s, 3) for one in taken] == [0.0, 0.2, 0.4]
    assert all(one.pixels.shape == (2, 2, 3) for one in taken)


def test_a_neuron_is_shown_in_the_smallest_group_that_names_it(recording: Recording) -> None:
    shown = [(group.label, group.population, group.ids) for group in groups(Story.of(recording))]
    assert shown == [
        ("left_eye", "eyes", (0,)),
        ("all_eyes (other)", "eyes", (1, 2)),
        ("wheels", "wheels", (0, 1)),
    ]


def test_labels_lose_what_they_share() -> None:
    series = [StepSeries(label, "mV") for label in ("drive/left_wheel", "drive/right_wheel")]
    assert short_labels(series) == ["left_wheel", "right_wheel"]
    assert short_labels(series[:1]) == ["drive/left_wheel"]
    assert short_labels([StepSeries("x" * 100, "")])[0].startswith("…x")
    pulls = [StepSeries(f"turn/pulls/{i}", "Hz") for i in range(3)]
    assert short_labels(pulls) == ["pulls/0", "pulls/1", "pulls/2"]
    joints = [StepSeries(f"/walker/{side}_knee/cmd_pos", "") for side in ("left", "right")]
    assert short_labels(joints) == ["left_knee", "right_knee"]
    assert short_labels(joints[:1]) == ["cmd_pos"]
    legs = [StepSeries(f"move_{leg}/lifting", "Hz") for leg in ("left", "right")]
    assert short_labels(legs) == ["move_left/lifting", "move_right/lifting"]
    assert short_labels(legs, 15) == ["left", "right"]
    legs.append(StepSeries("move_left/forward", "Hz"))
    assert short_labels(legs, 15) == ["left/lifting", "right/lifting", "left/forward"]


def test_values_of_two_robots_are_told_apart() -> None:
    names = [f"/{robot}/cmd_vel" for robot in ("red", "blue")]
    story = Story({})
    for name in names:
        topic = RecordedTopic(name, "geometry_msgs/msg/Twist", "", {"role": Role.PUBLISHED.value})
        story._take(topic, Recorded(name, 0, Twist(Vector3(1.0))))
    assert short_labels(by_unit(moving(story.commands))["m/s"]) == [
        "red/cmd_vel.linear.x", "blue/cmd_vel.linear.x",
    ]  # fmt: skip


def test_names_on_the_map_stay_in_it_and_cover_no_other() -> None:
    figure = Figure(figsize=(4.0, 4.0))
    axes = figure.add_subplot(xlim=(0, 1), ylim=(0, 1), aspect="equal")
    labels = [
        axes.annotate(f"robot {x}", (x, 0.5), (0, 9), textcoords="offset points", ha="center")
        for x in (0.0, 0.1, 0.15, 1.0)
    ]
    keep_apart(axes, labels)
    frame, boxes = axes.get_window_extent(), [label.get_window_extent() for label in labels]
    assert all(box.x0 >= frame.x0 - 1 and box.x1 <= frame.x1 + 1 for box in boxes)
    assert not any(a.shrunk(0.9, 0.9).overlaps(b) for a, b in combinations(boxes, 2))


def test_many_devices_are_rows_of_colours_and_no_name_leaves_the_figure() -> None:
    sinks = {
        f"wheel_{i}": StepSeries(
            f"drive/wheel_number_{i}_of_the_robot", "mV", [0.1 * i, 1.0], [float(i), -1.0]
        )
        for i in range(18)
    }
    for count in (1, 3, 4, 18):
        story = Story({}, end_s=2.0, sinks=dict(list(sinks.items())[:count]))
        figure = draw_page(story, [])
        figure.draw_without_rendering()
        width, height = figure.bbox.size
        for text in figure.findobj(mpl.text.Text):
            box = text.get_window_extent()
            assert not text.get_text() or (box.x0 >= 0 and box.x1 <= width and box.y1 <= height), text
        images = [image for axes in figure.axes for image in axes.images if image.get_array().shape[0] == 18]
        assert len(images) == (count == 18)
    (rows,) = [image.get_array() for image in images]
    assert np.isnan(np.ma.filled(rows, np.nan)[17, 0])
    assert (rows[5, 300], rows[5, -1]) == (5.0, -1.0)


def test_all_of_a_robot_is_seen_and_its_many_joints_share_an_axis(make_rig: Any) -> None:
    rig = make_rig(Pictures.OFF)
    rig.step()
    rig.recorder.close()
    story = Story.of(Recording(rig.folder))
    boom = Model("husky", (Link("body", visuals=(Visual("boom", Box((9.0, 0.2, 0.2))),)),))
    story.markers = markers(Scene((boom,))).markers
    topics = [f"/husky/leg_{i}/cmd_pos" for i in range(6)]
    story.commands = {f"{one}.data": StepSeries(one, "", [0.0], [0.5]) for one in [*topics, "/husky/lamp"]}
    with style():
        figure = draw_page(story, [])
        figure.draw_without_rendering()
    titled = {axes.get_title(loc="left") or axes.get_title(): axes for axes in figure.axes}
    room = titled["Room from above"]
    low, high = room.get_xlim()
    assert low < -4.5
    assert high > 4.5
    assert room.yaxis.label.get_window_extent().x0 >= 0
    assert [title for title in titled if "cmd_pos" in title or "lamp" in title] == ["cmd_pos", "/husky/lamp"]


def test_numbers_are_found_wherever_they_are_in_a_message() -> None:
    found = dict(numbers_in(Twist(Vector3(1.0), Vector3(z=2.0))))
    assert found == {f"{part}.{axis}": 0.0 for part in ("linear", "angular") for axis in "xyz"} | {
        "linear.x": 1.0, "angular.z": 2.0,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("geometry", "pose", "low", "high"),
    [
        (Box((2.0, 1.0, 3.0)), Pose(), (-1.0, -0.5), (1.0, 0.5)),
        (Box((2.0, 1.0, 3.0)), Pose.from_rpy((5.0, 0.0, 0.0), 0.0, 0.0, np.pi / 2), (4.5, -1.0), (5.5, 1.0)),
        (Cylinder(0.5, 4.0), Pose(), (-0.5, -0.5), (0.5, 0.5)),
        (Cylinder(0.5, 4.0), Pose.from_rpy((0.0, 0.0, 0.0), np.pi / 2, 0.0, 0.0), (-0.5, -2.0), (0.5, 2.0)),
        (Capsule(0.5, 1.0), Pose.from_rpy((0.0, 0.0, 0.0), 0.0, np.pi / 2, 0.0), (-1.0, -0.5), (1.0, 0.5)),
    ],
)
def test_a_footprint_is_the_shadow_of_a_shape_from_above(
    geometry: Any, pose: Pose, low: tuple[float, float], high: tuple[float, float]
) -> None:
    model = Model("thing", (Link("body", visuals=(Visual("v", geometry, pose),)),), static=True)
    (marker,) = markers(Scene((model,))).markers
    outline = footprint(marker).outline
    np.testing.assert_allclose(outline.min(axis=0), low, atol=1e-6)
    np.testing.assert_allclose(outline.max(axis=0), high, atol=1e-6)


def test_a_mesh_is_shown_to_viewers_by_its_file(tmp_path: Path) -> None:
    mesh = Mesh(tmp_path / "body.stl", (2.0, 2.0, 2.0))
    model = Model("thing", (Link("body", visuals=(Visual("v", mesh),)),))
    (marker,) = markers(Scene((model,))).markers
    assert marker.mesh_resource == f"file://{tmp_path}/body.stl"
    assert marker.header.frame_id == "thing"


def test_a_file_that_is_no_picture_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match=r"not 'figure\.pgn'; did you mean '\.png'"):
        check_target(tmp_path / "figure.pgn")
    with pytest.raises(ExperimentError, match="the folder does not exist"):
        check_target(tmp_path / "nowhere" / "figure.png")


def test_without_matplotlib_a_figure_is_refused_with_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ExperimentError, match=re.escape("pip install 'nrp-core[plot]'")):
        check_target(tmp_path / "figure.png")
