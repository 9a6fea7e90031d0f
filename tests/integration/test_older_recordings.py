"""A recording of version 0.2.0 with changes from outside: poses, joints, forces, models, functions."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from nrp_core._support import machine
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording import old_names
from nrp_core.recording.folder.recording_folder import RecordingFolder, recorded_experiment
from nrp_core.recording.reading.steps import steps_of
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest
from nrp_core.scene.rigid import ModelMotion

FOLDER = Path(__file__).parents[1] / "recordings" / "changed_from_outside_0.2.0"
STEPS = 60
MACHINE = ("python", "architecture", "cpu_features")


def test_a_recording_of_version_0_2_0_is_intact_and_shows_its_data() -> None:
    recording = Recording(FOLDER)
    check = recording.check()
    assert check.finished
    assert check.flaws == ()
    assert len([*steps_of(recording)]) == STEPS + 1
    images = list(recording.messages({"/cart/camera"}))
    assert images[0].message.data.size
    states = [one.message for one in recording.messages({"/gazebo/model_states"})]
    assert {name for state in states for name in state.name} == {
        "arm",
        "cart",
        "box",
        "ball",
        "mast",
        "second",
    }
    calls = Counter(call.name for step in steps_of(recording) for call in step.calls)
    assert calls.total() == 31
    assert calls["spawn"] == 2
    assert calls["call"] == 11


def test_all_calls_of_version_0_2_0_can_be_repeated() -> None:
    with Replay(Recording(FOLDER), ReplayRequest()) as again:
        outcome = again.go()
        assert outcome.error is None
        assert outcome.steps == STEPS
        assert [function.name for function in again.run.loop.functions] == ["drive"]
        assert {model.name for model in again.run.world.scene.models} == {
            "floor",
            "wall",
            "arm",
            "cart",
            "box",
        }


def test_a_replay_of_version_0_2_0_is_bit_for_bit() -> None:
    recording = Recording(FOLDER)
    then, now = recording.run["machine"], machine.describe_machine()
    recorded, versions = recording.run["distributions"], machine.distributions()
    other = [key for key in MACHINE if then[key] != now[key]]
    other += [name for name in ("mujoco-core", "numpy") if recorded[name] != versions.get(name)]
    if other:
        pytest.skip(f"recorded on a machine with another {', '.join(other)}")
    with Replay(recording, ReplayRequest()) as again:
        outcome = again.verify()
    assert outcome.difference is None
    assert outcome.identical


def test_what_a_backend_did_before_it_had_an_option_is_done_in_a_replay(tmp_path: Path) -> None:
    again = recorded_experiment(Recording(FOLDER), ["duration=40 ms"])
    assert again.brain.options == {"integration": "steps"}
    new = tmp_path / "new"
    with Run(load_experiment(FOLDER / "experiment.yaml", ["duration=40 ms"])) as run:
        folder = RecordingFolder(run, new)
        run.run()
        folder.close("finished")
    assert recorded_experiment(Recording(new)).brain.options == {}
    with Replay(Recording(new), ReplayRequest()) as replay:
        assert replay.verify().identical


@pytest.mark.parametrize(
    "moved",
    [
        {"an_old.place": "nrp_core.scene.rigid"},
        {"an_old.place.ModelMotion": "nrp_core.scene.rigid.ModelMotion"},
    ],
)
def test_a_class_is_found_where_the_table_of_moved_names_has_it(
    moved: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for old, new in moved.items():
        monkeypatch.setitem(old_names.MOVED, old, new)
    assert old_names.loads(b"can_old.place\nModelMotion\n.") is ModelMotion
    assert old_names.loads(b"cnumpy\nfloat64\n.") is np.float64
