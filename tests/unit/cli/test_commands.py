"""The commands around a run, and what all commands have in common."""

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from typer.main import get_command

from nrp_core._support.diagnosis import Diagnosis
from nrp_core.cli import app, main
from nrp_core.cli.app import CommandGroup
from nrp_core.cli.commands import COMMANDS, backends
from nrp_core.cli.survey import Surveyed
from nrp_core.errors import TopicError
from nrp_core.experiment.running.control import ControlServer
from nrp_core.recording.recording import Recording
from nrp_core.registry import Provider

Nrp = Callable[..., Any]


def surveyed(kind: str, name: str, **known: Any) -> Surveyed:
    known.setdefault("available", True)
    return Surveyed(kind, Provider(name, "some-package", "2.0", "module:Class"), **known)


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> list[Surveyed]:
    """What a survey finds: a list to be changed."""
    backends = [
        surveyed(
            "brain", "good", capabilities={"cells": ["A", "B"], "resolution_ns": None, "snapshot": True}
        ),
        surveyed("world", "bad", available=False, reason="no engine", remedy="pip install engine"),
    ]
    monkeypatch.setattr("nrp_core.cli.survey.survey", lambda **_: backends)
    return backends


def test_the_help_text_imports_nothing_heavy() -> None:
    program = (
        "import sys\nfrom nrp_core.cli.app import run_app\nrun_app(['--help'])\n"
        "heavy = {'numpy', 'numba', 'cv2', 'rich', 'rosbags', 'pyNN', 'matplotlib'}\n"
        "print(sorted(heavy & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    for command in COMMANDS:
        assert f"  {command} " in done.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_can_answer_in_json_and_is_explained(nrp: Nrp, command: str) -> None:
    done = nrp(command, "--help")
    assert done.code == 0
    assert "--json" in done.out


def test_a_misspelt_command_gets_a_hint(nrp: Nrp, golden: Golden) -> None:
    done = nrp("validte")
    assert done.code == 2
    assert "'validate'" in done.err
    golden(done.err)


def test_the_version_is_that_of_the_distribution(nrp: Nrp) -> None:
    assert nrp("--version").out.startswith("nrp-core ")


# -- validate


def test_a_valid_experiment_is_valid(nrp: Nrp, experiment: Path) -> None:
    done = nrp("validate", experiment)
    assert (done.code, done.out) == (0, "valid\n")


def test_a_second_value_for_an_option_that_takes_one_is_refused(
    nrp: Nrp, experiment: Path, golden: Golden
) -> None:
    done = nrp("run", experiment, "--until", "10 ms", "--until=20 ms")
    assert done.code == 2
    assert "'--until'" in done.err
    golden(done.err)


@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_ignores_the_first_of_two_values(nrp: Nrp, name: str) -> None:
    command = get_command(app.build_app()).get_command(None, name)
    options = [one for one in command.params if one.param_type_name == "option" and not one.is_flag]
    for option in options:
        if not option.multiple:
            done = nrp(name, option.opts[0], "1", option.opts[-1], "2")
            assert (done.code, "given twice, and it takes one value" in done.err) == (2, True), option.opts


def test_the_same_value_twice_is_refused(nrp: Nrp, experiment: Path, golden: Golden) -> None:
    done = nrp("validate", experiment, "-s", "seed=3", "--set", "seed=3")
    assert done.code == 2
    assert "'seed=3'" in done.err
    golden(done.err)
    assert nrp("validate", experiment, "-s", "seed=3", "-s", "duration=2 s").code == 0


def test_all_mistakes_are_reported_at_once(nrp: Nrp, experiment: Path) -> None:
    done = nrp("validate", experiment, "-s", "topics./a=nothing/Here", "-s", "duration=-1 s", "--json")
    data = json.loads(done.out)
    assert (done.code, data["valid"]) == (3, False)
    assert len(data["findings"]) == 2
    assert {finding["level"] for finding in data["findings"]} == {"error"}


def test_a_backend_that_is_missing_is_another_code_than_a_mistake(nrp: Nrp, experiment: Path) -> None:
    done = nrp("validate", experiment, "--brain", "nowhere")
    assert done.code == 4
    assert "'nowhere'" in done.err
    assert nrp("validate", experiment, "--brain", "nowhere", "-s", "timestp=1").code == 3


# -- publish


@pytest.fixture
def socket(tmp_path: Path) -> Any:
    """A socket on which a run listens, and what it was told to publish."""
    told: list[Any] = []

    def publish(topic: str, value: Any) -> None:
        if topic != "/glass":
            raise TopicError(f"no topic '{topic}'")
        told.append(value)

    path = tmp_path / "run.sock"
    with ControlServer(path, {"publish": publish}):
        yield path, told


@pytest.mark.parametrize(
    ("text", "value"), [("red", "red"), ("0.5", 0.5), ("{linear: {x: 1}}", {"linear": {"x": 1}}), ("-1", -1)]
)
def test_a_published_value_is_read_as_yaml(nrp: Nrp, socket: Any, text: str, value: object) -> None:
    path, told = socket
    assert nrp("publish", path, "/glass", "--", text).code == 0
    assert told == [value]


def test_a_published_value_that_is_not_yaml_is_a_wrong_call(nrp: Nrp, socket: Any) -> None:
    path, told = socket
    done = nrp("publish", path, "/glass", "{linear: [")
    assert (done.code, told) == (2, [])
    assert "VALUE: not YAML" in done.err


def test_a_command_that_the_run_refuses_exits_with_1(nrp: Nrp, socket: Any, tmp_path: Path) -> None:
    path, _ = socket
    done = nrp("publish", path, "/wall", "red")
    assert (done.code, done.err) == (1, "error: no topic '/wall'\n")
    assert nrp("publish", tmp_path / "nobody", "/glass", "red").code == 1


# -- backends and doctor


def test_backends_are_listed_with_what_they_have_or_why_not(nrp: Nrp, found: list[Surveyed]) -> None:
    out = nrp("backends").out
    assert "✓ brain good  some-package 2.0" in out
    assert "cells            A, B" in out
    assert "resolution       exact" in out
    assert "snapshot         yes" in out
    assert "✗ world bad  some-package 2.0\n    no engine; try: pip install engine" in out


def test_backends_in_json_say_the_same(nrp: Nrp, found: list[Surveyed]) -> None:
    good, bad = json.loads(nrp("backends", "--json").out)["backends"]
    assert (good["kind"], good["name"], good["available"], good["reason"]) == ("brain", "good", True, None)
    assert good["capabilities"]["cells"] == ["A", "B"]
    assert (bad["available"], bad["reason"], bad["remedy"]) == (False, "no engine", "pip install engine")
    assert (bad["distribution"], bad["version"]) == ("some-package", "2.0")


def test_the_doctor_says_no_if_no_world_can_run(nrp: Nrp, found: list[Surveyed]) -> None:
    done = nrp("doctor")
    assert done.code == 1
    assert "✗ no engine; try: pip install engine" in done.out
    assert done.out.endswith(
        "a brain and a world backend are required; at least one of them cannot run here\n"
    )


def test_the_doctor_reports_missing_parts_and_their_consequences(nrp: Nrp, found: list[Surveyed]) -> None:
    missing = Diagnosis("OpenGL", False, "cameras are slow", "apt-get install libgl1")
    found[1] = surveyed("world", "fine", diagnoses=(missing,))
    done = nrp("doctor")
    assert done.code == 0
    assert "✗ OpenGL: cameras are slow; try: apt-get install libgl1" in done.out
    data = json.loads(nrp("doctor", "--json").out)
    assert data["healthy"] is True
    assert data["machine"]["cores"] >= 1
    assert {one["subject"] for one in data["diagnoses"]} >= {"a display", "numpy"}
    assert data["backends"][1]["diagnoses"][0]["meaning"] == "cameras are slow"
    assert backends.doctor.__doc__


# -- schema and plot


def test_the_schema_is_a_json_schema(nrp: Nrp) -> None:
    schema = json.loads(nrp("schema", "experiment").out)
    assert schema["$schema"].startswith("https://json-schema.org/")
    assert "timestep" in schema["properties"]


def test_a_recording_is_drawn_later(nrp: Nrp, experiment: Path, tmp_path: Path) -> None:
    recording, figure = tmp_path / "recording", tmp_path / "figure.png"
    nrp("run", experiment, "--until", "100ms", "--record", recording)
    done = nrp("plot", recording, "-o", figure, "--json")
    assert json.loads(done.out) == {"figure": str(figure), "complete": True}
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert Recording(recording).complete
    assert nrp("plot", tmp_path / "nothing", "-o", figure).code == 2
    assert nrp("plot", recording, "-o", "figure.doc").code == 2


def test_an_interrupt_while_the_command_line_is_read_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object) -> list[str]:
        raise KeyboardInterrupt

    monkeypatch.setattr(CommandGroup, "parse_args", interrupted)
    assert app.run_app(["list"]) == 130
    assert capsys.readouterr().err == "error: interrupted\n"


def test_an_interrupt_while_the_program_is_still_being_read_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(app, "run_app", interrupted)
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    with pytest.raises(SystemExit, match="130"):
        main()
    assert capsys.readouterr().err == "error: interrupted\n"
