"""What exists is replaced only on request: by commands, and by functions of Python."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError, NetworkError
from nrp_core.network.data import Network
from nrp_core.network.files import save_network
from nrp_core.recording.recording import Recording
from nrp_core.running import run

COMMANDS = {
    "plot": ("devices", "-o", "out.svg"),
    "video": ("--until", "0.1s", "-o", "out.webm"),
    "export": ("-f", "csv", "-o", "out.csv-tables"),
    "recover": ("-o", "out.mcap"),
}


@pytest.fixture
def recorded(nrp, experiment: Path, tmp_path: Path) -> Path:
    assert nrp("run", experiment, "--until", "0.2s", "--record", tmp_path / "recorded").code == 0
    return tmp_path / "recorded"


@pytest.mark.parametrize("command", COMMANDS)
def test_an_existing_target_of_a_command_stays_unless_it_is_to_be_replaced(
    nrp, recorded: Path, tmp_path: Path, command: str
) -> None:
    *options, name = COMMANDS[command]
    target = tmp_path / name
    first = nrp(command, recorded, *options, target)
    assert first.code == 0, first.err
    mine = target / "mine.txt" if target.is_dir() else target
    mine.write_text("precious")
    refused = nrp(command, recorded, *options, target)
    assert (refused.code, mine.read_text()) == (2, "precious")
    assert "--overwrite" in refused.err
    again = nrp(command, recorded, *options, target, "--overwrite")
    assert again.code == 0, again.err
    if target.is_dir():
        assert mine.read_text() == "precious", "files of others stay"
    else:
        assert mine.read_bytes() != b"precious"


def test_a_recording_replaces_a_recording_and_nothing_else(nrp, experiment: Path, tmp_path: Path) -> None:
    folder = tmp_path / "again"
    assert nrp("run", experiment, "--until", "0.1s", "--record", folder).code == 0
    assert nrp("run", experiment, "--until", "0.1s", "--record", folder).code == 2
    assert nrp("run", experiment, "--until", "0.04s", "--record", folder, "--overwrite").code == 0
    assert Recording(folder).run["result"]["steps"] == 2
    inside = folder / "experiment.yaml"
    assert nrp("run", inside, "--record", folder, "--overwrite").code != 0
    assert inside.exists(), "what the run reads is not removed"
    other = tmp_path / "other"
    other.mkdir()
    (other / "mine.txt").write_text("precious")
    assert nrp("run", experiment, "--record", other, "--overwrite").code == 2
    assert (other / "mine.txt").read_text() == "precious"


def test_functions_of_python_have_the_same_rule(experiment: Path, tmp_path: Path, golden: Golden) -> None:
    folder, figure = tmp_path / "run", tmp_path / "run.svg"
    for _ in range(2):
        result = run(experiment, until_s=0.1, record=folder, overwrite=True)
        result.recording.plot("devices", figure, overwrite=True)
    with golden.raises(ExperimentError):
        run(experiment, record=folder)
    with golden.raises(ExperimentError):
        result.recording.plot("devices", figure)
    save_network(Network({}), tmp_path / "net.nrpnet")
    save_network(Network({}), tmp_path / "net.nrpnet", overwrite=True)
    with golden.raises(NetworkError):
        save_network(Network({}), tmp_path / "net.nrpnet")
