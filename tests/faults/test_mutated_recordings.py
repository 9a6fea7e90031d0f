"""A recording of real engines, changed at random: what is whole of it is used, and nothing else is.

Reading ends at the damage; recovery also keeps intact messages after it.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from mutations import Tally, mutated, numbered

from nrp_core.errors import ExperimentError, NrpError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.export import export
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import FILES_FOLDER, MCAP_NAME, RUN_NAME
from nrp_core.recording.reading.recover import recover
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.replay import Replay, ReplayRequest
from nrp_core.recording.writing import writer

FILES = (MCAP_NAME, MCAP_NAME, MCAP_NAME, RUN_NAME, "experiment.yaml", f"{FILES_FOLDER}/husky.sdf")
REPLAYED = 10
"""Every so many are run again."""


@pytest.fixture
def whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording with a chunk for each step."""
    monkeypatch.setattr(writer, "FLUSH_S", 0.0)
    settings = ["world.options.image_scale=0.05", "duration=0.2 s", "criteria=null"]
    with Run(load_experiment("braitenberg_husky", settings)) as run:
        recording_folder = RecordingFolder(run, tmp_path / "whole", snapshots_ns=100_000_000)
        run.run()
        recording_folder.close("finished")
    return tmp_path / "whole"


def contents(recording: Recording) -> list[tuple[str, int, bytes]]:
    return [(topic.name, message.log_time, message.data) for topic, message in recording.raw()]


def is_part(some: list[Any], whole: list[Any]) -> bool:
    """Return whether a list lacks only elements of another one, and has their order."""
    others = iter(whole)
    return all(one in others for one in some)


def test_a_mutated_recording_yields_its_intact_part_or_is_refused(whole: Path, tmp_path: Path) -> None:
    intact = contents(Recording(whole))
    folder, target = tmp_path / "mutated", tmp_path / "target"

    def is_clear(error: NrpError) -> bool:
        if isinstance(error, ExperimentError):
            return error.path is not None or str(folder) in str(error)
        return bool(str(error)) and "Traceback" not in str(error)

    def use(number: int) -> None:
        recording = Recording(folder)
        read = contents(recording)
        assert read == intact[: len(read)], "something else was read"
        assert not recording.complete or read == intact, "a part is taken for the whole"
        if not recording.complete:
            recovered = recover(recording, target / "recovered.mcap")
            kept = contents(Recording(recovered.file))
            assert kept[: len(read)] == read, "what can be read was not recovered"
            assert is_part(kept, intact), "something else was recovered"
            assert recovered.messages == len(kept)
            assert recovered.lost in {None, len(intact) - len(kept)}
        assert isinstance(recording.run, dict)
        export(recording, "csv", target / "csv")
        if number % REPLAYED == 0:
            with Replay(recording, ReplayRequest()) as replay:
                outcome = replay.verify()
            assert outcome.difference is None or "husky.sdf" in str(outcome.warnings), outcome

    tally = Tally("recording", is_clear)
    for number, random in numbered("recording"):
        for path in (folder, target):
            shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(whole, folder)
        target.mkdir()
        file = folder / random.choice(FILES)
        file.write_bytes(mutated(file.read_bytes(), random, text=file.suffix != ".mcap"))
        tally.take(number, lambda number=number: use(number))
    tally.check()
