"""A recording damaged at random bytes: a clear error or what is whole of it, never a wrong or deep answer."""

import io
import shutil
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.cli.app import run_app
from nrp_core.cli.session import RunRequest, Session
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME
from nrp_core.recording.recording import Recording
from nrp_core.recording.writing import writer

FILES = (MCAP_NAME, RUN_NAME, "experiment.yaml", "experiment/room.sdf")
CASES = {"inspect": 16, "recover": 16, "export": 16, "plot": 6, "replay": 6}
"""How many damaged recordings each command reads; the last two take longer."""


@pytest.fixture
def whole(fakes: None, drive_to_the_wall: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording of engines that simulate nothing, a chunk for each step."""
    monkeypatch.setattr(writer, "FLUSH_S", 0.0)
    folder = tmp_path / "whole"
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        Session(RunRequest(str(drive_to_the_wall), [], "0.4s", folder)).run(as_json=False)
    return folder


def nrp(*arguments: object) -> tuple[int, str]:
    said = io.StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        code = run_app([str(argument) for argument in arguments])
    return code, said.getvalue()


def arguments_of(command: str, folder: Path, target: Path) -> list[object]:
    return {
        "inspect": ["inspect", folder],
        "recover": ["recover", folder],
        "export": ["export", folder, "-f", "csv", "-o", target / "csv"],
        "plot": ["plot", folder, "devices", "-o", target / "figure.svg"],
        "replay": ["replay", folder, "--verify"],
    }[command]  # type: ignore[return-value]


def damaged(data: bytes, draw: st.DrawFn) -> bytes:
    """Return the bytes with some changed, cut out, put in, or the end missing."""
    place = draw(st.integers(0, len(data) - 1))
    some = draw(st.binary(min_size=1, max_size=30))
    match draw(st.sampled_from(["change", "cut out", "put in", "end"])):
        case "change":
            return data[:place] + some + data[place + len(some) :]
        case "cut out":
            return data[:place] + data[place + len(some) :]
        case "put in":
            return data[:place] + some + data[place:]
    return data[:place]


@pytest.mark.one_of(6)
@pytest.mark.slow
@pytest.mark.parametrize("command", CASES)
def test_damage_anywhere_is_reported_or_the_intact_part_is_used(
    whole: Path, tmp_path: Path, command: str
) -> None:
    counts: Counter[bool] = Counter()
    intact = {topic.name: [] for topic, _ in Recording(whole).raw()}
    for topic, message in Recording(whole).raw():
        intact[topic.name].append((message.log_time, message.data))

    @settings(max_examples=CASES[command], suppress_health_check=list(HealthCheck))
    @given(st.data())
    def check(data: st.DataObject) -> None:
        folder, target = tmp_path / "damaged", tmp_path / "target"
        for path in (folder, target):
            shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(whole, folder)
        target.mkdir()
        file = folder / data.draw(st.sampled_from(FILES))
        file.write_bytes(data.draw(st.composite(lambda draw: damaged(file.read_bytes(), draw))()))
        code, said = nrp(*arguments_of(command, folder, target))
        assert code in (0, 1, 3, 4), said
        assert "mistake in the program" not in said, said
        assert "Traceback" not in said, said
        counts[code == 0] += 1
        for topic, message in Recording(folder).raw():
            assert (message.log_time, message.data) in intact[topic.name]

    check()
    assert counts.total() >= CASES[command]
    if CASES[command] > 10:  # enough for some whose damage does not matter to the command
        assert counts[True]
