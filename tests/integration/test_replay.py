"""Recordings of the shipped experiment, run again: the same, from within, against a recorded side, edited."""

import json
import os
import pickle
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest
from golden import Golden
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from nrp_lab.comparison.metric import all_metrics
from nrp_lab.comparison.result import PairDiff

from nrp_core._support.used_files import FilesRead
from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha
from nrp_core.dsl import Neuron2Robot, Topic
from nrp_core.errors import ExperimentError, SnapshotError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, SNAPSHOTS, STEPS
from nrp_core.recording.reading.recover import recover
from nrp_core.recording.reading.steps import steps_of
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayResult, ReplayVerdict
from nrp_core.recording.sealing import seal
from nrp_core.scene.rigid import ModelMotion, Pose
from nrp_core.world.model_states import MODEL_STATES

S = 10**9
FIRST, OTHER = ("event", "mujoco"), ("spinnaker", "pybullet")
PAIRS = [FIRST, pytest.param(OTHER, marks=pytest.mark.heavy)]
SETTINGS = ("world.options.image_scale=0.2", "events.left_red.at=0.5 s", "duration=3 s", "seed=11")


@dataclass(frozen=True)
class Made:
    """A recording, and the result of its run."""

    folder: Path
    result: dict[str, object]

    @property
    def recording(self) -> Recording:
        return Recording(self.folder)

    def replay(self, request: ReplayRequest | None = None, *, verify: bool = True) -> ReplayResult:
        with FilesRead() as files, Replay(self.recording, request or ReplayRequest(), files=files) as again:
            return again.verify() if verify else again.go()

    def edited(self, folder: Path, before: str, after: str) -> Path:
        """Write the file of the transfer function that drives, changed."""
        source = (self.folder / "experiment" / "listing1.py").read_text()
        assert before in source
        (folder / "listing1.py").write_text(source.replace(before, after))
        return folder / "listing1.py"


@pytest.fixture(scope="module", params=PAIRS, ids="-".join)
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Made:
    return recorded(*request.param, tmp_path_factory.mktemp("made") / "recording")


def recorded(brain: str, world: str, folder: Path) -> Made:
    overrides = [*SETTINGS, f"brain.backend={brain}", f"world.backend={world}"]
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", overrides)) as run:
        recording_folder = RecordingFolder(run, folder, files=files, snapshots_ns=S)
        run.run_until(1.5)
        run.publish("/screens/right/color", "red")
        run.run()
        recording_folder.close("finished")
        assert recording_folder.warnings == []
        return Made(folder, run.result().to_dict())


def test_a_run_is_the_same_again(made: Made) -> None:
    outcome = made.replay()
    assert outcome.identical
    assert (outcome.steps, outcome.from_ns, outcome.until_ns) == (150, 0, 3 * S)
    assert outcome.warnings == []


@pytest.mark.heavy
def test_runs_of_other_engines_are_the_same_again_too(tmp_path: Path) -> None:
    made = recorded(*OTHER, tmp_path / "recording")
    assert made.replay().identical
    assert made.replay(ReplayRequest(from_ns=round(1.24 * S))).verdict is ReplayVerdict.SAME
    for side in ("world", "brain"):
        assert made.replay(ReplayRequest(recorded=frozenset({side}))).difference is None  # type: ignore[arg-type]


def test_the_recording_is_an_experiment_of_its_own(made: Made) -> None:
    with Run(load_experiment(made.folder)) as run:
        run.run_until(1.5)
        run.publish("/screens/right/color", "red")
        run.run()
        assert run.result().trajectory_digest == made.result["trajectory_digest"]


def test_a_step_has_four_hashes_and_the_chain_of_all_before(made: Made) -> None:
    steps = list(steps_of(made.recording))
    assert [step.hash.step for step in steps] == list(range(151))
    assert len({step.hash.chain for step in steps}) == 151
    assert all(len(one) == 16 for one in steps[-1].hashes)


def test_an_unedited_future_equals_the_past_at_common_steps(made: Made, tmp_path: Path) -> None:
    made.replay(ReplayRequest(from_ns=round(1.24 * S), record=tmp_path / "future"), verify=False)
    compared = PairDiff.of(made.folder, tmp_path / "future", all_metrics())
    assert compared.is_identical
    assert compared.divergence.steps == 150 - 62
    # of the command in force where it goes on from only the first recording knows
    apart = {
        (row.metric.name, row.part): row.apart for row in compared.measured if abs(row.apart or 0) > 1e-4
    }
    assert apart == {}


