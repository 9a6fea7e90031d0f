"""Runs whose bodies are drawn: each seed has its own, which its recording holds and its replay has again."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from command_fixtures import Done, nrp
from experiment_fixtures import _place, drive_to_the_wall, fakes, install, site
from golden import Golden

from nrp_core._support.used_files import FilesRead
from nrp_core.errors import CapabilityError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayVerdict

__all__ = ["_place", "drive_to_the_wall", "fakes", "install", "nrp", "site"]
SETTINGS = [
    "world.options.image_scale=0.1",
    "duration=400 ms",
    "world.randomize={mass: {husky/base_link: {add: 0..20 kg}}, light: {sun: {scale: 0.5..1.5}}, "
    "sensor_position: {husky/.*/camera: {add: -5..5 cm}}}",
]


def test_a_recording_shows_what_was_drawn_and_its_replay_is_identical(
    nrp: Callable[..., Done], tmp_path: Path
) -> None:
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", [*SETTINGS, "seed=4"])) as run:
        folder = RecordingFolder(run, tmp_path / "made", files=files)
        run.run()
        folder.close("finished")
    shown = json.loads(nrp("inspect", tmp_path / "made", "--json").out)["randomized"]
    drawn = {each["quantity"]: each for each in shown}
    assert drawn.keys() == {"mass", "light", "sensor_position"}
    assert drawn["mass"]["part"] == "husky/base_link"
    assert 0 <= drawn["mass"]["values"][0] <= 20
    assert all(-0.05 <= value <= 0.05 for value in drawn["sensor_position"]["values"])
    assert (
        f"mass of husky/base_link: add {drawn['mass']['values'][0]:.6g} kg"
        in nrp("inspect", tmp_path / "made").out
    )
    with Replay(Recording(tmp_path / "made"), ReplayRequest()) as replay:
        assert replay.verify().verdict is ReplayVerdict.IDENTICAL
        assert [each.values for each in replay.run.world.randomized] == [tuple(o["values"]) for o in shown]


def test_a_run_that_starts_over_with_a_seed_is_a_new_run_with_it() -> None:
    def digest(run: Run) -> tuple[str, object]:
        run.run()
        return run.result().trajectory_digest, run.world.randomized

    with Run(load_experiment("braitenberg_husky", [*SETTINGS, "seed=1"])) as run:
        first = digest(run)
        run.reset(seed=2)
        second = digest(run)
        run.reset(seed=1)
        assert digest(run) == first != second
    with Run(load_experiment("braitenberg_husky", [*SETTINGS, "seed=2"])) as run:
        assert digest(run) == second


@pytest.mark.usefixtures("fakes")
def test_a_world_that_cannot_change_its_scene_needs_a_new_run(
    drive_to_the_wall: Path, golden: Golden
) -> None:
    ranges = "world.randomize={mass: {husky/.*: {scale: 0.9..1.1}}}"
    with Run(load_experiment(drive_to_the_wall, [ranges])) as run:
        run.step()
        with golden.raises(CapabilityError):
            run.reset(seed=8)
        assert run.loop.steps == 1
