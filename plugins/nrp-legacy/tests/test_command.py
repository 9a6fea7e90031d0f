"""Experiments of the platform on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nrp_core.cli import app


@pytest.fixture(autouse=True)
def _leave_stdout_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)


def result_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    missing = ["--allow-incomplete"] if arguments[0] == "run" else []  # rooms and robots that do not exist
    assert app.run_app([*arguments, *missing, "--json"]) == 0
    out = capsys.readouterr().out
    document: dict[str, object] = json.loads(out[out.index("{") :])
    return document


def test_a_folder_without_an_exc_file_is_not_imported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert app.run_app(["import", str(tmp_path), "-o", str(tmp_path / "out")]) == 3
    assert str(tmp_path) in capsys.readouterr().err


def test_a_folder_with_an_exc_file_runs(corpus: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = result_of(["run", str(corpus / "bare")], capsys)
    assert (result["experiment"], result["error"], result["sim_time_s"]) == ("bare", None, 0.1)
    assert (result["complete"], result["passed"]) == (False, None)
    assert app.run_app(["run", str(corpus / "bare")]) == 1


def test_models_are_looked_for_where_the_command_says(
    corpus: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    models, folder = str(corpus / "models"), corpus / "husky_2017"
    result = result_of(["run", str(folder), "--models", models, "--until", "0.1s"], capsys)
    assert list(result["final_pose"]) == ["robot"]  # type: ignore[call-overload]
    assert (folder / "csv" / "screen.csv").is_file()


def test_records_go_with_a_recording(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    models, record = str(corpus / "models"), tmp_path / "recording"
    exc = corpus / "husky_2019" / "cart.exc"
    result_of(["run", str(exc), "--models", models, "--until", "0.05s", "--record", str(record)], capsys)
    assert (record / "csv" / "spikes.csv").read_text().startswith("Time,Spikes,Simulation_reset\n0.0,")


def test_a_check_reports_what_is_missing_and_that_the_run_starts(
    corpus: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = result_of(["validate", str(corpus / "husky_2019"), "--models", str(corpus / "models")], capsys)
    assert result["valid"] is True
    assert "robot 'nowhere/model.sdf' not found: left out" in json.dumps(result["findings"])


def test_a_run_goes_on_to_the_end_of_a_step_of_any_length(
    corpus: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bibi = corpus / "bare" / "bare.bibi"
    bibi.write_text(bibi.read_text().replace("</bibi>", "<timestep>7</timestep></bibi>"))
    result = result_of(["run", str(corpus / "bare"), "--until", "30ms"], capsys)
    assert result["sim_time_s"] == 0.035


def test_an_import_executes_code_only_if_the_user_says_so(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bibi = corpus / "bare" / "bare.bibi"
    code = f"open({str(tmp_path / 'MARK')!r}, 'w').close()\n@nrp.Robot2Neuron()\ndef note(t):\n    pass\n"
    function = f'<transferFunction type="PythonTransferFunction">{code}</transferFunction>'
    bibi.write_text(bibi.read_text().replace("</bibi>", f"{function}</bibi>"))
    words = ["import", str(corpus / "bare"), "-o", str(tmp_path / "new")]
    assert app.run_app(words) == 2
    assert "--trust" in capsys.readouterr().err
    assert not (tmp_path / "MARK").exists()
    assert app.run_app([*words, "--trust"]) == 0
    assert (tmp_path / "MARK").exists()


def test_an_import_copies_nothing_from_outside_of_the_experiment_and_the_models(
    corpus: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its room is in a folder of somebody else, with notes beside it; a link leads to them, too."""
    foreign, notes = tmp_path / "foreign", tmp_path / "notes"
    foreign.mkdir()
    notes.mkdir()
    (notes / "note.txt").write_text("private")
    (foreign / "note.txt").write_text("private")
    exc = next((corpus / "bare").glob("*.exc"))
    text = exc.read_text()
    room = text.split('environmentModel src="', 1)[1].split('"', 1)[0]
    (foreign / "room.sdf").write_text('<sdf version="1.6"><world name="w"/></sdf>')
    words = ["import", str(corpus / "bare"), "--trust", "-o"]
    (exc.parent / "resources").mkdir(exist_ok=True)
    (exc.parent / "resources" / "notes").symlink_to(notes)
    assert app.run_app([*words, str(tmp_path / "two")]) == 0
    exc.write_text(text.replace(f'src="{room}"', f'src="{foreign}/room.sdf"'))
    assert app.run_app([*words, str(tmp_path / "one")]) == 3
    assert "foreign/room.sdf is not imported" in capsys.readouterr().err
    assert not list(tmp_path.glob("one/**/note.txt"))
    assert not list(tmp_path.glob("two/**/note.txt"))