@pytest.mark.one_of(6)
@pytest.mark.parametrize("from_s", [1.0, 1.24, 2.98])
def test_it_goes_on_from_within_as_it_went_on(made: Made, from_s: float) -> None:
    outcome = made.replay(ReplayRequest(from_ns=round(from_s * S)))
    assert outcome.verdict is ReplayVerdict.SAME
    assert (outcome.from_ns, outcome.until_ns) == (int(from_s) * S, 3 * S)


@pytest.mark.parametrize("side", ["brain", "world"])
def test_a_recorded_side_gives_the_other_what_it_gave(made: Made, side: str) -> None:
    outcome = made.replay(ReplayRequest(recorded=frozenset({side})))  # type: ignore[arg-type]
    assert (outcome.difference, outcome.steps) == (None, 150)


@pytest.mark.parametrize("delay_ms", [50, 300])
def test_a_recorded_body_senses_as_late_as_it_did(delay_ms: int, tmp_path: Path) -> None:
    overrides = [
        f"world.sensors={{'/husky/camera': {{delay: {delay_ms} ms, drop_out: 0.2}}}}",
        "duration=0.8 s",
    ]
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", [*SETTINGS, *overrides])) as run:
        recording_folder = RecordingFolder(run, tmp_path / "late", files=files)
        run.run()
        recording_folder.close("finished")
    late = Made(tmp_path / "late", {})
    (first, *_) = late.recording.messages({"/husky/camera"})
    assert first.t_ns >= delay_ms * 1_000_000
    for side in ("world", "brain"):
        outcome = late.replay(ReplayRequest(recorded=frozenset({side})))  # type: ignore[arg-type]
        assert (outcome.difference, outcome.error) == (None, None)


def test_a_recorded_laser_measures_to_the_last_bit_what_it_measured(tmp_path: Path) -> None:
    with FilesRead() as files, Run(load_experiment("slalom_pioneer", ["duration=2 s"])) as run:
        recording_folder = RecordingFolder(run, tmp_path / "slalom", files=files)
        run.run()
        recording_folder.close("finished")
    outcome = Made(tmp_path / "slalom", {}).replay(ReplayRequest(recorded=frozenset({"world"})))
    assert (outcome.difference, outcome.steps) == (None, 100)


def test_a_transfer_function_is_tested_against_a_recorded_body(made: Made, tmp_path: Path) -> None:
    edited = made.edited(tmp_path, "100 * (", "99 * (")
    outcome = made.replay(ReplayRequest(recorded=frozenset({"world"}), functions=[edited]))
    assert outcome.difference is not None
    assert (outcome.difference.signal, outcome.difference.group) == ("/husky/cmd_vel", "outputs")
    assert "angular.z" in outcome.difference.now


def test_an_edited_future_begins_where_it_was_edited_and_can_be_verified(made: Made, tmp_path: Path) -> None:
    edited, folder = made.edited(tmp_path, "100 * (", "-100 * ("), tmp_path / "future"
    outcome = made.replay(
        ReplayRequest(from_ns=round(1.6 * S), functions=[edited], record=folder), verify=False
    )
    assert outcome.difference is not None
    assert outcome.difference.t_ns == round(1.62 * S)
    assert outcome.until_ns == 3 * S
    future = Made(folder, {})
    steps = list(steps_of(future.recording))
    assert (steps[0].t_ns, steps[0].hash.step, steps[-1].t_ns) == (round(1.6 * S), 80, 3 * S)
    past = {step.t_ns: step.hash.chain for step in steps_of(made.recording)}
    assert future.recording.run["continues"] == {
        "recording": "recording", "t_ns": round(1.6 * S), "chain": past[round(1.6 * S)]
    }  # fmt: skip
    assert future.replay().identical
    assert future.replay(ReplayRequest(from_ns=2 * S)).identical


def test_the_same_functions_edited_in_change_nothing(made: Made, tmp_path: Path) -> None:
    same = made.edited(tmp_path, "100 * (", "100.0 * (")
    assert made.replay(ReplayRequest(from_ns=round(1.6 * S), functions=[same])).verdict is ReplayVerdict.SAME


