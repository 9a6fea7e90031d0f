"""An experiment whose brain is a script of Brian2: checked in confinement, packed, repeated."""

import json
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level

Script = Callable[[str], Path]
EXPERIMENT = """
name: own
duration: 40 ms
timestep: 20 ms
brain: {backend: brian2, model: cells.py, native: true%s}
world: {backend: mujoco, scene: room.sdf}
"""


def experiment(script: Script, end: str = "run(1*second)\n", more: str = "") -> Path:
    """Write an experiment with that script, and return its file."""
    folder = script(end).parent
    (folder / "room.sdf").write_text('<sdf version="1.9"><world name="room"/></sdf>')
    (folder / "experiment.yaml").write_text(EXPERIMENT % more)
    return folder / "experiment.yaml"


def messages(file: Path) -> list[str]:
    return [one.message for one in validate_file(file) if one.level is not Level.NOTE]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="confinement needs Linux")
def test_a_check_executes_the_script_without_rights(
    script: Script, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scratch").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "scratch"))  # pytest's own folders are temporary files too
    file = experiment(script, "open(__file__ + '.side', 'w')\nrun(1*second)\n")
    (message,) = messages(file)
    assert "a check executes the script without network access" in message
    assert not (tmp_path / "cells.py.side").exists()
    (message,) = messages(experiment(script))
    assert "no other brain backend" in message


def test_parameters_of_a_script_are_refused(script: Script) -> None:
    (message,) = messages(experiment(script, more=", parameters: {gain: 2}"))
    assert "'native' script has no parameters" in message


@pytest.mark.slow
def test_an_archive_has_the_script_and_repeats_its_run(nrp: Any, script: Script, tmp_path: Path) -> None:
    target = tmp_path / "own.zip"
    done = nrp("paper", experiment(script), "--seeds", 1, "--jobs", 1, "-o", target, "--json")
    assert done.code == 0
    with zipfile.ZipFile(target) as packed:
        assert any(name.endswith("/cells.py") for name in packed.namelist())
    done = nrp("paper", target, "--verify", "--json")
    assert [(one["outcome"], one["steps"]) for one in json.loads(done.out)["runs"]] == [("identical", 2)]
