"""Two robots with brains of their own, on different backends, meet, and their runs can be repeated."""

import pytest

from nrp_core._support.used_files import FilesRead
from nrp_core.experiment import Run, load_experiment
from nrp_core.recording import Recording
from nrp_core.recording.folder.recording_folder import RecordingFolder, recorded_experiment
from nrp_core.recording.replay.replay import Replay, ReplayRequest, ReplayVerdict

S = 10**9


@pytest.mark.parametrize("backend", ["spinnaker", "event"])
def test_two_robots_with_brains_on_two_backends_meet(backend: str) -> None:
    given = [f"brain.options.parts.dog.backend={backend}", "duration=6 s"]
    if backend == "event":
        given.append("brain.options.parts.dog.options={resolution: 0.1 ms}")
    with Run(load_experiment("chase", given)) as run:
        run.run()
        assert run.result().passed


def test_a_chase_that_is_reset_or_restored_is_the_same_again() -> None:
    with Run(load_experiment("chase", ["duration=1.5 s"])) as run:
        run.run_until(0.7)
        snapshot = run.snapshot()
        run.run()
        whole = run.result().trajectory_digest
        run.restore(snapshot)
        run.run()
        assert run.result().trajectory_digest == whole
        run.reset()
        run.run()
        assert run.result().trajectory_digest == whole


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    folder = tmp_path_factory.mktemp("made") / "recording"
    with FilesRead() as files, Run(load_experiment("chase", ["duration=1.5 s"])) as run:
        written = RecordingFolder(run, folder, files=files, snapshots_ns=S // 2)
        run.run()
        written.close("finished")
    return Recording(folder)


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    "request_",
    [
        ReplayRequest(),
        ReplayRequest(from_ns=round(1.24 * S)),
        ReplayRequest(recorded=frozenset({"world"})),
        ReplayRequest(recorded=frozenset({"brain"})),
    ],
    ids=["whole", "from within", "world recorded", "brain recorded"],
)
def test_a_recorded_chase_is_verified(recording: Recording, request_: ReplayRequest) -> None:
    with FilesRead() as files, Replay(recording, request_, files=files) as again:
        outcome = again.verify()
    assert outcome.difference is None
    assert request_ != ReplayRequest() or outcome.verdict is ReplayVerdict.IDENTICAL


def test_parts_of_an_earlier_recording_do_what_their_backends_did(
    recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "parts.cat.options.integration" in recording.run["brain"]["options"]
    assert recorded_experiment(recording).brain.options["parts"]["cat"] == {"backend": "event"}
    monkeypatch.delitem(recording.run["brain"], "options")
    again = recorded_experiment(recording).brain.options["parts"]
    assert again["cat"] == {"backend": "event", "options": {"integration": "steps"}}
    assert again["dog"] == {"backend": "spinnaker"}