def test_a_changed_message_or_a_changed_file_is_found(made: Made, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    subprocess.run(["cp", "-r", made.folder, copy], check=True)
    listing = copy / "experiment" / "listing1.py"
    listing.write_text(listing.read_text().replace("20 * min", "20.5 * min"))
    outcome = Made(copy, {}).replay()
    assert outcome.difference is not None
    assert outcome.difference.signal == "/husky/cmd_vel"
    flaw = "experiment/listing1.py (transfer_functions) was changed or damaged since it was written"
    assert outcome.warnings.messages == [flaw]


def test_another_seed_is_another_run(made: Made, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    subprocess.run(["cp", "-r", made.folder, copy], check=True)
    own = copy / "experiment.yaml"
    own.write_text(own.read_text().replace("seed: 11", "seed: 12"))
    told = json.loads((copy / RUN_NAME).read_text())
    told["dependencies"]["versions"] |= {"numpy": "1.26.4", "antique": "0.1"}
    told["machine"]["cpu_features"] = ["sse4_2"]
    (copy / RUN_NAME).write_bytes(seal(told))
    outcome = Made(copy, {}).replay()
    flaw, versions, processor = outcome.warnings.messages
    assert flaw.startswith("experiment.yaml (the experiment as it was run) was changed")
    assert re.fullmatch(r"it was made with numpy 1\.26\.4 \(now .*\), antique 0\.1 \(now none\)", versions)
    assert processor.startswith("it was made on another machine: cpu features sse4_2 (now ")
    assert outcome.difference is not None
    assert outcome.difference.step < 50


def test_a_recording_names_the_code_and_versions_that_ran(made: Made) -> None:
    run = made.recording.run
    names = ("brain.py", "listing1.py", "listing2.py", "husky.sdf", "room.sdf", "screen.sdf")
    assert set(run["files"]) >= {MCAP_NAME, "experiment.yaml", *(f"experiment/{name}" for name in names)}
    assert run["seed"] == 11
    assert run["machine"]["processor"]
    assert run["distributions"]["numpy"]
    assert run["overrides"][0] == SETTINGS[0]


def test_somebody_elses_program_reads_every_message(made: Made) -> None:
    with (made.folder / MCAP_NAME).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = list(reader.iter_decoded_messages())
    topics = {channel.topic for _, channel, _, _ in messages}
    assert topics >= {STEPS, SNAPSHOTS, "/husky/camera", "/husky/cmd_vel", "/gazebo/model_states"}
    spikes = [m.decoded_message for m in messages if m.channel.topic.endswith("/spikes")]
    total = sum(len(message.ids) for message in spikes)
    assert total == made.result["spikes"]["circuit"]  # type: ignore[index]


@pytest.mark.parametrize(
    "request_",
    [
        ReplayRequest(from_ns=round(1.61 * S)),
        ReplayRequest(from_ns=9 * S),
        ReplayRequest(from_ns=S, recorded=frozenset({"world"})),
    ],
)
def test_an_impossible_replay_is_an_error(made: Made, request_: ReplayRequest, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        made.replay(request_)


def test_a_killed_run_is_verified_as_far_as_it_went(tmp_path: Path) -> None:
    folder = tmp_path / "killed"
    program = [
        sys.executable, "-m", "nrp_core", "run", "braitenberg_husky", "--record", str(folder),
        "--pace", "realtime", "-s", SETTINGS[0],
    ]  # fmt: skip
    process = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    file = folder / MCAP_NAME
    deadline = time.monotonic() + 180  # kernels may be compiled
    while not (file.exists() and file.stat().st_size > 30_000):
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert json.loads((folder / RUN_NAME).read_text())["state"] == "running"
    killed = Made(folder, {})
    assert not killed.recording.complete
    outcome = killed.replay()
    assert outcome.identical
    assert outcome.warnings.messages == Recording(folder).check().notes != []
    recovered = recover(killed.recording)
    assert killed.recording.complete
    assert recovered.messages == sum(1 for _ in killed.recording.raw())
    assert killed.replay().steps == outcome.steps > 0


def test_a_snapshot_of_another_run_is_refused(made: Made, golden: Golden) -> None:
    taken = bytes(next(made.recording.messages({SNAPSHOTS})).message.data)
    with Run(load_experiment(made.folder, ["transfer_functions=[]"])) as run:
        with golden.raises(SnapshotError):
            run.restore(taken)
        for nonsense in (b"no pickle", pickle.dumps(5)):
            with golden.raises(SnapshotError):
                run.restore(nonsense)


BOX = """<sdf version="1.6"><model name="box"><link name="body">
<inertial><mass>1</mass></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>
<visual name="v"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></visual>
</link></model></sdf>"""


@pytest.fixture(scope="module", params=PAIRS, ids="-".join)
def changed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A run to which things were done from outside while it went on."""
    brain, world = request.param
    folder = tmp_path_factory.mktemp("changed")
    overrides = [*SETTINGS, f"brain.backend={brain}", f"world.backend={world}", "duration=2.4 s"]
    with FilesRead() as files, Run(load_experiment("braitenberg_husky", overrides)) as run:
        recording_folder = RecordingFolder(run, folder / "recording", files=files, snapshots_ns=S)
        listing = (Path(str(run.loop.functions[0].place.path)).parent / "listing1.py").read_text()
        run.run_until(0.6)
        (folder / "slower.py").write_text(listing.replace("20 * min", "5 * min"))
        run.change([folder / "slower.py"])
        run.world.call("/gazebo/spawn_sdf_model", "box", BOX)
        run.run_until(0.9)
        run.activate("linear_twist", False)
        run.reset("brain")
        run.run_until(1.4)
        run.activate("linear_twist")
        run.reset("robot")
        run.world.place("box", ModelMotion(Pose((0.5, 2.0, 0.5))))
        (folder / "slower.py").write_text(listing.replace("20 * min", "10 * min"))
        run.change([folder / "slower.py"])
        run.run_until(2.0)
        run.world.delete("box")
        run.change(remove=["linear_twist"])
        run.run()
        recording_folder.close("finished")
        assert recording_folder.warnings == []
    (folder / "slower.py").unlink()
    return Made(folder / "recording", {})


def test_actions_from_outside_are_repeated(changed: Made) -> None:
    outcome = changed.replay()
    assert (outcome.difference, outcome.steps, outcome.warnings) == (None, 120, [])
    names = {name for one in changed.recording.messages({MODEL_STATES}) for name in one.message.name}
    assert names == {"husky", "box"}


@pytest.mark.parametrize("from_s", [1.2, 2.2])
def test_it_goes_on_from_within_what_was_done_from_outside(changed: Made, from_s: float) -> None:
    assert changed.replay(ReplayRequest(from_ns=round(from_s * S))).difference is None


@pytest.mark.one_of(3)
@pytest.mark.parametrize("from_s", [1.2, 2.2])
def test_a_run_that_continues_from_a_snapshot_has_its_earlier_actions(
    changed: Made, from_s: float, tmp_path: Path
) -> None:
    folder, from_ns = tmp_path / "future", round(from_s * S)
    assert changed.replay(ReplayRequest(from_ns=from_ns, record=folder), verify=False).difference is None
    future = Made(folder, {})
    assert future.recording.run["state"] == "finished"
    whole, from_within = future.replay(), future.replay(ReplayRequest(from_ns=round(2.3 * S)))
    assert (whole.difference, whole.from_ns, whole.until_ns) == (None, from_ns, round(2.4 * S))
    assert from_within.difference is None


def test_edited_functions_take_the_place_of_those_that_were_changed(changed: Made, tmp_path: Path) -> None:
    edited, folder = changed.edited(tmp_path, "20 * min", "2 * min"), tmp_path / "future"
    request = ReplayRequest(
        from_ns=round(1.2 * S), until_ns=round(1.9 * S), functions=[edited], record=folder
    )
    outcome = changed.replay(request, verify=False)
    assert outcome.warnings.messages == [
        "from 1.2 s on the transfer functions are those of the files; changes made to them "
        "during the recorded run are left out"
    ]
    assert Made(folder, {}).replay().identical


def test_an_edited_file_may_lack_what_was_taken_away_later(changed: Made, tmp_path: Path) -> None:
    edited = changed.edited(tmp_path, "def linear_twist", "def twist")
    outcome = changed.replay(ReplayRequest(from_ns=S, functions=[edited]), verify=False)
    assert (outcome.error, outcome.until_ns) == (None, round(2.4 * S))


def test_an_action_that_a_replay_cannot_repeat_is_reported(tmp_path: Path, golden: Golden) -> None:
    @Neuron2Robot(Topic("/husky/cmd_vel", Twist))
    def stand(t: float) -> Twist:
        return Twist()

    folder = tmp_path / "recording"
    experiment = "braitenberg_husky", [*SETTINGS, "duration=0.2 s"]
    with FilesRead() as files, Run(load_experiment(*experiment)) as run:
        recording_folder = RecordingFolder(run, folder, files=files, snapshots_ns=S // 10)
        run.run_until(0.04)
        run.brain.add_sink(LeakyIntegratorAlpha(), [0], name="probe")
        run.step()
        run.change([stand], remove=["linear_twist"])
        run.run()
        recording_folder.close("finished")
        lost = [
            "a replay cannot repeat changes of devices of the brain from Python: probe",
            "a replay cannot repeat stand: only transfer functions from files are recorded",
        ]
        assert recording_folder.warnings.messages == lost
    outcome = Made(folder, {}).replay()
    assert outcome.warnings.messages == lost[:1]
    assert outcome.difference is not None
    assert outcome.difference.signal == "/brain/devices/probe/voltage"
    with golden.raises(SnapshotError):
        Made(folder, {}).replay(ReplayRequest(from_ns=S // 10))


@pytest.mark.parametrize("side", ["brain", "world"])
def test_a_recorded_side_knows_what_was_done_from_outside(changed: Made, side: str) -> None:
    assert changed.replay(ReplayRequest(recorded=frozenset({side}))).difference is None  # type: ignore[arg-type]
