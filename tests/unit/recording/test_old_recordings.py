"""Recordings of earlier versions: they replay, or one sentence names the version that made them."""

import json
import shutil
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError
from nrp_core.recording.layout import Role
from nrp_core.recording.reading.integrity import ChainCheck
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest
from nrp_core.recording.sealing import seal

RECORDINGS = Path(__file__).parents[2] / "recordings"
S = 10**9


@pytest.mark.usefixtures("fakes")
@pytest.mark.parametrize("name", ["plain_0.1.0", "changed_0.1.0"])
def test_a_recording_of_version_0_1_0_replays_bit_for_bit(name: str) -> None:
    with Replay(Recording(RECORDINGS / name), ReplayRequest()) as again:
        outcome = again.verify()
    assert outcome.identical
    assert outcome.steps == 50
    assert (outcome.from_ns, outcome.until_ns) == (0, S)
    files = "recording.mcap and experiment.yaml"
    note = f"the recording has no digest of {files}, because an earlier version made it"
    assert outcome.warnings[0].message == note


@pytest.mark.parametrize("name", ["plain_0.1.0", "changed_0.1.0"])
def test_the_messages_of_version_0_1_0_are_checked_against_their_hashes(name: str) -> None:
    check = Recording(RECORDINGS / name).check()
    assert check.chain == ChainCheck(50, S)
    assert (check.flaws, check.undigested, check.intact) == ((), ("recording.mcap", "experiment.yaml"), False)


@pytest.mark.parametrize("format_", [2, 5])
def test_a_recording_in_another_format_is_refused_with_the_version_that_made_it(
    tmp_path: Path, format_: int, golden: Golden
) -> None:
    shutil.copytree(RECORDINGS / "plain_0.1.0", folder := tmp_path / "other")
    about = json.loads((folder / "run.json").read_text())
    about["format"] = format_
    about["distributions"]["nrp-core"] = "7.2.0"
    (folder / "run.json").write_bytes(seal(about))
    with golden.raises(ExperimentError, match=rf"7\.2\.0.*{format_}"):
        Replay(Recording(folder), ReplayRequest())


@pytest.mark.usefixtures("fakes")
def test_a_replay_keeps_images_as_the_recording_did_under_the_old_name_of_the_setting(tmp_path: Path) -> None:
    shutil.copytree(RECORDINGS / "plain_0.1.0", folder := tmp_path / "old")
    about = json.loads((folder / "run.json").read_text())
    assert about["pictures"] == "exact"
    about["pictures"] = "off"
    (folder / "run.json").write_bytes(seal(about))
    request = ReplayRequest(until_ns=S // 10, record=tmp_path / "new")
    with Replay(Recording(folder), request) as again:
        again.verify()
    assert Recording(tmp_path / "new").run["images"] == "off"


def test_a_role_or_a_topic_that_is_none_is_refused(golden: Golden) -> None:
    recording = Recording(RECORDINGS / "plain_0.1.0")
    assert recording.with_role("published") == recording.with_role(Role.PUBLISHED)  # type: ignore[arg-type]
    with golden.raises(ExperimentError, match="'publishd'.*'published'"):
        recording.with_role("publishd")  # type: ignore[arg-type]
    with golden.raises(ExperimentError, match=r"\['/a'\]"):
        recording.frame(["/a"])  # type: ignore[arg-type]
