"""The brain, the robot or the world of a run is reset alone, while time goes on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from golden import Golden

from nrp_core._support.used_files import FilesRead
from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.calls import CallNoter
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest
from nrp_core.scene.rigid import Vector

PAIRS = [("event", "mujoco"), ("spinnaker", "pybullet")]
SCREEN = "/left_vr_screen/body/screen_glass/color"
SMALL = ["world.options.image_scale=0.1", "seed=4", "events.left_red.at=0.4 s"]


def settings(brain: str, world: str) -> Sequence[str]:
    return [*SMALL, f"brain.backend={brain}", f"world.backend={world}"]


@pytest.fixture(params=PAIRS, ids="-".join)
def run(request: pytest.FixtureRequest) -> Iterator[Run]:
    with Run(load_experiment("braitenberg_husky", settings(*request.param))) as opened:
        yield opened


def place(run: Run) -> Vector:
    return run.world.model_motion("husky").pose.position


def red(run: Run) -> float:
    """Return how red the left screen is."""
    subscription = run.world.subscribe(SCREEN)
    run.step()
    assert subscription.latest is not None
    return float(subscription.latest.message.r)


def test_the_robot_returns_to_where_it_began_and_the_screen_stays_red(run: Run) -> None:
    start = place(run)
    run.run_until(2.0)
    assert place(run) != pytest.approx(start, abs=0.05)
    run.reset("robot")
    assert place(run) == pytest.approx(start, abs=1e-6)
    assert (run.now_s, red(run)) == (2.0, 1.0)
    run.step()


def test_the_world_returns_to_how_it_was_and_the_robot_stays_where_it_is(run: Run) -> None:
    before = red(run)
    run.run_until(2.0)
    there = place(run)
    run.reset("world")
    assert (place(run), red(run)) == (there, before)
    run.step()


def test_the_brain_starts_over_and_the_robot_stays_where_it_is(run: Run) -> None:
    resting = run.brain.read_state("v", range(3)).tolist()
    run.run_until(2.0)
    there, spikes = place(run), run.result().spikes
    assert run.brain.read_state("v", range(3)).tolist() != resting
    run.reset("brain")
    assert run.brain.read_state("v", range(3)).tolist() == resting
    assert (place(run), run.now_s, run.result().spikes) == (there, 2.0, spikes)
    run.step()


def test_a_part_that_cannot_be_reset_alone_is_refused_and_the_others_are_named(
    run: Run, golden: Golden
) -> None:
    with golden.raises(ExperimentError, match="'robot'"):
        run.reset("robots")


@pytest.fixture(params=[True, False], ids=["noted", "not noted"])
def recorded(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording of resets, and a wrong one that misses that of the brain."""
    if not request.param:
        monkeypatch.setattr(CallNoter, "part_reset", lambda self, run, part: None)
    folder = tmp_path / "recording"
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", settings("event", "mujoco"))) as run:
        recording = RecordingFolder(run, folder, files=files, snapshots_ns=10**9)
        for part in ("brain", "robot", "world"):
            run.run_until(run.now_s + 0.7)
            run.reset(part)
        run.run_until(2.6)
        recording.close("finished")
    return folder


def test_resets_are_repeated_by_a_replay(recorded: Path, request: pytest.FixtureRequest) -> None:
    with FilesRead() as files, Replay(Recording(recorded), ReplayRequest(), files=files) as again:
        outcome = again.verify()
    assert (outcome.difference is None) == ("not noted" not in request.node.name)


def test_a_recording_goes_on_with_the_spikes_of_the_brain_that_starts_over(tmp_path: Path) -> None:
    """Without input the cell that fires by itself repeats its spikes from the reset on."""
    alone = [*settings("event", "mujoco"), "transfer_functions=[]"]
    with Run(load_experiment("braitenberg_husky", alone)) as run:
        recording = RecordingFolder(run, tmp_path / "recording")
        run.run_until(0.7)
        run.reset("brain")
        run.run_until(1.4)
        counted = run.result().spikes["circuit"]
        recording.close("finished")
    trains = Recording(tmp_path / "recording").spikes().spiketrains
    times_ms = trains[5].magnitude
    before, after = times_ms[times_ms < 700], times_ms[times_ms >= 700]
    assert len(before) > 10
    assert after == pytest.approx(before + 700)
    assert counted == sum(map(len, trains))
