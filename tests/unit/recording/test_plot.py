"""The figure, and the story it is drawn from."""

import re
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import cv2
import matplotlib as mpl
import numpy as np
import pytest
from golden import Golden
from matplotlib.figure import Figure

from nrp_core.dsl.testing import MockWorld
from nrp_core.errors import ExperimentError
from nrp_core.messages.foxglove_msgs import SceneUpdate
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.recording.figures import check_target, plot
from nrp_core.recording.figures.film import camera_images, image_times
from nrp_core.recording.figures.page import _raster, draw_page
from nrp_core.recording.figures.room import footprint, separate_labels
from nrp_core.recording.figures.story import Coloured, StepSeries, Story, Track
from nrp_core.recording.figures.style import Panel, PlotOptions, panels_of, size_inches, style
from nrp_core.recording.figures.traces import (
    by_unit,
    groups,
    moving,
    short_labels,
)
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, Images, Role
from nrp_core.recording.reading.mcap_messages import RecordedTopic
from nrp_core.recording.reading.reader import Recorded
from nrp_core.recording.reading.shapes import RecordedScene
from nrp_core.recording.reading.tables import numbers_in
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import seal
from nrp_core.recording.writing.frames import SceneFrames
from nrp_core.recording.writing.scenery import scene_update, shown_visuals
from nrp_core.recording.writing.writer import McapFile
from nrp_core.scene.model import Box, Capsule, Cylinder, Link, Model, Scene, Visual
from nrp_core.scene.rigid import Pose

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
    (rig.folder / RUN_NAME).write_bytes(seal(told))
    return Recording(rig.folder)


def entities(*models: Model) -> SceneUpdate:
    """Return what a recording says of a scene at its start."""
    world = MockWorld(scene=Scene(models))
    return scene_update({}, shown_visuals(world.scene, SceneFrames(world).now, {}), 0)


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
    shown = texts(draw_page(story, camera_images(recording, image_times(story, 4)), PlotOptions()))
    times, dash = "\N{MULTIPLICATION SIGN}", "\N{EN DASH}"
    assert shown >= {
        "driving", f"mock {times} disc   ·   0.4 s   ·   seed 3", "✓ near", "? far", "Room from above",
        "Spikes", "left_eye", "all_eyes (other)", "wheels", "Devices (mV)", "Commands (m/s)",
        "Commands (rad/s)", "husky 0 s and 0.4 s", f"glass: 0.1{dash}0.2 s, 0.3{dash}0.4 s",
        "simulated time (s)",
    }  # fmt: skip


@pytest.mark.one_of(6)
@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_equal_recordings_give_equal_files(recording: Recording, tmp_path: Path, suffix: str) -> None:
    first, second = tmp_path / f"first{suffix}", tmp_path / f"second{suffix}"
    for path in (first, second):
        plot(recording, path)
    assert first.read_bytes() == second.read_bytes()


