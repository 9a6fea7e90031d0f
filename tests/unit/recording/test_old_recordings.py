"""Recordings of earlier versions: they replay, or one sentence names the version that made them."""

import json
import shutil
from pathlib import Path

import pytest

from nrp_core.errors import ExperimentError
from nrp_core.recording.reading.recording import DIGEST, Recording, digest_of
from nrp_core.recording.replay.replay import Replay, ReplayRequest

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


@pytest.mark.parametrize("format_", [2, 4])
def test_a_recording_in_another_format_is_refused_with_the_version_that_made_it(
    tmp_path: Path, format_: int
) -> None:
    shutil.copytree(RECORDINGS / "plain_0.1.0", folder := tmp_path / "other")
    about = json.loads((folder / "run.json").read_text())
    about["format"] = format_
    about["distributions"]["nrp-core"] = "7.2.0"
    about[DIGEST] = digest_of(about)
    (folder / "run.json").write_text(json.dumps(about))
    with pytest.raises(ExperimentError, match=rf"nrp-core 7\.2\.0 in format {format_}; this version replays"):
        Replay(Recording(folder), ReplayRequest())
