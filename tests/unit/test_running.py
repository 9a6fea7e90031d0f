"""One call runs an experiment on real simulators."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

import nrp_core
from nrp_core.errors import ExperimentError, TimestepError, UnknownNameError

SMALL = ["world.options.image_scale=0.25"]


def test_one_call_is_what_a_run_opened_by_hand_is() -> None:
    steps: list[float] = []
    result = nrp_core.run(
        "braitenberg_husky", SMALL, until_s=0.2, on_step=lambda run: steps.append(run.now_s)
    )
    with nrp_core.Run(nrp_core.load_experiment("braitenberg_husky", SMALL)) as simulation:
        simulation.run(0.2)
    assert result.trajectory_digest == simulation.result().trajectory_digest
    assert (result.sim_time_s, result.steps) == (0.2, len(steps))
    assert steps[-1] == 0.2


def test_a_run_is_recorded_with_all_that_it_used(tmp_path: Path) -> None:
    result = nrp_core.run("braitenberg_husky", [*SMALL, "seed=5"], until_s=0.1, record=tmp_path / "out")
    recording = nrp_core.Recording(tmp_path / "out")
    assert recording.run["state"] == "finished"
    assert recording.run["result"]["trajectory_digest"] == result.trajectory_digest
    assert result.seed == 5


def test_a_recorded_result_draws_itself(fakes: None, drive_to_the_wall: Path, tmp_path: Path) -> None:
    result = nrp_core.run(drive_to_the_wall, record=tmp_path / "recording")
    assert result.plot("trajectory", end_s=1.0).axes
    assert result.recording.file == nrp_core.Recording(tmp_path / "recording").file
    plain = nrp_core.run(drive_to_the_wall)
    assert plain.to_dict().keys() == result.to_dict().keys()
    with pytest.raises(ExperimentError, match="record="):
        plain.plot()


def test_a_folder_that_holds_something_is_refused_before_anything_is_opened(
    tmp_path: Path, golden: Golden
) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with golden.raises(ExperimentError):
        nrp_core.run("no such experiment", record=tmp_path)


def test_a_recording_of_a_run_that_fails_says_so(tmp_path: Path) -> None:
    with pytest.raises(TimestepError):
        nrp_core.run("braitenberg_husky", SMALL, until_s=0.0123, record=tmp_path / "out")
    assert nrp_core.Recording(tmp_path / "out").run["state"] == "failed"


def test_a_run_that_its_observer_interrupts_is_recorded_as_interrupted(tmp_path: Path) -> None:
    def stop(run: nrp_core.Run) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nrp_core.run("braitenberg_husky", SMALL, until_s=1.0, record=tmp_path / "out", on_step=stop)
    recording = nrp_core.Recording(tmp_path / "out")
    assert recording.run["state"] == "interrupted"


def test_a_misspelt_name_in_a_result_is_explained(fakes: None, drive_to_the_wall: Path) -> None:
    result = nrp_core.run(drive_to_the_wall, until_s=0.1)
    for names, wrong, words in (
        (result.spikes, "actor", "no population or view 'actor'; did you mean 'actors'?"),
        (result.final_pose, "huskyy", "no robot 'huskyy'; did you mean 'husky'?"),
        (result.criteria, "arrive", "no criterion 'arrive'; did you mean 'arrives'?"),
        (result.events, "none", r"no event 'none'.*there are: 'go', 'red', 'arrived'"),
    ):
        with pytest.raises(UnknownNameError, match=words) as caught:
            names[wrong]
        assert isinstance(caught.value, KeyError)
        assert names.get(wrong) is None
        assert wrong not in names
    copied = pickle.loads(pickle.dumps(result))
    assert copied == result
    assert json.loads(json.dumps(copied.to_dict()["spikes"])) == dict(result.spikes)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"images": "exakt"}, "'exakt'.*'exact'"),
        ({"snapshots_s": 0}, "snapshots_s"),
        ({"snapshots_s": float("nan")}, "not nan"),
        ({"snapshots_s": "1"}, "not '1'"),
        ({"on_step": 3}, "on_step"),
        ({"on_step": lambda: None}, "on_step"),
        ({"record": 3}, ""),
    ],
)
def test_impossible_options_are_refused_before_anything_is_opened(
    options: dict[str, Any], words: str, tmp_path: Path, golden: Golden
) -> None:
    with golden.raises(ExperimentError, match=words):
        nrp_core.run("no such experiment", **{"record": tmp_path / "out", **options})


def test_any_callable_that_takes_the_run_is_called_after_each_step(
    fakes: None, drive_to_the_wall: Path
) -> None:
    seen: list[object] = []
    nrp_core.run(drive_to_the_wall, until_s=0.1, on_step=seen.append)
    nrp_core.run(drive_to_the_wall, until_s=0.1, on_step=lambda run, *more: seen.append(run.now_s))
    assert len(seen) > 1
    assert seen[-1] == 0.1
