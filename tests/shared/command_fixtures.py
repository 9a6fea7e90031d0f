"""Fixtures for tests of commands: the command line, in this process or in one of its own.

A ``conftest.py`` imports them beside those of ``experiment_fixtures``.
"""

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from nrp_core.cli import app, progress


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    code: int
    out: str
    err: str


@pytest.fixture
def experiment(fakes: None, drive_to_the_wall: Path) -> Path:
    """A folder with an experiment that passes, and the engines for it."""
    return drive_to_the_wall


@pytest.fixture
def nrp(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Done]:
    """Return a function that runs a command in this process."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    monkeypatch.setattr(progress, "PATIENCE_S", 600.0)  # a busy machine explains nothing between the lines

    def run(*arguments: Any) -> Done:
        capsys.readouterr()
        code = app.run_app([str(argument) for argument in arguments])
        return Done(code, *capsys.readouterr())

    return run


@pytest.fixture
def nrp_process() -> Callable[..., Done]:
    """Return a function that runs a command in a process of its own."""

    def run(*arguments: Any) -> Done:
        command = [sys.executable, "-m", "nrp_core", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
        return Done(done.returncode, done.stdout, done.stderr)

    return run
