"""``nrp generate``."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import pytest

from nrp_core.cli.app import run_app

FOLDER = Path(experiment.__file__).parent
LISTING = FOLDER / "listing1.bibi"


def generate(*arguments: object) -> int:
    return run_app(["generate", *map(str, arguments)])


def test_it_prints_python(capsys: pytest.CaptureFixture[str]) -> None:
    assert generate(LISTING) == 0
    assert "def linear_twist(t, left_wheel_neuron, right_wheel_neuron):\n" in capsys.readouterr().out


def test_a_written_file_is_up_to_date_until_it_is_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = tmp_path / "made.py"
    assert generate(LISTING, "-o", made, "--check") == 1
    assert "differs from the output for" in capsys.readouterr().err
    assert not made.exists()
    assert generate(LISTING, "-o", made) == 0
    assert generate(LISTING, "-o", made, "--check") == 0
    made.write_text(made.read_text().replace("20", "21"))
    assert generate(LISTING, "-o", made, "--check") == 1


def test_python_becomes_a_model(capsys: pytest.CaptureFixture[str]) -> None:
    assert generate("--reverse", FOLDER / "listing1.py") == 0
    assert capsys.readouterr().out == LISTING.read_text()


def test_python_without_reverse_is_a_wrong_use(capsys: pytest.CaptureFixture[str]) -> None:
    assert generate(FOLDER / "listing1.py") == 2
    assert "--reverse" in capsys.readouterr().err


def test_an_unreadable_file_is_one_line_and_code_3(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = tmp_path / "broken.bibi"
    broken.write_text("<bibi>\n<transferFunction/></bibi>")
    assert generate(broken) == 3
    assert capsys.readouterr().err.startswith(f"error: {broken}:2: ")


def test_json_holds_the_text() -> None:
    command = [sys.executable, "-m", "nrp_core", "generate", str(LISTING), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["text"].endswith("linear=linear, angular=angular)\n")