def test_a_figure_in_python_is_that_of_the_command_and_shown_by_notebooks(
    recording: Recording, tmp_path: Path, golden: Golden
) -> None:
    plot(recording, tmp_path / "command.png", options=PlotOptions(begin_s=0.1, panels=(Panel.SPIKES,)))
    figure = recording.plot(path=tmp_path / "python.png", begin_s=0.1, panels=["spikes"])
    assert (tmp_path / "python.png").read_bytes() == (tmp_path / "command.png").read_bytes()
    shown = cv2.imdecode(np.frombuffer(figure._repr_png_(), np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape == cv2.imread(str(tmp_path / "python.png")).shape
    with golden.raises(ExperimentError):
        recording.plot("rasta")


@pytest.mark.heavy
def test_a_recording_that_was_cut_is_drawn_as_far_as_it_goes(recording: Recording, tmp_path: Path) -> None:
    whole = recording.file.read_bytes()
    for part in (1, 2, 3):
        recording.file.write_bytes(whole[: len(whole) * part // 4])
        plot(Recording(recording.folder), tmp_path / f"{part}.png")
        assert cv2.imread(str(tmp_path / f"{part}.png")).std() > 1  # something is drawn


def test_a_recording_of_nothing_is_an_almost_empty_page(tmp_path: Path) -> None:
    McapFile(tmp_path / MCAP_NAME).close()
    shown = texts(draw_page(Story.of(Recording(tmp_path)), [], PlotOptions()))
    assert {"recording", "0 s"} <= shown


def test_a_brain_without_a_moving_body_is_drawn(make_rig: Any, tmp_path: Path) -> None:
    rig = make_rig(Images.OFF)
    rig.step(forward=0.0, turn=0.0)
    rig.recorder.close()
    story = Story.of(Recording(rig.folder))
    story.tracks.clear()
    story.scene = RecordedScene()
    assert "Room from above" not in texts(draw_page(story, [], PlotOptions()))


def test_images_are_taken_at_moments_that_matter_and_the_gaps_between() -> None:
    story = Story({}, end_s=40.0)
    story.colours["a/b/c"] = [(0.0, (0, 0, 1)), (5.0, (1, 0, 0)), (7.1, (0, 0, 1))]
    assert image_times(story, 6) == pytest.approx([0.0, 6.05, 7.0, 18.0, 29.0, 40.0])
    assert image_times(Story({}, end_s=8.0), 3) == [0.0, 4.0, 8.0]
    assert image_times(Story({}), 3) == [0.0]


def test_each_image_of_the_camera_is_returned_once(recording: Recording) -> None:
    taken = camera_images(recording, [0.0, 0.001, 0.2, 9.0])
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


def test_values_of_two_robots_are_kept_apart() -> None:
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
    separate_labels(axes, labels)
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
        figure = draw_page(story, [], PlotOptions())
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
    rig = make_rig(Images.OFF)
    for _ in range(10):
        rig.step()
    rig.recorder.close()
    story = Story.of(Recording(rig.folder))
    (husky,) = [model for model in rig.world.scene.models if model.name == "husky"]
    boom = replace(husky.links[0], visuals=(Visual("boom", Box((9.0, 0.2, 0.2))),))
    story.scene.take(entities(replace(husky, links=(boom,))))
    topics = [f"/husky/leg_{i}/cmd_pos" for i in range(6)]
    story.commands = {f"{one}.data": StepSeries(one, "", [0.0], [0.5]) for one in [*topics, "/husky/lamp"]}
    with style():
        figure = draw_page(story, [], PlotOptions())
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
    scene = RecordedScene()
    scene.take(entities(Model("thing", (Link("body", visuals=(Visual("v", geometry, pose),)),), static=True)))
    outlines = np.vstack([footprint(shape, Pose()).outline for shape in scene.shapes])
    np.testing.assert_allclose(outlines.min(axis=0), low, atol=1e-6)
    np.testing.assert_allclose(outlines.max(axis=0), high, atol=1e-6)


def test_a_file_that_is_not_an_image_is_refused_by_name(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(ExperimentError, match=r"'figure\.pgn'.*'\.png'"):
        check_target(tmp_path / "figure.pgn")
    with golden.raises(ExperimentError):
        check_target(tmp_path / "nowhere" / "figure.png")


def test_without_matplotlib_a_figure_is_refused_with_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ExperimentError, match=re.escape("pip install 'nrp-core[plot]'")):
        check_target(tmp_path / "figure.png")


def driven(length_m: float, walls_m: float) -> Story:
    """A robot that drove along x in a room with walls so far away."""
    walls = [
        Visual(f"wall_{x:g}", Box((0.1, 2 * walls_m, 1.0)), Pose((x, 0.0, 0.5))) for x in (-walls_m, walls_m)
    ]
    story = Story({}, end_s=10.0)
    story.scene.take(entities(Model("room", (Link("body", visuals=tuple(walls)),), static=True)))
    story.tracks["car"] = Track([0.0, 10.0], [0.0, length_m], [0.0, 0.0], [0.0, 0.0])
    story.spikes["eyes"] = [(np.arange(30, dtype=np.uint32), np.linspace(0.0, 9.0, 30))]
    return story


def map_of(figure: Figure) -> Any:
    figure.draw_without_rendering()
    return next((axes for axes in figure.axes if axes.get_title(loc="left") == "Room from above"), None)


def test_a_map_is_cropped_to_the_trajectory_and_a_larger_room_is_shown_in_a_corner() -> None:
    with style():
        axes = map_of(draw_page(driven(2.0, 20.0), [], PlotOptions()))
        whole = map_of(draw_page(driven(2.0, 0.3), [], PlotOptions()))
    low, high = axes.get_xlim()
    assert -3.0 < low < 0.0
    assert 2.0 < high < 5.0
    (inset,) = axes.child_axes
    assert inset.get_xlim()[0] < -20.0
    assert inset.get_xlim()[1] > 20.0
    assert not whole.child_axes


@pytest.mark.parametrize("bend_m", np.linspace(-1.0, 1.0, 5))
def test_the_room_in_a_corner_is_nowhere_near_the_trajectory(bend_m: float) -> None:
    story, along = driven(2.0, 20.0), np.linspace(0.0, 2.0, 100)
    ys = (bend_m * np.sin(3.0 * along)).tolist()
    story.tracks["car"] = Track(np.linspace(0, 10, 100).tolist(), along.tolist(), ys, [0.0] * 100)
    with style():
        axes = map_of(draw_page(story, [], PlotOptions()))
    for inset in axes.child_axes:
        box = inset.get_window_extent().padded(0.02 * axes.bbox.width)
        assert not any(
            box.contains(*point) for point in axes.transData.transform(np.column_stack([along, ys]))
        )


@pytest.mark.parametrize("width", ["85mm", "180mm"])
def test_the_names_of_many_rows_do_not_overlap_at_the_width_of_a_column(width: str) -> None:
    story = driven(2.0, 20.0)
    cells = np.arange(40, dtype=np.uint32)
    story.spikes.update((f"population {n}", [(cells, np.linspace(0.0, 9.0, 40))]) for n in range(8))
    options = PlotOptions(size_inches=size_inches(width))
    with style(size_inches(width)[0]):
        figure = _raster(story, options)
        assert figure is not None
        figure.draw_without_rendering()
    (axes,) = (each for each in figure.axes if each.get_yticklabels() and each.get_title(loc="left"))
    boxes = [label.get_window_extent() for label in axes.get_yticklabels()]
    assert len(boxes) >= 5
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


LEGS = (f"{place}_{side}" for place in ("front", "middle", "hind") for side in ("left", "right"))
JOINTS = [*(f"{leg}_{joint}" for leg in LEGS for joint in ("coxa_yaw", "femur_pitch")), "proboscis"]


def walked(scale: float) -> Story:
    """A box of 1 x 0.5 m that walks for 2 m, and joints with long names; ``scale`` is that of the room."""
    story = Story({}, end_s=10.0)
    body = Box((1.0 * scale, 0.5 * scale, 0.2 * scale))
    floor = Visual("floor", Box((40.0 * scale, 40.0 * scale, 0.001)), Pose((0.0, 0.0, 0.0)))
    story.scene.take(
        entities(
            Model("bug", (Link("bug", visuals=(Visual("body", body),)),)),
            Model("room", (Link("body", visuals=(floor,)),), static=True),
        )
    )
    story.first_poses["bug"] = Pose()
    story.last_poses["bug"] = Pose((2.0 * scale, 0.0, 0.0))
    story.tracks["bug"] = Track([0.0, 10.0], [0.0, 2.0 * scale], [0.0, 0.0], [0.0, 0.0])
    story.commands = {
        name: StepSeries(f"/bug/{name}/cmd_pos", "rad", [0.0, 5.0], [-0.55, 0.55]) for name in JOINTS
    }
    return story


def test_a_map_in_millimetres_is_cropped_and_labelled_as_one_in_metres() -> None:
    with style():
        large, small = (map_of(draw_page(walked(scale), [], PlotOptions())) for scale in (1.0, 1e-3))
    assert np.divide(small.get_xlim(), large.get_xlim()) == pytest.approx(1e-3, rel=0.05)
    assert small.get_ylim()[1] < 2.0e-3
    named = [{text.get_text() for text in axes.texts} for axes in (large, small)]
    assert named == [{"bug 0 s", "10 s"}] * 2
    ticks = "".join(label.get_text() for label in small.get_yticklabels())
    assert "\N{MINUS SIGN}" in ticks
    assert "-" not in ticks


def test_names_of_rows_are_whole_and_the_unit_of_colours_is_on_the_page() -> None:
    with style():
        figure = draw_page(walked(1.0), [], PlotOptions())
        figure.draw_without_rendering()
    assert set(JOINTS) <= texts(figure)
    units = [text for text in figure.findobj(mpl.text.Text) if text.get_text() == "rad"]
    assert len(units) == 1
    assert units[0].get_window_extent().x1 <= figure.bbox.width


@pytest.mark.one_of(8)
@pytest.mark.parametrize("aside_m", [0.0, 1.5], ids=["map above", "map beside"])
@pytest.mark.parametrize("size_mm", [(180, 150), (180, 180), (250, 160), (325.12, 203.2)])
def test_no_text_covers_another_or_leaves_the_page(aside_m: float, size_mm: tuple[float, float]) -> None:
    result = {
        "sim_time_s": 10.0,
        "duration_s": 40.0,
        "criteria": {"arrives": {"passed": None}},
        "problems": [],
    }
    story = replace(walked(1.0), run={"experiment": "bug", "state": "finished", "result": result})
    story.tracks["bug"] = Track([0.0, 10.0], [0.0, 2.0], [0.0, aside_m], [0.0, 0.0])
    story.last_poses["bug"] = Pose((2.0, aside_m, 0.0))
    story.spikes["a population with a long name"] = [
        (np.arange(30, dtype=np.uint32), np.linspace(0.0, 9.0, 30))
    ]
    story.sinks = {
        f"s{i}": StepSeries(f"move_middle_{i}/{way}", "Hz", [0.0, 1.0], [float(i), -1.0])
        for i, way in enumerate(["lifting", "forward", "back"] * 6)
    }
    size = (size_mm[0] / 25.4, size_mm[1] / 25.4)
    with style(width_inches=size[0]):
        figure = draw_page(story, [], PlotOptions(size, dpi=150))
        covered = map_of(figure)
        outside = {
            label
            for axis in figure.findobj(mpl.axis.Axis)
            for tick in axis.get_major_ticks()
            for label in (tick.label1, tick.label2)
            if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
        }
        written = [text for text in figure.findobj(mpl.text.Text) if text.get_visible() and text.get_text()]
        boxes = [(text.get_text(), text.get_window_extent()) for text in written if text not in outside]
    assert any("not decided" in text for text, _ in boxes)
    page = figure.bbox.padded(1.0)
    assert [text for text, box in boxes if not page.x0 <= box.x0 <= box.x1 <= page.x1] == []
    both = [
        (a[0], b[0])
        for a, b in combinations(boxes, 2)
        if a[1].shrunk(0.95, 0.7).overlaps(b[1].shrunk(0.95, 0.7))
    ]
    assert both == []
    rows = [box for text, box in boxes if text.startswith(("move_", "front_", "a population"))]
    assert len(rows) > 10
    assert not any(box.overlaps(covered.get_window_extent()) for box in rows)


def test_a_robot_that_stays_where_it_is_has_no_map() -> None:
    with style():
        assert map_of(draw_page(driven(0.0, 20.0), [], PlotOptions())) is None


def test_neurons_and_colours_have_axes_with_units() -> None:
    story = driven(2.0, 20.0)
    story.sinks = {f"s{i}": StepSeries(f"device {i}", "Hz", [0.0], [float(i)]) for i in range(6)}
    with style():
        figure = draw_page(story, [], PlotOptions())
    figure.draw_without_rendering()
    assert {"neuron", "Hz", "0", "29"} <= texts(figure)


def test_images_are_taken_where_most_moves() -> None:
    story = Story({}, end_s=100.0)
    story.activity = [
        (t_s, 1.0 if 20.0 < t_s <= 30.0 else 0.0) for t_s in np.arange(0.0, 100.0, 0.5).tolist()
    ]
    taken = image_times(story, 10)
    assert sum(20.0 <= t_s <= 30.0 for t_s in taken) >= 6
    assert (taken[0], taken[-1]) == (0.0, 100.0)


def test_images_show_the_events_of_a_run() -> None:
    story = Story({"result": {"events": {"found": 31.4, "missed": None}}}, end_s=100.0)
    assert 31.4 in image_times(story, 8)


def test_a_figure_has_the_requested_size_resolution_and_panels(recording: Recording, tmp_path: Path) -> None:
    size = size_inches("127x76.2mm")
    options = PlotOptions(size_inches=size, dpi=100, panels=(Panel.SPIKES,))
    plot(recording, tmp_path / "small.png", options=options)
    assert cv2.imread(str(tmp_path / "small.png")).shape == (300, 500, 3)
    with style(size[0]):
        shown = texts(draw_page(Story.of(recording), [], options))
    assert "Spikes" in shown
    assert not {"Room from above", "Devices (mV)", "Commands (m/s)"} & shown


@pytest.mark.parametrize(
    ("size", "panels", "crowded"),
    [("90x60mm", tuple(Panel), True), ("150x100mm", tuple(Panel), False), ("90x60mm", (Panel.MAP,), False)],
)
def test_a_page_is_crowded_if_it_is_small_and_has_all_panels(
    size: str, panels: tuple[Panel, ...], crowded: bool
) -> None:
    assert PlotOptions(size_inches=size_inches(size), panels=panels).crowded is crowded


def test_a_figure_shows_a_window_of_time_and_values_from_before_it_hold(
    recording: Recording, golden: Golden
) -> None:
    story = Story.of(recording, 0.21, 0.29)
    assert (story.begin_s, story.end_s) == pytest.approx((0.21, 0.28))
    assert story.tracks["husky"].times_s[0] == pytest.approx(0.22)
    assert story.commands["/husky/cmd_vel.linear.x"].times_s[0] == pytest.approx(0.21)
    assert story.coloured() == []
    assert Story.of(recording, 0.11, 0.3).coloured()[0].since_s == pytest.approx(0.11)
    with golden.raises(ExperimentError):
        Story.of(recording, 3.0, 4.0)


@pytest.mark.parametrize(
    "text", ["180", "180x", "mm", "1x2x3cm", "x5cm", "180x120", "180x120ly", "0x5cm", "1x1km", "-5x5cm"]
)
def test_a_size_that_is_not_one_is_refused(text: str, golden: Golden) -> None:
    with golden.raises(ValueError):
        size_inches(text)


def test_sizes_are_read_in_three_units(golden: Golden) -> None:
    assert size_inches("254x127mm") == pytest.approx((10.0, 5.0))
    assert size_inches("25.4 x 12.7 cm") == pytest.approx((10.0, 5.0))
    assert size_inches("10x5in") == (10.0, 5.0)
    assert size_inches("8.5cm") == (pytest.approx(8.5 / 2.54), None)
    with golden.raises(ValueError, match="'spike'.*'spikes'"):
        panels_of("map,spike")
    with golden.raises(ValueError, match="'map'"):
        panels_of("map, spikes,map")
