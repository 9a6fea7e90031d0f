"""Muscles in recordings: their commands and states come back from files, replays, snapshots and resets."""

from __future__ import annotations

import csv
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import nrp_experiments
import numpy as np
import pytest

from nrp_core._support.used_files import FilesRead
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.export import export
from nrp_core.recording.figures.story import Story
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import MUSCLES
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayVerdict
from nrp_core.recording.video.views import RecordedMuscles, Stage
from nrp_core.scene.sdf import read_scene
from nrp_core.world.render.portrait import portrait

NAMES = "shoulder_flexor", "shoulder_extensor", "elbow_flexor", "elbow_extensor"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The folder of 100 ms of the reflex arm, and the last message of the states of its muscles."""
    folder = tmp_path_factory.mktemp("muscles") / "recording"
    with FilesRead() as files, Run(load_experiment("reflex_arm", ["duration=100 ms"])) as run:
        recording_folder = RecordingFolder(run, folder, files=files, snapshots_ns=50_000_000)
        states = run.world.subscribe("/arm/muscles/state")
        run.run()
        recording_folder.close("finished")
        assert states.latest is not None
        return folder, {name: getattr(states.latest.message, name) for name in ("force", "activation")}


def test_a_table_and_a_figure_have_a_column_and_a_curve_for_each_muscle(
    recorded: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    recording, last = Recording(recorded[0]), recorded[1]
    export(recording, "csv", tmp_path / "out")
    commands = _rows(tmp_path / "out" / "arm.muscles.cmd.csv")
    assert list(commands[0]) == ["time_s", *(f"data.{name}" for name in NAMES)]
    states = _rows(tmp_path / "out" / "arm.muscles.state.csv")
    for field, unit in (("force", " [N]"), ("activation", "")):
        values = [float(states[-1][f"{field}.{name}{unit}"]) for name in NAMES]
        np.testing.assert_array_equal(values, last[field])
    curves = Story.of(recording).commands
    for name in NAMES:
        assert curves[f"/arm/muscles/cmd.data.{name}"].label == f"/arm/muscles/cmd.{name}"
        drawn = curves[f"/arm/muscles/cmd.data.{name}"].values
        assert drawn == [float(row[f"data.{name}"]) for row in commands]
        assert any(drawn)


def test_a_recording_of_muscles_is_the_same_again(recorded: tuple[Path, dict[str, Any]]) -> None:
    with FilesRead() as files, Replay(Recording(recorded[0]), ReplayRequest(), files=files) as again:
        outcome = again.verify()
    assert outcome.verdict is ReplayVerdict.IDENTICAL
    assert outcome.until_ns == 100_000_000


def test_a_replay_begins_at_the_last_snapshot_though_steps_do_not_divide_their_interval(
    recorded: tuple[Path, dict[str, Any]],
) -> None:
    """Snapshots every 50 ms of a run with steps of 4 ms are those of 52 and 100 ms."""
    for from_ns, began_ns in ((48_000_000, 0), (52_000_000, 52_000_000), (60_000_000, 52_000_000)):
        request = ReplayRequest(from_ns=from_ns)
        with FilesRead() as files, Replay(Recording(recorded[0]), request, files=files) as again:
            assert again.verify().from_ns == began_ns


@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_muscles_go_on_the_same_after_a_snapshot_and_a_reset(world: str) -> None:
    with Run(load_experiment("reflex_arm", [f"world.backend={world}"])) as run:
        states = run.world.subscribe("/arm/muscles/state")
        run.run_until(0.06)
        saved = run.snapshot()
        ends = []
        for begin in (lambda: None, lambda: run.restore(saved), run.loop.reset):
            begin()
            run.run_until(0.1)
            ends.append(np.array([getattr(states.latest.message, name) for name in ("force", "activation")]))
    np.testing.assert_array_equal(ends[1], ends[0])
    np.testing.assert_array_equal(ends[2], ends[0])
    assert ends[0][1].max() > 0.05


def test_muscles_are_recorded_as_lines_in_the_colours_of_their_activations(
    recorded: tuple[Path, dict[str, Any]],
) -> None:
    recording, states = Recording(recorded[0]), recorded[1]
    *_, last = recording.messages({MUSCLES})
    assert last.t_ns == 80_000_000
    (at,) = [one.message for one in recording.messages({"/arm/muscles/state"}) if one.t_ns == last.t_ns]
    (entity,) = last.message.entities
    assert entity.frame_id == "world"
    for number, line in enumerate(entity.lines):
        points = np.array([(each.x, each.y, each.z) for each in line.points])
        assert points[:, 2] == pytest.approx(1.0, abs=0.1)
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        assert length == pytest.approx(at.length[number], rel=1e-9)
        share = at.activation[number]
        assert line.color.r == pytest.approx(0.2 + 0.8 * share)
        assert line.color.b == pytest.approx(1.0 - 0.9 * share)
    assert max(states["activation"]) > 0.05


def test_a_video_draws_muscles_where_they_are_and_as_active_as_they_are(
    recorded: tuple[Path, dict[str, Any]],
) -> None:
    muscles = RecordedMuscles()
    with ExitStack() as kept:
        stage: Stage | None = None
        for one in Recording(recorded[0]).messages({MUSCLES}):
            if muscles.take(one.message) or stage is None:
                stage = Stage([], kept, muscles)
            corners = stage.mesh.in_world(stage.frames({}))
            (entity,) = one.message.entities
            points = np.array([(p.x, p.y, p.z) for line in entity.lines for p in line.points])
            radius = entity.lines[0].thickness / 2
            np.testing.assert_allclose(corners.min(axis=0), points.min(axis=0) - radius, atol=2e-3)
            np.testing.assert_allclose(corners.max(axis=0), points.max(axis=0) + radius, atol=2e-3)
            shown = {tuple(color) for color in stage.mesh.palette[:-1].tolist()}
            wanted = {tuple(round(255 * c) for c in (x.color.r, x.color.g, x.color.b)) for x in entity.lines}
            assert all(min(np.abs(np.subtract(each, one)).max() for one in shown) <= 1 for each in wanted)


def test_a_portrait_shows_relaxed_muscles() -> None:
    scene = read_scene(Path(nrp_experiments.__file__).parent / "bodies" / "muscle_arm.sdf")
    without = replace(scene, models=tuple(replace(model, drives=()) for model in scene.models))
    counts = []
    for shown in (scene, without):
        _, green, blue = np.moveaxis(portrait(shown).astype(int), 2, 0)
        counts.append(int((blue > 2 * green).sum()))
    assert counts[0] > 1000
    assert counts[1] == 0


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))
