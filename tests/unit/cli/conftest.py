"""The command line, in this process or in one of its own, with engines that simulate nothing."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from nrp_core.cli import app

FAKES = Path(__file__).parents[1] / "experiment" / "fakes"


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    code: int
    out: str
    err: str


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of installed packages: the brain ``counting``, the world ``disc``; and a cache of its own."""
    folder = tmp_path / "site"
    entry_points = (
        "[nrp_core.brain]\ncounting = experiment_fakes:CountingBackend\nbroken = no_such_module:Backend\n"
        "[nrp_core.world]\ndisc = experiment_fakes:DiscBackend\n"
    )
    install(folder, "fakes", entry_points)
    for path in (FAKES, folder):
        monkeypatch.syspath_prepend(path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), str(FAKES)]))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return folder


@pytest.fixture
def install_fake(site: Path) -> Callable[..., None]:
    """Return a function that installs a package: its entry points and the source of its one module."""

    def installed(name: str, entry_points: str, source: str = "") -> None:
        install(site, name, entry_points)
        (site / f"{name}.py").write_text(source)

    return installed


def install(folder: Path, name: str, entry_points: str) -> None:
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(entry_points)


@pytest.fixture
def experiment(tmp_path: Path, site: Path) -> Path:
    """A folder with an experiment: a robot drives to a wall that turns red, and passes."""
    folder = tmp_path / "drive"
    shutil.copytree(FAKES, folder, ignore=shutil.ignore_patterns("__pycache__", "experiment_fakes.py"))
    return folder


@pytest.fixture
def nrp(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Done]:
    """Return a function that runs a command in this process."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def run(*arguments: Any) -> Done:
        capsys.readouterr()
        code = app.run_app([str(argument) for argument in arguments])
        return Done(code, *capsys.readouterr())

    return run


@pytest.fixture
def nrp_process(site: Path) -> Callable[..., Done]:
    """Return a function that runs a command in a process of its own."""

    def run(*arguments: Any) -> Done:
        command = [sys.executable, "-m", "nrp_core", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
        return Done(done.returncode, done.stdout, done.stderr)

    return run
